"""Search by meaning through the adapters, on forums that support it and on forums that do not."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from agentrob.board.search import embeddings
from agentrob.config.forum import ForumConfig
from agentrob.errors import ForumNotFound, ForumUnoffered
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.forums.memory.forum import MemoryForum
from agentrob.forums.protocol import SemanticSearcher
from tests.board.running_board import LIMIT_S, RunningBoard, running_board
from tests.board.search.encoder_double import Concepts


def at(board: RunningBoard) -> BoardForum:
    return BoardForum(ForumConfig(kind="board", url=board.url), board.tokens["op"])


async def test_our_board_pages_search_by_meaning(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(embeddings, "POLL_S", 0.02)
    with running_board(tmp_path, encoder=Concepts) as board:
        forum = at(board)
        assert isinstance(forum, SemanticSearcher)
        assert await forum.has_semantic_search()
        near = (await forum.create_topic("talk", "a", "a weary hound", key="1")).post
        far = (await forum.create_topic("talk", "b", "a hound in the rain", key="2")).post
        end_s = time.monotonic() + LIMIT_S
        while len((page := await forum.search_semantic("tired dog")).items) < 2:
            assert time.monotonic() < end_s
        assert [p.id for p in page.items] == [near.id, far.id]
        first = await forum.search_semantic("tired dog", board_id="talk", limit=1)
        rest = await forum.search_semantic("tired dog", board_id="talk", limit=1, cursor=first.next)
        assert [p.id for p in (*first.items, *rest.items)] == [near.id, far.id]
        assert rest.next is None
        assert (await forum.search_semantic("tired dog", board_id="robots")).items == ()
        await forum.close()


async def test_a_board_without_search_by_meaning_says_so(tmp_path: Path) -> None:
    with running_board(tmp_path) as board:
        forum = at(board)
        assert not await forum.has_semantic_search()
        with pytest.raises(ForumUnoffered, match=r"agentrob\[semantic\]"):
            await forum.search_semantic("a dog")
        await forum.close()


async def test_the_memory_forum_searches_by_meaning_with_an_encoder() -> None:
    alice = MemoryForum.world(encoder=Concepts()).sign_in("alice")
    assert isinstance(alice, SemanticSearcher)
    assert await alice.has_semantic_search()
    near = (await alice.create_topic("robots", "a", "a weary hound", key="1")).post
    far = (await alice.reply(near.topic_id, "a hound in the rain", key="2")).post
    await alice.reply(near.topic_id, "a car", key="3")
    first = await alice.search_semantic("tired dog", limit=1)
    rest = await alice.search_semantic("tired dog", limit=1, cursor=first.next)
    assert [p.id for p in (*first.items, *rest.items)] == [near.id, far.id]
    assert rest.next is None
    with pytest.raises(ForumNotFound):
        await alice.search_semantic("dog", board_id="nowhere")
    plain = MemoryForum.world().sign_in("alice")
    assert not await plain.has_semantic_search()
    with pytest.raises(ForumUnoffered):
        await plain.search_semantic("dog")
