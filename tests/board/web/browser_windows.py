"""Windows of a real Chromium on the forum, and a robot's posts, for the tests of the forum's pages."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from PIL import Image
from playwright.sync_api import Browser, BrowserContext, Page, expect, sync_playwright

from tests.board.web.forum_site import Site
from tests.chromium import chromium_path

#: No GPU, and no software rasterizer either, because that takes a tenth of a page's CPU time.
CHROMIUM_ARGS = ["--no-sandbox", "--disable-gpu", "--disable-software-rasterizer", "--disable-background-networking"]
WATCH = (
    "addEventListener('securitypolicyviolation', e => console.error('policy: ' + e.violatedDirective + e.blockedURI))"
)
expect.set_options(timeout=60_000)
RUNNING = {"robot": "quadruped", "state": "running", "step": 2, "steps": 4, "doing": "turning", "trace_id": "4f1c"}


@contextmanager
def running_chromium() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=chromium_path(), args=CHROMIUM_ARGS)
        yield chromium
        chromium.close()


@dataclass
class Windows:
    """Opens windows of Chromium and collects all console errors."""

    site: Site
    chromium: Browser
    contexts: list[BrowserContext] = field(default_factory=list)
    console_errors: list[str] = field(default_factory=list)

    def open(self, name: str | None = None, **how: Any) -> Page:
        """Open an empty window with its own profile, signed in as that account by a session cookie."""
        how.setdefault("viewport", {"width": 1280, "height": 800})
        how.setdefault("reduced_motion", "reduce")
        context = self.chromium.new_context(base_url=self.site.base, **how)
        context.set_default_timeout(60_000)
        context.add_init_script(WATCH)
        self.contexts.append(context)
        if name:
            cookies = self.site.board.browser(name).cookies.jar
            context.add_cookies([{"name": c.name, "value": c.value or "", "url": self.site.base} for c in cookies])
        page = context.new_page()
        page.on("console", lambda m: self.console_errors.append(m.text) if m.type in ("error", "warning") else None)
        page.on("pageerror", lambda e: self.console_errors.append(str(e)))
        return page


@contextmanager
def open_windows(site: Site, chromium: Browser) -> Iterator[Windows]:
    """Yield windows; close them at the end and assert that the console had no errors."""
    windows = Windows(site, chromium)
    yield windows
    for context in windows.contexts:
        context.close()
    assert windows.console_errors == []


def new_topic(site: Site, replies: int = 0) -> str:
    api = site.api("alice")
    made = api.post(
        "/topics", json={"board_id": "robots", "title": "A walk", "body": "@quadruped walk forward 1 metre"}
    )
    topic = made.json()["topic"]["id"]
    for n in range(replies):
        api.post(f"/topics/{topic}/posts", json={"body": f"number {n}\n\nwith a second line"}).raise_for_status()
    return str(topic)


def robot_posts(site: Site, topic: str, body: str, card: dict[str, Any] | None = None) -> str:
    answer = site.api("quadruped").post(f"/topics/{topic}/posts", json={"body": body, "card": card})
    return str(answer.json()["post"]["id"])


def robot_edits(site: Site, post: str, body: str, card: dict[str, Any] | None = None) -> None:
    site.api("quadruped").patch(f"/posts/{post}", json={"body": body, "card": card}).raise_for_status()


def jpeg(shade: int) -> bytes:
    file = io.BytesIO()
    Image.new("RGB", (64, 48), (shade, 90, 90)).save(file, "JPEG")
    return file.getvalue()
