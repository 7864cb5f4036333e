"""Markup attacks in real Chromium on every page that shows them: as title, text, tag, alt text, file name, name
and reason.

A few of our own always run; the large collection is measured when it is there (`AGENTROB_EVAL`, or the folder
`shared/eval` beside the checkout), and the test says so plainly when it is not. Pages are served by the real forum with
its own headers; a second look without the content policy shows that the policy is not all that holds.
"""

from __future__ import annotations

import html
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import pytest
from pages_windows import running_chromium
from pages_world import World, running_world
from playwright.sync_api import Browser, Page
from test_board_rights import jpeg
from test_render_attacks import TRAP, payloads

from agentrob.board import admin, administration
from agentrob.board.accounts import NAME
from agentrob.errors import BoardError

pytestmark = [pytest.mark.browser, pytest.mark.slow]
A_PAGE = 50


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with running_chromium() as browser:
        yield browser


def title_of(text: str) -> str:
    return re.sub(r"[\x00-\x1f\x7f-\x9f]", " ", text).strip()[:200] or "x"


def fill(world: World, rows: Sequence[str]) -> list[str]:
    """Put each row everywhere that a person can put text; the pages that show them."""
    api, pages = world.api("root"), ["/", "/u/root", "/robots", "/robots/quadruped", "/admin/audit", "/admin/accounts"]
    pages += ["/latest", "/notices", "/unread", "/tags", "/search?q=script", "/search?q=<script>alert(1)</script>"]
    pages += ["/search?q=x&tag=<script>alert(1)</script>&board=<img src=x onerror=alert(1)>"]
    pages += ["/tags/<svg onload=alert(1)>", "/admin/boards", "/admin/invites", "/admin/robots"]
    pages += ["/admin/robots/quadruped"]
    for start in range(0, len(rows), A_PAGE):
        some = rows[start : start + A_PAGE]
        made = api.post("/topics", json={"board": "robots", "title": title_of(some[0]), "body": some[0]}).json()
        topic, post = made["topic"]["id"], made["post"]["id"]
        for row in some[1:]:
            alt = row.replace("]", "\\]").replace("\n", " ")
            body = f"{row}\n\n![{alt}](/images/1) @quadruped"
            assert api.post(f"/topics/{topic}/posts", json={"body": body}).status_code == 201, row
        pages += [f"/t/{topic}", f"/p/{post}/edit", f"/p/{post}/history", f"/p/{post}/moderate", f"/p/{post}/raw"]
        pages += [f"/t/{topic}?quote={post}", f"/c/{post}", f"/t/{topic}/moderate", f"/t/{topic}/tags"]
        world.api("quadruped").put(f"/commands/{post}", json={"record": record(some)}).raise_for_status()
        reason = title_of(some[-1])
        world.api("quadruped").put(
            "/robots/quadruped", json={"card": {"model": reason, "state": reason, "ops": some[:20]}}
        )
    for row in rows:
        new = {"board": "talk", "title": title_of(row), "body": "x", "tags": [row.strip()[:24]]}
        api.post("/topics", json=new).raise_for_status()
    for tag in [found["tag"] for found in api.get("/tags").json()["items"]][::20]:
        pages.append(f"/tags/{tag}")
    return pages


def record(rows: Sequence[str]) -> dict[str, Any]:
    """What a robot's agent may tell of a command, with rows wherever there are words."""
    some = [row[:200] for row in rows[:20]]
    steps = [{"op": row, "asked": {row: row}, "measured": {}, "outcome": row, "message": row} for row in some]
    turns = [{"tool": row, "arguments": {row: row}, "words": row, "problem": row} for row in some]
    usage = [{"mind": row, "model": row, "failed": row} for row in some]
    links = [{"kind": row, "url": row, "until": row} for row in some]
    links += [{"kind": row, "url": f"https://example.org/{row}", "until": ""} for row in some]
    verdict = {"decision": some[0], "rule": some[-1], "reason": some[0]}
    looked = {"goal": some[0], "turns": turns[:10], "end": {"did": some[0], "saw": some[:8]}}
    told = {"steps": steps[:10], "models": usage[:10], "looked": looked, "links": links, "verdict": verdict}
    return told | {"status": some[0], "message": some[-1], "trace_id": some[0], "mind": some[-1], "notes": some[:8]}


def names(world: World, rows: Sequence[str]) -> list[str]:
    """Rows as names: no handle is taken, what can be a display name is shown; the pages that show them."""
    shown = []
    with admin.writing(world.settings) as connection:
        for n, row in enumerate(rows):
            if not NAME.fullmatch(row.strip().lower()):
                with pytest.raises(BoardError):
                    administration.add_account(connection, "root", row)
            try:
                administration.add_account(connection, "root", f"attacker-{n:04}", display_name=row[:64])
            except BoardError:
                continue
            shown.append(f"attacker-{n:04}")
    assert len(shown) > len(rows) // 2
    some = [f"/u/{name}" for name in shown[:: max(1, len(shown) // 8)]]
    return some + ["/admin/accounts"] + [f"/admin/accounts?after={name}" for name in shown[A_PAGE - 1 :: A_PAGE]]


def file_names(world: World, rows: Sequence[str]) -> None:
    """Rows as names of files: nothing is kept of them."""
    for row in rows:
        picture = {"file": (row[:100].encode("utf-8", "replace").decode(), jpeg(), "image/jpeg")}
        assert world.api("root").post("/images", files=picture).status_code in (201, 400), row


def ran(page: Page, path: str, asked: list[str]) -> list[str]:
    """What ran on a page, or was asked for elsewhere."""
    page.goto(path, wait_until="domcontentloaded")  # a live camera never ends loading
    if not path.endswith("/raw"):  # nothing runs there at all, a timer neither
        page.evaluate("() => new Promise(done => requestAnimationFrame(() => setTimeout(done, 60)))")
    found = [*page.evaluate("window.ran || []"), *asked]
    asked.clear()
    return found


def window(world: World, chromium: Browser, **how: Any) -> tuple[Page, list[str]]:
    context = chromium.new_context(base_url=world.base, **how)
    context.add_init_script(TRAP.replace("'open', 'fetch'", "'open'"))
    page, asked = context.new_page(), []  # type: ignore[var-annotated]
    page.on("dialog", lambda dialog: (asked.append(f"dialog {dialog.message}"), dialog.dismiss()))
    page.on("request", lambda r: asked.append(r.url) if not r.url.startswith((world.base, "data:")) else None)
    page.goto(world.link("root"))
    page.get_by_role("button", name="Enter").click()
    page.wait_for_url(world.base + "/")
    return page, asked


def guilty(world: World, chromium: Browser, rows: Sequence[str]) -> list[str]:
    """Which of some rows it was: halves are tried until one row is left."""
    if len(rows) == 1:
        return list(rows)
    halves = rows[: len(rows) // 2], rows[len(rows) // 2 :]
    page, asked = window(world, chromium)
    found = []
    for half in halves:
        if any(ran(page, path, asked) for path in fill(world, half)):
            found += guilty(world, chromium, half)
    return found


@dataclass
class Filled:
    """A forum with every row in every place, and the pages that show them."""

    world: World
    rows: Sequence[str]
    pages: Sequence[str]


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Filled]:
    rows = payloads()
    with running_world(tmp_path_factory.mktemp("board")) as world:
        file_names(world, rows)
        pages = fill(world, rows) + names(world, rows)
        surfer, board = world.browser("root"), "/b/talk"
        while board:
            pages.append(board)
            link = re.search(r'rel="next" href="([^"]*)"', surfer.get(board).text)
            board = html.unescape(link[1]) if link else ""
        assert len(pages) > 5 * len(rows) // A_PAGE
        yield Filled(world, rows, pages)


@pytest.mark.timeout(600)
@pytest.mark.parametrize("policy", [True, False], ids=["as served", "without its content policy"])
def test_no_attack_runs_on_any_page(filled: Filled, chromium: Browser, policy: bool) -> None:
    page, asked = window(filled.world, chromium, bypass_csp=not policy)
    hits = {path: found for path in filled.pages if (found := ran(page, path, asked))}
    page.context.close()
    assert hits == {} or (hits, guilty(filled.world, chromium, filled.rows)) == ({}, [])


def test_the_trap_is_set(filled: Filled, chromium: Browser) -> None:
    """An attack that is not defused is seen: the same window on a page of its own."""
    page, _ = window(filled.world, chromium, bypass_csp=True)
    page.evaluate("document.body.innerHTML = '<img src=/nothing onerror=alert(7)>'")
    page.wait_for_function("window.ran.length > 0")
    assert page.evaluate("window.ran") == ["alert(7)"]
