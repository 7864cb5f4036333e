"""The Discourse adapter keeps the contract against the double, and against a real Discourse where one is named.

    AGENTROB_TEST_DISCOURSE_URL=https://forum.example AGENTROB_TEST_DISCOURSE_KEY=… pytest tests/forums/…

The key is an admin's for all users, of a Discourse that is for tests: accounts are made and suspended, and settings
changed. `python -m tests.doubles.discourse --lifted` serves one to try that on.
"""

from __future__ import annotations

import os
from collections.abc import AsyncIterator
from uuid import uuid4

import pytest

from agentrob.forums.contract import ForumContract, World
from tests.forums.discourse.discourse_world import LiveWorld, double_world

URL = os.environ.get("AGENTROB_TEST_DISCOURSE_URL", "")


class TestDiscourseForumByPush(ForumContract):
    @pytest.fixture
    async def world(self) -> AsyncIterator[World]:
        async with double_world() as (made, _):
            yield made


class TestDiscourseForumByPolling(ForumContract):
    @pytest.fixture
    async def world(self) -> AsyncIterator[World]:
        async with double_world(push=False) as (made, _):
            yield made


if URL:

    class TestDiscourseForumLive(ForumContract):
        @pytest.fixture
        async def world(self) -> AsyncIterator[World]:
            name = os.environ.get("AGENTROB_TEST_DISCOURSE_ADMIN", "system")
            made = LiveWorld(URL, os.environ["AGENTROB_TEST_DISCOURSE_KEY"], name, key_prefix=f"{uuid4().hex}:")
            await made.prepare()
            yield made
            await made.close()
