"""Every page in Chromium: WCAG 2.2 AA as axe checks it, desktop and phone, light and dark; and writing by keyboard."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi import APIRouter
from fastapi.routing import APIRoute
from PIL import Image
from playwright.sync_api import Browser, Page, expect

from agentrob.board.web import routes
from tests.board.search.encoder_double import Concepts
from tests.board.web.browser_windows import Windows, open_windows, running_chromium
from tests.board.web.page_world import CARD, World, running_world
from tests.board.web.shown_pages import PAGES, alive, decisions, fill
from tests.board.web.told_commands import ROBOT

pytestmark = pytest.mark.browser

AXE = Path(__file__).parents[1] / "axe" / "node_modules" / "axe-core" / "axe.min.js"
RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]
SIZES = {"desktop": (1280, 900), "phone": (390, 844), "zoomed": (320, 640)}
#: One in each run of the tests; the others take a minute together.
QUICK = ("phone", "dark")
#: What is no page of its own: pieces that scripts ask for, what only leads on, what is no HTML.
NO_PAGES = {
    *(
        "/p/{post_id}",
        "/p/{post_id}/fragment",
        "/p/{post_id}/raw",
        "/robots/{name}/fragment",
        "/notifications/count",
        "/names",
    ),
    *("/admin", "/static/{version}/{name}", "/favicon.ico"),
}


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    with running_world(tmp_path_factory.mktemp("board"), sign_up=True, encoder=Concepts) as world:
        yield world


@pytest.fixture(scope="module")
def names(world: World) -> dict[str, str]:
    return fill(world)


@pytest.fixture(scope="module")
def chromium() -> Iterator[Browser]:
    with running_chromium() as chromium:
        yield chromium


@pytest.fixture
def windows(world: World, chromium: Browser) -> Iterator[Windows]:
    with open_windows(world, chromium) as windows:
        yield windows


def png() -> bytes:
    file = io.BytesIO()
    Image.new("RGB", (640, 480), (20, 90, 90)).save(file, "PNG")
    return file.getvalue()


def violations(page: Page) -> list[str]:
    """What axe finds, one line for each element."""
    # Evaluated, not added as a script: the pages' own policy allows none but theirs.
    page.evaluate(AXE.read_text(encoding="utf-8") + "; 0")
    found: Any = page.evaluate("rules => axe.run(document, { runOnly: rules, resultTypes: ['violations'] })", RULES)
    return [f"{v['id']}: {node['html'][:160]}" for v in found["violations"] for node in v["nodes"]]


def wide(page: Page) -> int:
    """By how many pixels a page must be scrolled sideways."""
    return int(page.evaluate("document.documentElement.scrollWidth - innerWidth"))


def looks() -> list[Any]:
    """Sizes and themes; all but one are slow."""
    every = [(size, theme) for size in SIZES for theme in ("light", "dark")]
    return [pytest.param(*look, marks=[] if look == QUICK else pytest.mark.slow, id="-".join(look)) for look in every]


@pytest.mark.parametrize(("size", "theme"), looks())
def test_every_page_meets_wcag_and_needs_no_scrolling_sideways(
    world: World, windows: Windows, names: dict[str, str], size: str, theme: Any
) -> None:
    how: dict[str, Any] = {"viewport": dict(zip(("width", "height"), SIZES[size], strict=True)), "color_scheme": theme}
    found: dict[str, list[str]] = {}
    for who in ("alice", "bob", "root", None):
        page = windows.open(who, **how)
        for shown in PAGES:
            if shown.who == who and (shown.quick or (size, theme) != QUICK):
                page.goto(shown.path.format(**names), wait_until="domcontentloaded")
                over = wide(page)
                found[shown.name] = violations(page) + ([f"{over} px too wide"] if over > 0 else [])
    windows.complaints = [c for c in windows.complaints if "404" not in c]  # the page that says so
    assert {name: those for name, those in found.items() if those} == {}


def routes_of(router: APIRouter) -> Iterator[APIRoute]:
    """The routes of a router and of those that it includes."""
    for route in router.routes:
        if isinstance(route, APIRoute):
            yield route
        else:
            yield from routes_of(route.original_router)  # type: ignore[attr-defined]


def test_no_page_is_left_out(names: dict[str, str]) -> None:
    page_routes = list(routes_of(routes.router))
    gets = {r.path: r for r in page_routes if "GET" in (r.methods or ()) and not r.path.endswith(".atom")}
    addresses = [shown.path.format(**names).partition("?")[0] for shown in PAGES]
    unseen = {path for path, route in gets.items() if not any(route.path_regex.match(a) for a in addresses)}
    assert len(gets) > 30
    assert unseen == NO_PAGES


def test_what_opens_while_writing_is_accessible_too(world: World, windows: Windows, names: dict[str, str]) -> None:
    page = windows.open("alice")
    page.goto(f"/t/{names['topic']}")
    page.get_by_label("Reply", exact=True).press_sequentially("Hello @qu")
    expect(page.get_by_role("option")).to_have_count(1)
    page.get_by_role("button", name="Preview").click()
    expect(page.get_by_role("region", name="Preview")).to_be_visible()
    page.get_by_label("Pictures").set_input_files({"name": "a.png", "mimeType": "image/png", "buffer": png()})
    expect(page.get_by_role("button", name="Remove a.png")).to_be_visible()
    page.get_by_label("Reply", exact=True).press_sequentially(" @qu")
    expect(page.get_by_role("option")).to_have_count(1)
    assert violations(page) == []


# -------------------------------------------------------------------- by keyboard
def tab_to(page: Page, name: str) -> None:
    """Press Tab until what has this name has the focus."""
    for _ in range(150):
        page.keyboard.press("Tab")
        if name in page.evaluate(
            "document.activeElement.getAttribute('aria-label') ?? document.activeElement.textContent"
        ):
            return
    raise AssertionError(f"Tab does not lead to {name!r}")


def test_a_command_is_written_previewed_and_posted_by_keyboard_alone(world: World, windows: Windows) -> None:
    world.api("quadruped").put("/robots/quadruped", json={"card": CARD}).raise_for_status()  # it is here now
    page = windows.open("alice")
    page.goto("/b/robots/new")
    page.keyboard.type("By keyboard")
    page.keyboard.press("Tab")
    page.keyboard.type("@")
    expect(page.get_by_role("option").first).to_have_text("@quadrupedidle")
    page.keyboard.type("qua")
    expect(page.get_by_role("option")).to_have_count(1)
    page.keyboard.press("Enter")
    page.keyboard.type("walk forward 1 m")
    expect(page.get_by_label("Post", exact=True)).to_have_value("@quadruped walk forward 1 m")
    tab_to(page, "Preview")
    page.keyboard.press("Enter")
    expect(page.get_by_role("region", name="Preview").get_by_role("link", name="@quadruped")).to_be_visible()
    page.keyboard.press("Shift+Tab")
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="By keyboard")).to_be_visible()
    expect(page.locator("article .body")).to_have_text("@quadruped walk forward 1 m")


def test_a_command_that_waits_is_approved_by_keyboard_alone(
    world: World, windows: Windows, names: dict[str, str]
) -> None:
    asks = decisions(world)["asks"]
    page = windows.open("root", viewport={"width": 390, "height": 844})
    page.goto(f"/c/{asks}")
    tab_to(page, "Approve the command of alice to quadruped")
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"
    page.keyboard.press("Enter")
    expect(page.get_by_role("status").filter(has_text="You approved a command")).to_be_visible()
    answers = world.api("root").get(f"/posts/{asks}").json()["topic_id"]
    said = world.api("root").get(f"/topics/{answers}/posts").json()["items"][-1]
    assert (said["author"]["name"], said["raw"], said["reply_to"]) == ("root", f"@{ROBOT} approve", asks)


def test_escape_and_an_at_sign_in_an_address_leave_the_text_alone(world: World, windows: Windows) -> None:
    page = windows.open("alice")
    page.goto("/b/robots/new")
    text = page.get_by_label("Post", exact=True)
    text.press_sequentially("Ask @qua")
    expect(page.get_by_role("option")).to_have_count(1)
    text.press("Escape")
    expect(page.get_by_role("option")).to_have_count(0)
    text.press("Enter")
    text.press_sequentially("me@qua")
    expect(text).to_have_value("Ask @qua\nme@qua")
    expect(page.get_by_role("option")).to_have_count(0)


def test_the_first_tab_leads_to_the_content_and_stop_is_reached_and_seen(
    world: World, windows: Windows, names: dict[str, str]
) -> None:
    alive(world, names)
    page = windows.open("bob")
    page.goto(f"/t/{names['topic']}")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    assert page.evaluate("document.activeElement.id") == "main"
    tab_to(page, "Stop @quadruped")
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"
    page.keyboard.press("Enter")
    expect(page.locator("#live")).to_contain_text("Stop sent to @quadruped")


#: All that a person can do something with on this page and that can be seen, marked so that it is known again. Of radio
#: buttons that belong together Tab reaches the chosen one, and the arrows the others: so browsers do it.
MARK = """() => { let n = 0;
  for (const e of document.querySelectorAll('a[href], button, input, select, textarea, summary, [tabindex="0"]')) {
    if (e.type === 'hidden' || e.disabled || !e.checkVisibility()) continue;
    if (e.type === 'radio' && !e.checked && [...e.form.elements[e.name]].some(one => one.checked)) continue;
    e.dataset.walk = n++;
  }
  return n; }"""
FROM_THE_TOP = """() => { const top = document.createElement('span'); top.tabIndex = -1;
  document.body.prepend(top); top.focus(); }"""
#: What has the focus now: its mark, and whether it shows that, on the screen.
FOCUSED = """() => { const e = document.activeElement;
  if (!e || e === document.body) return null;
  const r = e.getBoundingClientRect();
  const shown = r.bottom > 0 && r.top < innerHeight && r.right > 0 && r.left < innerWidth;
  const look = getComputedStyle(e);
  return [Number(e.dataset.walk ?? -1), shown && look.outlineStyle === 'solid', e.outerHTML.slice(0, 120)]; }"""


#: How many radio buttons belong to the one that has the focus, and its value.
GROUP = """() => { const e = document.activeElement;
  return e.type === 'radio' ? [e.form.elements[e.name].length ?? 1, e.value] : null; }"""


def missed_by_arrows(page: Page) -> list[str]:
    """What is wrong with going through the radio buttons around the focus by arrows; ends where it began."""
    if (group := page.evaluate(GROUP)) is None:
        return []
    size, chosen = group
    values, wrong = [chosen], list[str]()
    for _ in range(size):
        page.keyboard.press("ArrowDown")
        values.append((page.evaluate(GROUP) or [0, "nothing"])[1])
        _, seen, what = page.evaluate(FOCUSED) or (-1, False, "nothing has it")
        if not seen:
            wrong.append(f"its focus is not seen: {what}")
    if len(set(values)) != size or values[-1] != chosen:
        wrong.append(f"arrows reach {values} of {size}")
    return wrong


def walked(page: Page) -> list[str]:
    """What is wrong with going through a page by Tab alone: not reached, not seen, or held fast."""
    marks, got, wrong = page.evaluate(MARK), list[int](), list[str]()
    for _ in range(marks + 20):
        page.keyboard.press("Tab")
        if (focused := page.evaluate(FOCUSED)) is None:
            break
        mark, seen, what = focused
        if mark in got:
            break
        got.append(mark)
        if not seen:
            wrong.append(f"its focus is not seen: {what}")
        wrong += missed_by_arrows(page)
    else:
        wrong.append("Tab never leaves it")
    missing = sorted(set(range(marks)) - set(got))
    html = "n => document.querySelector(`[data-walk='${n}']`).outerHTML.slice(0, 120)"
    wrong += [f"not reached: {page.evaluate(html, n)}" for n in missing]
    return wrong + (["not in the order of the page"] if got != sorted(got) else [])


@pytest.mark.slow
@pytest.mark.parametrize("size", ["desktop", "phone"])
def test_every_page_is_gone_through_by_keyboard_and_shows_where_one_is(
    world: World, windows: Windows, names: dict[str, str], size: str
) -> None:
    found: dict[str, list[str]] = {}
    for who in ("alice", "bob", "root", None):
        page = windows.open(who, viewport=dict(zip(("width", "height"), SIZES[size], strict=True)))
        page.add_init_script("window.setInterval = () => 0")  # nothing is renewed under the marks
        for shown in (s for s in PAGES if s.who == who):
            page.goto(shown.path.format(**names), wait_until="domcontentloaded")
            page.evaluate(FROM_THE_TOP)
            found[shown.name] = walked(page)
    windows.complaints = [c for c in windows.complaints if "404" not in c]  # the page that says so
    assert {name: wrong for name, wrong in found.items() if wrong} == {}


# -------------------------------------------------------------------- with the mouse
DATA = """bytes => { const data = new DataTransfer();
  data.items.add(new File([new Uint8Array(bytes)], 'map.png', { type: 'image/png' })); return data; }"""


@pytest.mark.parametrize("kind", ["paste", "drop"])
def test_a_picture_that_is_pasted_or_dropped_is_attached(
    world: World, windows: Windows, names: dict[str, str], kind: str
) -> None:
    page = windows.open("alice")
    page.goto(f"/t/{names['topic']}")
    data = page.evaluate_handle(DATA, list(png()))
    how = {"paste": "ClipboardEvent", "drop": "DragEvent"}[kind]
    key = {"paste": "clipboardData", "drop": "dataTransfer"}[kind]
    page.evaluate(
        f"data => document.getElementById('body').dispatchEvent("
        f"new {how}('{kind}', {{ {key}: data, bubbles: true, cancelable: true }}))",
        data,
    )
    expect(page.locator(".thumbs img")).to_have_js_property("naturalWidth", 640)
    page.get_by_label("Reply", exact=True).fill(f"by {kind}")
    page.get_by_role("button", name="Reply", exact=True).click()
    post = page.locator("article", has_text=f"by {kind}")
    expect(post.locator(".pictures img")).to_have_js_property("naturalWidth", 640)


def test_who_may_not_add_pictures_is_told_so(world: World, windows: Windows, names: dict[str, str]) -> None:
    page = windows.open("bob")
    page.goto(f"/t/{names['topic']}")
    data = page.evaluate_handle(DATA, list(png()))
    page.evaluate(
        "data => document.getElementById('body').dispatchEvent("
        "new ClipboardEvent('paste', { clipboardData: data, bubbles: true, cancelable: true }))",
        data,
    )
    expect(page.locator("[data-told]")).to_contain_text("Only operators can add pictures here")


def test_a_quote_is_put_where_one_writes_and_loses_nothing(
    world: World, windows: Windows, names: dict[str, str]
) -> None:
    page = windows.open("alice")
    page.goto(f"/t/{names['topic']}")
    text = page.get_by_label("Reply", exact=True)
    text.fill("Before. ")
    page.locator(f"#post-{names['said']}").get_by_role("link", name="Quote this post of bob").click()
    expect(text).to_have_value(
        "Before.\n\n> > walk forward 2 metres\n>\n> @alice that was quick. Next: `@quadruped wave`?\n\n"
    )
    expect(text).to_be_focused()
    assert page.locator("[name=reply_to]").input_value() == names["said"]


def test_the_bell_rings_without_reloading(world: World, windows: Windows, names: dict[str, str]) -> None:
    page = windows.open("bob")
    page.clock.install()
    page.goto("/robots")
    expect(page.get_by_role("link", name="Notifications", exact=True)).to_be_visible()
    body = {"body": "@bob look"}
    world.api("alice").post(f"/topics/{names['topic']}/posts", json=body).raise_for_status()
    page.clock.run_for(10_500)
    expect(page.get_by_role("link", name="Notifications 1 new")).to_be_visible()
