"""The NodeBB adapter keeps the contract, against what a real NodeBB 4.15.1 answered: `nodebb_tapes`, played back.

To record them anew, with a NodeBB that is for trying (limits are lifted, accounts made and removed):

    AGENTROB_TEST_NODEBB_RECORD=1 AGENTROB_TEST_NODEBB_URL=http://127.0.0.1:4567 \\
        AGENTROB_TEST_NODEBB_ADMIN=login:admin:PASSWORD .venv/bin/pytest tests/forums/test_forums_*nodebb*.py
"""

from __future__ import annotations

import pytest

from agentrob.forums.contract import ForumContract
from tests.forums.nodebb.nodebb_world import NodeBBWorld


class TestNodeBBForum(ForumContract):
    @pytest.fixture
    async def world(self, nodebb: NodeBBWorld) -> NodeBBWorld:
        return nodebb
