"""One Chromium for each module, and windows on its forum for each test."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser

from tests.board.web.browser_windows import Windows, open_windows, running_chromium
from tests.board.web.forum_site import Site


@pytest.fixture(scope="module")  # Playwright runs an event loop until it ends, which would disturb async tests
def chromium() -> Iterator[Browser]:
    with running_chromium() as chromium:
        yield chromium


@pytest.fixture
def windows(site: Site, chromium: Browser) -> Iterator[Windows]:
    with open_windows(site, chromium) as windows:
        yield windows
