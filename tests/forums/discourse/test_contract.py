"""The Discourse adapter fulfils the contract on the double, and on a real Discourse if one is configured.

    AGENTROB_TEST_DISCOURSE_URL=https://forum.example AGENTROB_TEST_DISCOURSE_KEY=… pytest tests/forums/discourse

The key must be an admin's key for all users. Use a Discourse for tests only, because this creates and suspends accounts
and changes settings. `python -m tests.doubles.discourse --lifted` serves the double for the same purpose.
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
