"""XSS payloads in real Chromium, on every page of the real forum and in every field: none runs or sends a request.

The payloads are those of `tests/board/content/test_xss.py`. Chromium loads all pages with the content security policy
disabled, because the pages must be safe without it too. With the policy, `make test` loads one page of each kind, and
the slow tests load all of them. `make test` uses a sixteenth of the large collection; one slow test uses all of it, the
others a quarter or more.
"""

from __future__ import annotations

import asyncio
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest
from playwright.async_api import Browser, Page, async_playwright

from agentrob.board.content.rendered import Rendered
from tests.board.auth.test_rights import jpeg
from tests.board.content.test_xss import OWN, TRAP, all_payloads
from tests.board.security import xss_forum
from tests.board.security.xss_forum import LISTS, POSTS, fill, titles
from tests.board.web.browser_windows import CHROMIUM_ARGS
from tests.board.web.forum_site import Site, running_site
from tests.chromium import chromium_path
from tests.sizes import size

pytestmark = pytest.mark.browser
#: Windows that load pages in parallel: while one waits for late scripts, another loads its page.
WINDOWS = 2
#: How long to wait after a page is shown: timers and failed pictures run scripts late.
LATE_MS = 60
LOOK = f"""() => new Promise(done => requestAnimationFrame(() => setTimeout(() => done([
    window.ran || [], document.querySelector('.more a[rel=next]')?.getAttribute('href') ?? '']), {LATE_MS})))"""


@dataclass
class PageLoader:
    """Loads pages and the next pages of lists. `hits` maps a path to the calls and foreign requests of its page."""

    site: Site
    policy: bool
    left: list[str]
    hits: dict[str, list[str]] = field(default_factory=dict)
    seen: set[str] = field(default_factory=set)
    follows: bool = True

    async def run(self) -> None:
        async with async_playwright() as playwright:
            browser = await playwright.chromium.launch(executable_path=chromium_path(), args=CHROMIUM_ARGS)
            await asyncio.gather(*(self.window(browser) for _ in range(WINDOWS)))
            await browser.close()

    async def window(self, browser: Browser) -> None:
        page, asked = await window(self.site, browser, self.policy)
        while self.left:
            path = self.left.pop(0)
            if path not in self.seen:
                self.seen.add(path)
                await self.load(page, path, asked)
        await page.context.close()

    async def load(self, page: Page, path: str, asked: list[str]) -> None:
        answer = await page.goto(path, wait_until="domcontentloaded")  # the live camera never finishes loading
        assert answer is not None
        assert answer.status in (200, 422), (path, answer.status)
        raw = path.endswith("/raw")  # plain text: no script runs there, so the timer of `LOOK` would not either
        ran, following = (await page.evaluate("[window.ran || [], '']")) if raw else (await page.evaluate(LOOK))
        if found := [*ran, *asked]:
            self.hits[path] = found
        asked.clear()
        if self.follows and following.startswith("/"):
            self.left.append(following)


async def window(site: Site, browser: Browser, policy: bool) -> tuple[Page, list[str]]:
    """Return a window signed in as `root`, and the list of its requests to other hosts."""
    context = await browser.new_context(base_url=site.base, bypass_csp=not policy)
    cookies = site.board.browser("root").cookies.jar
    await context.add_cookies([{"name": c.name, "value": c.value or "", "url": site.base} for c in cookies])
    await context.add_init_script(TRAP.replace("'open', 'fetch'", "'open'"))
    page, asked = await context.new_page(), []  # type: ignore[var-annotated]

    async def dismiss(dialog: Any) -> None:
        asked.append(f"dialog {dialog.message}")
        await dialog.dismiss()

    page.on("dialog", dismiss)
    page.on("request", lambda r: asked.append(r.url) if not r.url.startswith((site.base, "data:")) else None)
    return page, asked


def load_pages(site: Site, pages: Iterable[str], policy: bool = False, follows: bool = True) -> PageLoader:
    loader = PageLoader(site, policy, list(pages), follows=follows)
    asyncio.run(loader.run())
    return loader


def bisect(folder: Path, payloads: Sequence[str]) -> list[str]:
    """Bisect: return the payloads that run, trying each half on a new forum."""
    with running_site(folder / f"{len(payloads)}-{abs(hash(tuple(payloads)))}") as site:
        if not load_pages(site, fill(site, payloads)).hits:
            return []
    if len(payloads) == 1:
        return list(payloads)
    half = len(payloads) // 2
    return bisect(folder, payloads[:half]) + bisect(folder, payloads[half:])


def kind_of(path: str) -> str:
    return re.sub(r"\d+|=.*|rover-.", "", path)


@dataclass
class FilledForum:
    """A forum with every payload in every field, and the pages that show them (of a list, the first one)."""

    site: Site
    payloads: Sequence[str]
    pages: Sequence[str]


@contextmanager
def forum_with(folder: Path, every: int) -> Iterator[FilledForum]:
    """Serve a forum with all payloads of `OWN` and with one in `every` of the collection."""
    payloads = [*OWN, *all_payloads()[len(OWN) :: every]]
    with running_site(folder) as site:
        yield FilledForum(site, payloads, fill(site, payloads))


@pytest.fixture(scope="module")
def few(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FilledForum]:
    with forum_with(tmp_path_factory.mktemp("few"), 16) as filled:
        yield filled


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FilledForum]:
    with forum_with(tmp_path_factory.mktemp("filled"), size(4, 1)) as filled:
        yield filled


def test_no_payload_runs_on_any_page_without_the_csp(few: FilledForum, tmp_path: Path) -> None:
    assert_none_runs(few, tmp_path)


@pytest.mark.slow
def test_no_payload_of_the_whole_collection_runs_on_any_page_without_the_csp(tmp_path: Path) -> None:
    payloads = all_payloads()
    with running_site(tmp_path / "board") as site:
        assert_none_runs(FilledForum(site, payloads, fill(site, payloads)), tmp_path)


def assert_none_runs(filled: FilledForum, tmp_path: Path) -> None:
    """Assert that no payload runs on any page without the content security policy, up to the last page of each list."""
    loader = load_pages(filled.site, filled.pages)
    assert loader.hits == {} or (loader.hits, bisect(tmp_path, filled.payloads)) == ({}, [])
    assert not set(filled.pages) - loader.seen
    for first in LISTS:  # all pages of a list were loaded, not only the first
        pages = [
            path
            for path in loader.seen
            if path == first or path.startswith(f"{first}{'&' if '?' in first else '?'}after=")
        ]
        least = len(titles(filled.payloads)) // 30 if first != "/admin/audit" else len(filled.payloads) // POSTS
        assert len(pages) >= least, first


def test_no_payload_runs_on_a_page_of_each_kind_as_served(few: FilledForum) -> None:
    kinds = {kind_of(path): path for path in few.pages}
    loader = load_pages(few.site, kinds.values(), policy=True, follows=False)
    assert loader.hits == {}
    assert len(loader.seen) > 20


@pytest.mark.slow
def test_no_payload_runs_on_any_page_as_served(filled: FilledForum) -> None:
    assert load_pages(filled.site, filled.pages, policy=True).hits == {}


def test_an_unsanitised_payload_on_a_page_is_detected(few: FilledForum) -> None:
    """An unsanitised payload is detected, and so is a request to another host."""

    async def attacked() -> tuple[list[str], list[str]]:
        async with async_playwright() as playwright:
            browser = await playwright.chromium.launch(executable_path=chromium_path(), args=CHROMIUM_ARGS)
            page, asked = await window(few.site, browser, policy=False)
            await page.goto("/latest")
            await page.evaluate(
                "document.body.innerHTML = '<img src=/nothing onerror=alert(7)><img src=http://a.test>'"
            )
            await page.wait_for_function("window.ran.length > 0")
            ran = await page.evaluate("window.ran")
            await browser.close()
        return ran, asked

    ran, asked = asyncio.run(attacked())
    assert ran == ["alert(7)"]
    assert asked == ["http://a.test/"]


@pytest.mark.slow
def test_bisect_finds_the_payload_that_is_not_sanitised(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real, bad = xss_forum.render_text, "<img src=/nothing onerror=alert(7)>"

    def render_text(raw: str) -> Rendered:
        return replace(real(raw), html=raw) if raw.startswith(bad) else real(raw)

    monkeypatch.setattr(xss_forum, "render_text", render_text)
    payloads = [f"<i>{n}</i>" for n in range(3)] + [bad] + [f"<b>{n}</b>" for n in range(3)]
    assert bisect(tmp_path, payloads) == [bad]


@pytest.mark.slow
def test_file_names_are_not_stored(filled: FilledForum) -> None:
    for payload in filled.payloads:
        picture = {"file": (payload[:100].encode("utf-8", "replace").decode(), jpeg(), "image/jpeg")}
        assert filled.site.api("root").post("/images", files=picture).status_code in (201, 400), payload
