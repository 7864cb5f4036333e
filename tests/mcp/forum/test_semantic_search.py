"""Search by meaning as a tool: the mode exists only if the forum supports it."""

from __future__ import annotations

import json
from typing import Any

import pytest
from mcp.client.client import Client

from agentrob.forums.memory.forum import MemoryForum, MemoryWorld
from agentrob.mcp.forum.identity import Rights
from tests.board.search.encoder_double import Concepts
from tests.mcp.forum.inside import ALL, server_of


async def asked(world: MemoryWorld, *calls: dict[str, Any]) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Return the arguments of search_posts and its result."""
    server, accounts = server_of(world, "alice", Rights(True, ALL))
    async with Client(server.engine, cache=None) as client:
        listed = (await client.list_tools()).tools
        size = len(json.dumps([t.model_dump(by_alias=True, exclude_none=True, mode="json") for t in listed]))
        assert size <= 9_000, f"{size} bytes"
        (tool,) = (t for t in listed if t.name == "search_posts")
        answers = [(await client.call_tool("search_posts", call)).structured_content for call in calls]
    await accounts.close()
    return tool.input_schema["properties"], answers


@pytest.fixture
async def post() -> tuple[MemoryWorld, str]:
    world = MemoryForum.world()
    world.encoder = Concepts()
    alice = world.sign_in("alice")
    written = (await alice.create_topic("robots", "a", "a weary hound", key="1")).post
    await alice.reply(written.topic_id, "a hound in the rain", key="2")
    return world, written.id


async def test_with_an_encoder_posts_are_found_by_meaning(post: tuple[MemoryWorld, str]) -> None:
    world, near = post
    query = {"query": "tired dog", "limit": 1}
    takes, (words, alike) = await asked(world, query, {**query, "mode": "meaning"})
    assert takes["mode"]["enum"] == ["words", "meaning"]
    assert words["data"]["posts"] == []
    assert [p["id"] for p in alike["data"]["posts"]] == [near]
    _, (rest, wrong) = await asked(
        world,
        {**query, "mode": "meaning", "cursor": alike["data"]["next"]},
        {**query, "cursor": alike["data"]["next"]},
    )
    assert len(rest["data"]["posts"]) == 1
    assert rest["data"]["posts"][0]["id"] != near
    assert not wrong["ok"], "the cursor of one mode is none of the other"


async def test_without_an_encoder_the_argument_does_not_exist(post: tuple[MemoryWorld, str]) -> None:
    world, _ = post
    world.encoder = None
    takes, (refused, words) = await asked(world, {"query": "dog", "mode": "meaning"}, {"query": "hound"})
    assert "mode" not in takes
    assert refused["error"]["code"] == "invalid_arguments"
    assert len(words["data"]["posts"]) == 2
