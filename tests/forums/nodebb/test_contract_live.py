"""The NodeBB adapter fulfils the contract on a real NodeBB, if AGENTROB_TEST_NODEBB_URL names one.

    AGENTROB_TEST_NODEBB_URL=http://127.0.0.1:4567 AGENTROB_TEST_NODEBB_ADMIN=login:admin:PASSWORD \\
        .venv/bin/pytest -m slow tests/forums/nodebb/test_contract_live.py

Use a forum for tests only, because this creates and deletes accounts and lifts limits. Without the variable no test is
collected; `test_contract.py` replays recordings of a real NodeBB.
"""

from __future__ import annotations

import os
from collections.abc import AsyncIterator

import pytest

from agentrob.forums.contract import ForumContract
from tests.forums.nodebb.nodebb_world import NodeBBWorld

URL = os.environ.get("AGENTROB_TEST_NODEBB_URL", "")
ADMIN = os.environ.get("AGENTROB_TEST_NODEBB_ADMIN", "")

if URL:

    @pytest.mark.slow
    class TestNodeBBForum(ForumContract):
        @pytest.fixture
        async def world(self) -> AsyncIterator[NodeBBWorld]:
            made = NodeBBWorld(URL, ADMIN)
            await made.prepare()
            yield made
            await made.close()
