"""The NodeBB adapter keeps the contract, against what a real NodeBB 4.15.1 answered: `nodebb_tapes`, played back.

To record them anew, with a NodeBB that is for trying (limits are lifted, accounts made and removed):

    AGENTROB_TEST_NODEBB_RECORD=1 AGENTROB_TEST_NODEBB_URL=http://127.0.0.1:4567 \\
        AGENTROB_TEST_NODEBB_ADMIN=login:admin:PASSWORD .venv/bin/pytest tests/forums/test_forums_contract_nodebb.py
"""

from __future__ import annotations

import os
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from nodebb_tape import Player, Recorder, Tape, serving
from nodebb_world import NodeBBWorld

from agentrob.forums.contract import ForumContract

TAPES = Path(__file__).parent / "nodebb_tapes"
RECORD = os.environ.get("AGENTROB_TEST_NODEBB_RECORD", "")
URL = os.environ.get("AGENTROB_TEST_NODEBB_URL", "")
ADMIN = os.environ.get("AGENTROB_TEST_NODEBB_ADMIN", "login:admin:on the tape")


class TestNodeBBForum(ForumContract):
    @pytest.fixture
    async def world(self, request: pytest.FixtureRequest) -> AsyncIterator[NodeBBWorld]:
        path = TAPES / f"{request.node.name}.jsonl"
        server = Recorder(URL) if RECORD else Player(Tape.load(path))
        async with serving(server) as url:
            world = NodeBBWorld(url, ADMIN)
            await world.prepare()
            yield world
            await world.close()
        if isinstance(server, Recorder):
            server.tape.save(path)
        else:
            assert server.unknown == [], "the adapter asks what was not recorded: record the tapes anew"
