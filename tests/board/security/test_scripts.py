"""Markup attacks in real Chromium on every page that shows them: as title, text, alt text, name, reason, card, record.

A few of our own always run; the large collection is measured when it is there (`AGENTROB_EVAL`, or the folder
`shared/eval` beside the checkout), and the test says so plainly when it is not. Pages are served by the real forum with
its own headers. All are looked at without the content policy, which is not all that holds: what does not run without it
does not run with it. With it one page of each kind is looked at, and all among the slow tests; so is the whole
collection, of which a sixteenth is shown before every change and a fourth on the slow tests' other pages.
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
from tests.board.content import attacks_shown
from tests.board.content.attacks_shown import LISTS, POSTS, fill, titles
from tests.board.content.test_markup_attacks import OWN, TRAP, payloads
from tests.board.web.browser_windows import CHROMIUM_ARGS
from tests.board.web.page_world import World, running_world
from tests.sizes import size

pytestmark = pytest.mark.browser
#: Windows that look at once: while one waits for what may run late, another loads.
WINDOWS = 2
#: What an attack may still do after a page is shown: timers, pictures that fail.
LATE_MS = 60
LOOK = f"""() => new Promise(done => requestAnimationFrame(() => setTimeout(() => done([
    window.ran || [], document.querySelector('.more a[rel=next]')?.getAttribute('href') ?? '']), {LATE_MS})))"""


@dataclass
class Looking:
    """Looks at pages and at those that follow them. `hits`: what ran on a page, or was asked for elsewhere."""

    world: World
    policy: bool
    left: list[str]
    hits: dict[str, list[str]] = field(default_factory=dict)
    seen: set[str] = field(default_factory=set)
    follows: bool = True

    async def all(self) -> None:
        async with async_playwright() as playwright:
            browser = await playwright.chromium.launch(executable_path="/usr/bin/chromium", args=CHROMIUM_ARGS)
            await asyncio.gather(*(self.window(browser) for _ in range(WINDOWS)))
            await browser.close()

    async def window(self, browser: Browser) -> None:
        page, asked = await window(self.world, browser, self.policy)
        while self.left:
            path = self.left.pop(0)
            if path not in self.seen:
                self.seen.add(path)
                await self.look(page, path, asked)
        await page.context.close()

    async def look(self, page: Page, path: str, asked: list[str]) -> None:
        answer = await page.goto(path, wait_until="domcontentloaded")  # a live camera never ends loading
        assert answer is not None
        assert answer.status in (200, 422), (path, answer.status)
        raw = path.endswith("/raw")  # nothing runs there at all, a timer neither
        ran, following = (await page.evaluate("[window.ran || [], '']")) if raw else (await page.evaluate(LOOK))
        if found := [*ran, *asked]:
            self.hits[path] = found
        asked.clear()
        if self.follows and following.startswith("/"):
            self.left.append(following)


async def window(world: World, browser: Browser, policy: bool) -> tuple[Page, list[str]]:
    """A window of `root`, and what it asks for elsewhere."""
    context = await browser.new_context(base_url=world.base, bypass_csp=not policy)
    cookies = world.board.browser("root").cookies.jar
    await context.add_cookies([{"name": c.name, "value": c.value or "", "url": world.base} for c in cookies])
    await context.add_init_script(TRAP.replace("'open', 'fetch'", "'open'"))
    page, asked = await context.new_page(), []  # type: ignore[var-annotated]

    async def dismiss(dialog: Any) -> None:
        asked.append(f"dialog {dialog.message}")
        await dialog.dismiss()

    page.on("dialog", dismiss)
    page.on("request", lambda r: asked.append(r.url) if not r.url.startswith((world.base, "data:")) else None)
    return page, asked


def look(world: World, pages: Iterable[str], policy: bool = False, follows: bool = True) -> Looking:
    looking = Looking(world, policy, list(pages), follows=follows)
    asyncio.run(looking.all())
    return looking


def guilty(folder: Path, rows: Sequence[str]) -> list[str]:
    """Which of some rows it was: halves are tried, each on a forum of its own, until one row is left."""
    with running_world(folder / f"{len(rows)}-{abs(hash(tuple(rows)))}") as world:
        if not look(world, fill(world, rows)).hits:
            return []
    if len(rows) == 1:
        return list(rows)
    half = len(rows) // 2
    return guilty(folder, rows[:half]) + guilty(folder, rows[half:])


def kind_of(path: str) -> str:
    return re.sub(r"\d+|=.*|rover-.", "", path)


@dataclass
class Filled:
    """A forum with every row in every place, and the pages that show them; lists are followed."""

    world: World
    rows: Sequence[str]
    pages: Sequence[str]


@contextmanager
def forum_with(folder: Path, every: int) -> Iterator[Filled]:
    """With our own attacks, and with each of so many of the collection."""
    rows = [*OWN, *payloads()[len(OWN) :: every]]
    with running_world(folder) as world:
        yield Filled(world, rows, fill(world, rows))


@pytest.fixture(scope="module")
def few(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Filled]:
    with forum_with(tmp_path_factory.mktemp("few"), 16) as filled:
        yield filled


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Filled]:
    with forum_with(tmp_path_factory.mktemp("filled"), size(4, 1)) as filled:
        yield filled


def test_no_attack_runs_on_any_page_without_its_content_policy(few: Filled, tmp_path: Path) -> None:
    none_runs(few, tmp_path)


@pytest.mark.slow
def test_no_attack_of_the_whole_collection_runs_on_any_page_without_its_content_policy(tmp_path: Path) -> None:
    rows = payloads()
    with running_world(tmp_path / "board") as world:
        none_runs(Filled(world, rows, fill(world, rows)), tmp_path)


def none_runs(filled: Filled, tmp_path: Path) -> None:
    """No attack runs on any page without the content policy; every page is looked at, and lists to their ends."""
    looking = look(filled.world, filled.pages)
    assert looking.hits == {} or (looking.hits, guilty(tmp_path, filled.rows)) == ({}, [])
    assert not set(filled.pages) - looking.seen
    for first in LISTS:  # to their ends
        pages = [
            path
            for path in looking.seen
            if path == first or path.startswith(f"{first}{'&' if '?' in first else '?'}after=")
        ]
        least = len(titles(filled.rows)) // 30 if first != "/admin/audit" else len(filled.rows) // POSTS
        assert len(pages) >= least, first


def test_no_attack_runs_on_a_page_of_each_kind_as_served(few: Filled) -> None:
    kinds = {kind_of(path): path for path in few.pages}
    looking = look(few.world, kinds.values(), policy=True, follows=False)
    assert looking.hits == {}
    assert len(looking.seen) > 20


@pytest.mark.slow
def test_no_attack_runs_on_any_page_as_served(filled: Filled) -> None:
    assert look(filled.world, filled.pages, policy=True).hits == {}


def test_the_trap_is_set(few: Filled) -> None:
    """An attack that is not defused is seen, also what asks elsewhere."""

    async def attacked() -> tuple[list[str], list[str]]:
        async with async_playwright() as playwright:
            browser = await playwright.chromium.launch(executable_path="/usr/bin/chromium", args=CHROMIUM_ARGS)
            page, asked = await window(few.world, browser, policy=False)
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
def test_a_row_that_is_not_defused_is_found_among_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real, bad = attacks_shown.typed, "<img src=/nothing onerror=alert(7)>"

    def typed(raw: str) -> Rendered:
        return replace(real(raw), html=raw) if raw.startswith(bad) else real(raw)

    monkeypatch.setattr(attacks_shown, "typed", typed)
    rows = [f"<i>{n}</i>" for n in range(3)] + [bad] + [f"<b>{n}</b>" for n in range(3)]
    assert guilty(tmp_path, rows) == [bad]


@pytest.mark.slow
def test_nothing_is_kept_of_the_names_of_files(filled: Filled) -> None:
    for row in filled.rows:
        picture = {"file": (row[:100].encode("utf-8", "replace").decode(), jpeg(), "image/jpeg")}
        assert filled.world.api("root").post("/images", files=picture).status_code in (201, 400), row
