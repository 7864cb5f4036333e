"""A NodeBB for a test: what a real one answered, played back; or a real one, recorded (see the contract's test)."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from nodebb_tape import Player, Recorder, Tape, serving
from nodebb_world import NodeBBWorld

TAPES = Path(__file__).parent / "nodebb_tapes"
RECORD = os.environ.get("AGENTROB_TEST_NODEBB_RECORD", "")
URL = os.environ.get("AGENTROB_TEST_NODEBB_URL", "")
ADMIN = os.environ.get("AGENTROB_TEST_NODEBB_ADMIN", "") or "login:admin:on the tape"


@pytest.fixture
async def nodebb(request: pytest.FixtureRequest) -> AsyncIterator[NodeBBWorld]:
    path = TAPES / f"{request.node.name}.jsonl"
    server = Recorder(URL) if RECORD else Player(Tape.load(path))
    async with serving(server) as url:
        world = NodeBBWorld(url, ADMIN, server=server)
        if RECORD:
            await world.prepare()
        yield world
        await world.close()
    if isinstance(server, Recorder):
        server.tape.save(path)
    else:
        assert server.unknown == [], "the adapter asks what was not recorded: record the tapes anew"
