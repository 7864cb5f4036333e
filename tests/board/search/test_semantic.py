"""Search by meaning: its results, who may see them, and that the index follows every change of a post."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence

import pytest
from sqlalchemy import func, select, update

from agentrob.board.admin import local_admin, moderation
from agentrob.board.admin.moderation import erase_content
from agentrob.board.content.writes import add_event
from agentrob.board.db import schema as db
from agentrob.board.db.database import open_engine
from agentrob.board.db.records import now_us
from agentrob.board.db.writer import Transaction
from agentrob.board.search import embeddings
from agentrob.model import EventKind
from agentrob.semantic.encoder import MODEL
from tests.board.running_board import LIMIT_S, RunningBoard, running_board
from tests.board.search.encoder_double import Concepts


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(embeddings, "POLL_S", 0.02)
    monkeypatch.setattr(embeddings, "AGAIN_S", 0.02)


@pytest.fixture(scope="module")
def talk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningBoard]:
    with running_board(tmp_path_factory.mktemp("board"), encoder=Concepts) as board:
        yield board


def say(board: RunningBoard, body: str, by: str = "member", title: str = "t", on: str = "talk") -> str:
    made = board.client(by).post("/topics", json={"board_id": on, "title": title, "body": body})
    assert made.status_code == 201, made.text
    post: str = made.json()["post"]["id"]
    return post


def found(forum: RunningBoard, query: str, by: str = "op", **params: str | int) -> list[str]:
    answer = forum.client(by).get("/search", params={"q": query, "mode": "meaning", **params})
    assert answer.status_code == 200, answer.text
    return [post["id"] for post in answer.json()["items"]]


def until(board: RunningBoard, holds: Callable[[], bool]) -> None:
    """Wait for the indexer, which runs in parallel with the board."""
    end_s = time.monotonic() + LIMIT_S
    while not holds():
        assert time.monotonic() < end_s, "it never came to hold"
        board.client().get("/me")


def vectors(board: RunningBoard) -> dict[int, int]:
    """Return for each post the version whose vector is in the database."""
    engine = open_engine(board.settings, writes=False)
    m = embeddings.post_meanings.c
    with engine.connect() as connection:
        kept = {r.post_id: r.version for r in connection.execute(select(m.post_id, m.version).where(m.model == MODEL))}
    engine.dispose()
    return kept


# -------------------------------------------------------------------- results
def test_posts_are_found_by_meaning_across_languages_best_match_first(talk: RunningBoard) -> None:
    near = say(talk, "a weary hound")
    far = say(talk, "a hound in the rain")
    until(talk, lambda: found(talk, "exhausted dog") == [near, far])
    assert found(talk, "狗累") == [near, far]
    assert found(talk, "automobile") == []
    words = talk.client("op").get("/search", params={"q": "exhausted dog"}).json()
    assert words["items"] == [], "words are looked for unless meaning is asked for"


def test_the_vector_of_a_first_post_includes_the_title(talk: RunningBoard) -> None:
    post = say(talk, "look", title="Automobile")
    until(talk, lambda: found(talk, "vehicle") == [post])


def test_paging_continues_where_the_last_page_ended(talk: RunningBoard) -> None:
    posts = {say(talk, f"电池 {n}") for n in range(5)}
    until(talk, lambda: set(found(talk, "power")) == posts)
    client, pages, cursor = talk.client("op"), list[list[str]](), ""
    while cursor is not None:
        asked = {"q": "power", "mode": "meaning", "limit": 2, **({"cursor": cursor} if cursor else {})}
        page = client.get("/search", params=asked).json()
        pages.append([p["id"] for p in page["items"]])
        cursor = page["next"]
    assert [len(p) for p in pages] == [2, 2, 1]
    assert {i for p in pages for i in p} == posts
    assert client.get("/search", params={"q": "power", "mode": "meaning", "cursor": "ffffff"}).json()["items"] == []


@pytest.mark.parametrize("query", ["", "  ", '"', "😀", "\0", "x" * 200])
def test_a_query_without_meaning_finds_nothing(talk: RunningBoard, query: str) -> None:
    assert found(talk, query) == []


# -------------------------------------------------------------------- changes of posts
def test_an_edit_replaces_the_meaning_of_a_post_at_once(
    fresh_board: Callable[..., RunningBoard],
) -> None:
    made: list[Concepts] = []
    board = fresh_board(encoder=lambda: made.append(Concepts()) or made[-1])
    post = say(board, "a puppy")
    until(board, lambda: found(board, "dog") == [post])
    made[0].asked.clear()
    board.client("member").patch(f"/posts/{post}", json={"body": "a car"}).raise_for_status()
    assert found(board, "dog") == []
    until(board, lambda: found(board, "vehicle") == [post])
    until(board, lambda: vectors(board) == {int(post): 2})
    assert found(board, "dog") == []


def test_hidden_posts_are_not_found_until_they_are_shown_again(talk: RunningBoard) -> None:
    post = say(talk, "hike hike hike")
    until(talk, lambda: post in found(talk, "stroll"))
    talk.client("admin").post(f"/posts/{post}/hide", json={}).raise_for_status()
    assert post not in found(talk, "stroll")
    talk.client("admin").post(f"/posts/{post}/show", json={}).raise_for_status()
    until(talk, lambda: post in found(talk, "stroll"))
    talk.client("member").delete(f"/posts/{post}").raise_for_status()
    assert post not in found(talk, "stroll")


def test_erased_posts_leave_no_vectors(talk: RunningBoard) -> None:
    talk.add("carol")
    post = say(talk, "puppy puppy", by="carol")
    until(talk, lambda: int(post) in vectors(talk))
    talk.run(erase_content(talk.services, "admin", "carol"))
    assert int(post) not in vectors(talk)
    assert post not in found(talk, "dog")


def test_a_post_erased_during_encoding_gets_no_vector(fresh_board: Callable[..., RunningBoard]) -> None:
    begun, go_on = threading.Event(), threading.Event()

    class Slow(Concepts):
        def encode(self, texts: Sequence[str]) -> list[bytes]:
            begun.set()
            assert go_on.wait(LIMIT_S)
            return super().encode(texts)

    board = fresh_board(encoder=Slow)
    say(board, "a puppy")
    assert begun.wait(LIMIT_S)
    with local_admin.writing(board.settings) as connection:
        moderation.erase(Transaction(connection), "shell", "member")
    go_on.set()
    other = say(board, "a car", by="op")
    until(board, lambda: found(board, "vehicle") == [other])
    assert list(vectors(board)) == [int(other)]


def test_posts_on_unreadable_boards_are_not_found(talk: RunningBoard) -> None:
    token = local_admin.issue_token(
        talk.settings, local_admin.find_account(talk.settings, "admin"), scopes=("read", "write", "admin")
    )
    staff = {"id": "staff", "name": "Staff", "read_role": "operator", "post_role": "operator"}
    made = talk.client().post("/admin/boards", json=staff, headers={"Authorization": f"Bearer {token}"})
    assert made.status_code < 300, made.text
    secret, shown = say(talk, "automobile automobile", by="op", on="staff"), say(talk, "a vehicle for everybody")
    until(talk, lambda: {secret, shown} <= set(found(talk, "car")))
    assert secret in found(talk, "car", board_id="staff")
    assert shown not in found(talk, "car", board_id="staff")
    assert secret not in found(talk, "car", by="member")
    assert shown in found(talk, "car", by="member")
    assert found(talk, "car", by="member", board_id="staff") == []
    assert talk.client().get("/search", params={"q": "car", "mode": "meaning"}).status_code == 401


def test_posts_of_other_processes_and_older_posts_are_indexed_once(
    fresh_board: Callable[..., RunningBoard], tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("again")
    with running_board(folder) as board:  # as long as nobody used the search
        old = say(board, "an old hound")
        database = board.settings.database
        assert vectors(board) == {}
    with running_board(folder, encoder=Concepts, database=database) as board:
        until(board, lambda: found(board, "dog") == [old])
        until(board, lambda: list(vectors(board)) == [int(old)])
    made: list[Concepts] = []
    with running_board(folder, encoder=lambda: made.append(Concepts()) or made[-1], database=database) as board:
        until(board, lambda: found(board, "dog") == [old])
        assert set(made[0].asked) == {"dog"}
        with local_admin.writing(board.settings) as connection:  # what the command line does
            connection.execute(update(db.posts).values(raw="a car", version=db.posts.c.version + 1))
            add_event(Transaction(connection), EventKind.POST_EDITED, now_us(), topic_id=1, post_id=int(old))
        until(board, lambda: found(board, "vehicle") == [old])


# -------------------------------------------------------------------- isolation from other functions
def test_without_an_encoder_the_forum_names_what_is_missing_and_offers_word_search(board: RunningBoard) -> None:
    refused = board.client("op").get("/search", params={"q": "dog", "mode": "meaning"})
    assert (refused.status_code, refused.json()["code"]) == (404, "no_meaning")
    assert "agentrob[semantic]" in refused.json()["hint"]
    assert board.client("op").get("/search/modes").json() == {"items": ["words"]}
    assert 'name="by"' not in board.browser("op").get("/search").text
    assert board.client("op").get("/search", params={"q": "dog", "mode": "smell"}).status_code == 422


def test_the_page_offers_search_by_meaning_if_available(talk: RunningBoard) -> None:
    post = say(talk, "power power")
    until(talk, lambda: post in found(talk, "battery"))
    assert talk.client("op").get("/search/modes").json() == {"items": ["words", "meaning"]}
    page = talk.browser("op").get("/search", params={"q": "battery", "by": "meaning"}).text
    assert 'value="meaning" checked' in page
    assert f'href="/p/{post}"' in page
    assert f'href="/p/{post}"' not in talk.browser("op").get("/search", params={"q": "battery"}).text


def test_a_failing_encoder_is_reported_and_affects_nothing_else(fresh_board: Callable[..., RunningBoard]) -> None:
    model = Concepts()
    board = fresh_board(encoder=lambda: model)
    model.out.set()
    post = say(board, "a puppy")
    refused = board.client("op").get("/search", params={"q": "dog", "mode": "meaning"})
    assert (refused.status_code, refused.json()["code"]) == (503, "model_out")
    assert board.client("op").get("/search", params={"q": "puppy"}).json()["items"][0]["id"] == post
    model.out.clear()
    until(board, lambda: found(board, "dog") == [post])


def test_law_15_posts_and_stops_do_not_wait_for_the_encoder(fresh_board: Callable[..., RunningBoard]) -> None:
    begun, go_on = threading.Event(), threading.Event()

    class Stuck(Concepts):
        def encode(self, texts: Sequence[str]) -> list[bytes]:
            begun.set()
            assert go_on.wait(LIMIT_S)
            return super().encode(texts)

    board = fresh_board(encoder=Stuck)
    post = say(board, "a puppy")
    assert begun.wait(LIMIT_S)
    say(board, "another")
    assert board.client("op").post("/robots/quadruped/stop").status_code < 300
    assert vectors(board) == {}
    go_on.set()
    until(board, lambda: found(board, "dog") == [post])


def test_search_continues_until_enough_readable_posts_are_found(
    talk: RunningBoard, monkeypatch: pytest.MonkeyPatch
) -> None:
    from agentrob.board.search import semantic

    monkeypatch.setattr(semantic, "_ASKED", 3)
    hidden = [say(talk, "weary " * 9) for _ in range(7)]
    shown = say(talk, "weary of rain")
    until(talk, lambda: {shown, *hidden} <= set(found(talk, "tired", limit=100)))
    for post in hidden:
        talk.client("member").delete(f"/posts/{post}").raise_for_status()
    assert found(talk, "tired", limit=1)[:1] != []
    assert shown in found(talk, "tired", limit=100)
    assert not set(hidden) & set(found(talk, "tired", limit=100))


def test_each_post_has_one_vector_however_many_posts_there_are(talk: RunningBoard) -> None:
    posts = [say(talk, f"number {n}") for n in range(20)]
    until(talk, lambda: {int(p) for p in posts} <= vectors(talk).keys())
    engine = open_engine(talk.settings, writes=False)
    with engine.connect() as connection:
        count = connection.execute(select(func.count()).select_from(embeddings.post_meanings)).scalar_one()
    engine.dispose()
    assert count == len(vectors(talk))
