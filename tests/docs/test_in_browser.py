"""The site in Chromium, on a desktop and a phone: nothing is loaded from elsewhere or cut off, and search works."""

from __future__ import annotations

import functools
import http.server
import threading
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, TimeoutError, sync_playwright

from tests.chromium import chromium_path

#: Pages with wide tables, long code, pictures and definition lists.
PAGES = ("index.html", "use/pages.html", "reference/configuration.html", "start/tutorial.html", "safety/figures.html")
SIZES = {"desktop": (1280, 900), "phone": (390, 844)}
MOST_TRIES = 60
pytestmark = pytest.mark.browser


class _Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_: object) -> None:
        """Log nothing."""


@pytest.fixture(scope="module")
def address(site: Path) -> Iterator[str]:
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(_Quiet, directory=str(site)))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()
    thread.join()
    server.server_close()


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=chromium_path())
        yield started
        started.close()


@pytest.fixture(params=SIZES)
def page(browser: Browser, address: str, request: pytest.FixtureRequest) -> Iterator[Page]:
    width, height = SIZES[request.param]
    opened = browser.new_page(viewport={"width": width, "height": height})
    elsewhere, errors = [], []
    opened.on("request", lambda r: r.url.startswith((address, "data:", "blob:")) or elsewhere.append(r.url))
    opened.on("pageerror", lambda error: errors.append(str(error)))
    yield opened
    opened.close()
    assert elsewhere == []
    assert errors == []


@pytest.mark.parametrize("name", PAGES)
def test_a_page_is_as_wide_as_the_window_and_its_pictures_are_shown(page: Page, address: str, name: str) -> None:
    page.goto(address + name)
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    broken = "[...document.images].filter(i => i.complete && !i.naturalWidth).map(i => i.src)"
    assert page.evaluate(broken) == []


def test_search_finds_a_task(page: Page, address: str) -> None:
    page.goto(address, wait_until="networkidle")
    before = page.evaluate("document.activeElement.tagName")
    page.keyboard.press("Control+k")
    page.wait_for_function("before => document.activeElement.tagName !== before", arg=before)  # the box has the focus
    page.keyboard.insert_text("become admin")  # at once: there are no results for a part of it, which Enter would open
    for _ in range(MOST_TRIES):  # the results are in a closed shadow tree; Enter opens the first one, once it is there
        page.keyboard.press("Enter")
        with suppress(TimeoutError):
            page.wait_for_url("**/forum/people.html*", timeout=500)
            return
    raise AssertionError(f"no result was opened; still at {page.url}")
