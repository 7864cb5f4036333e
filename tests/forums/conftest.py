"""Forums for tests: NodeBB (a recording or a real server; see the contract test) and the double of Discourse."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from agentrob.forums.discourse.forum import DiscourseForum
from tests.forums.discourse.discourse_world import DiscourseWorld, Double, Worlds, double_world, write
from tests.forums.nodebb.nodebb_tape import Player, Recorder, Tape, serving
from tests.forums.nodebb.nodebb_world import ADMIN, NodeBBWorld, prepared

TAPES = Path(__file__).parent / "nodebb" / "nodebb_tapes"
RECORD = os.environ.get("AGENTROB_TEST_NODEBB_RECORD", "")
URL = os.environ.get("AGENTROB_TEST_NODEBB_URL", "")


@pytest.fixture
async def nodebb(request: pytest.FixtureRequest) -> AsyncIterator[NodeBBWorld]:
    path = TAPES / f"{request.node.name}.jsonl"
    server = Recorder(URL) if RECORD else Player(Tape.load(path))
    if RECORD:
        await prepared(URL, ADMIN)
    async with serving(server) as url:
        world = NodeBBWorld(url, ADMIN, server=server)
        yield world
        await world.close()
    if isinstance(server, Recorder):
        server.tape.save(path)
    else:
        assert server.unknown == [], "the adapter asks what was not recorded: record the tapes anew"


# ---------------------------------------------------------------- the double of Discourse
@pytest.fixture
async def discourse() -> AsyncIterator[Worlds]:
    async with double_world() as found:
        yield found


@pytest.fixture
def world(discourse: Worlds) -> DiscourseWorld:
    return discourse[0]


@pytest.fixture
def double(discourse: Worlds) -> Double:
    return discourse[1]


@pytest.fixture
async def robot(world: DiscourseWorld) -> DiscourseForum:
    return await world.sign_in("quadruped")


@pytest.fixture
def topic(double: Double) -> int:
    return write(double.site, title="A topic", category=2, raw="the first post").topic
