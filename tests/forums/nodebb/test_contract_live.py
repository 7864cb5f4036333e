"""The NodeBB adapter keeps the contract against a real NodeBB, where there is one to try: AGENTROB_TEST_NODEBB_URL.

    AGENTROB_TEST_NODEBB_URL=http://127.0.0.1:4567 AGENTROB_TEST_NODEBB_ADMIN=login:admin:PASSWORD \\
        .venv/bin/pytest -m slow tests/forums/nodebb/test_contract_live.py

It makes accounts, removes them, and lifts limits: use a forum that is for trying. Without it there is nothing to
collect here; the exchanges with a real one are replayed in `test_forums_contract_nodebb.py`.
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
