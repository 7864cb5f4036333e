"""The NodeBB adapter fulfils the contract, against recordings of a real NodeBB 4.15.1 in `nodebb_tapes`.

To record again, use a NodeBB for tests only, because this lifts limits and creates and deletes accounts:

    AGENTROB_TEST_NODEBB_RECORD=1 AGENTROB_TEST_NODEBB_URL=http://127.0.0.1:4567 \\
        AGENTROB_TEST_NODEBB_ADMIN=login:admin:PASSWORD .venv/bin/pytest tests/forums/nodebb
"""

from __future__ import annotations

import pytest

from agentrob.forums.contract import ForumContract
from tests.forums.nodebb.nodebb_world import NodeBBWorld


class TestNodeBBForum(ForumContract):
    @pytest.fixture
    async def world(self, nodebb: NodeBBWorld) -> NodeBBWorld:
        return nodebb
