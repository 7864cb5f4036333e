"""Accessibility in Chromium: axe checks WCAG 2.2 AA on every page, size and theme; every function works by keyboard."""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi import APIRouter
from fastapi.routing import APIRoute
from PIL import Image
from playwright.sync_api import Page, Route, expect

from agentrob.board.web import routes
from tests.board.search.encoder_double import Concepts
from tests.board.web.browser_windows import Windows
from tests.board.web.forum_site import CARD, Site, running_site
from tests.board.web.page_list import PAGES, approval_commands, fill, send_presence
from tests.board.web.sample_reports import ROBOT

pytestmark = pytest.mark.browser

AXE = Path(__file__).parents[1] / "axe" / "node_modules" / "axe-core" / "axe.min.js"
RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]
SIZES = {"desktop": (1280, 900), "phone": (390, 844), "zoomed": (320, 640)}
#: The pair that every run tests; the other pairs take a minute together and are slow tests.
QUICK = ("phone", "dark")
#: Routes that are not full pages: fragments for scripts, redirects, and responses other than HTML.
PARTIAL_ROUTES = {
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
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("board"), sign_up=True, encoder=Concepts) as site:
        yield site


@pytest.fixture(scope="module")
def names(site: Site) -> dict[str, str]:
    return fill(site)


def png() -> bytes:
    file = io.BytesIO()
    Image.new("RGB", (640, 480), (20, 90, 90)).save(file, "PNG")
    return file.getvalue()


def violations(page: Page) -> list[str]:
    """Return axe's findings, one line for each element."""
    # Evaluated instead of added as a script: the pages' content security policy allows only their own scripts.
    page.evaluate(AXE.read_text(encoding="utf-8") + "; 0")
    found: Any = page.evaluate("rules => axe.run(document, { runOnly: rules, resultTypes: ['violations'] })", RULES)
    return [f"{v['id']}: {node['html'][:160]}" for v in found["violations"] for node in v["nodes"]]


def overflow_px(page: Page) -> int:
    """Return by how many pixels the page overflows horizontally."""
    return int(page.evaluate("document.documentElement.scrollWidth - innerWidth"))


def appearances() -> list[Any]:
    """Return all pairs of size and theme; all but one are slow."""
    every = [(size, theme) for size in SIZES for theme in ("light", "dark")]
    return [pytest.param(*look, marks=[] if look == QUICK else pytest.mark.slow, id="-".join(look)) for look in every]


@pytest.mark.parametrize(("size", "theme"), appearances())
def test_every_page_meets_wcag_and_fits_the_width(
    site: Site, windows: Windows, names: dict[str, str], size: str, theme: Any
) -> None:
    how: dict[str, Any] = {"viewport": dict(zip(("width", "height"), SIZES[size], strict=True)), "color_scheme": theme}
    found: dict[str, list[str]] = {}
    for who in ("alice", "bob", "root", None):
        page = windows.open(who, **how)
        for entry in PAGES:
            if entry.who == who and (entry.quick or (size, theme) != QUICK):
                page.goto(entry.path.format(**names), wait_until="domcontentloaded")
                over = overflow_px(page)
                found[entry.name] = violations(page) + ([f"{over} px too wide"] if over > 0 else [])
    windows.console_errors = [c for c in windows.console_errors if "404" not in c]  # the page that says so
    assert {name: those for name, those in found.items() if those} == {}


def routes_of(router: APIRouter) -> Iterator[APIRoute]:
    """Yield the routes of a router and of the routers that it includes."""
    for route in router.routes:
        if isinstance(route, APIRoute):
            yield route
        else:
            yield from routes_of(route.original_router)  # type: ignore[attr-defined]


def test_the_page_list_covers_every_route(names: dict[str, str]) -> None:
    page_routes = list(routes_of(routes.router))
    gets = {r.path: r for r in page_routes if "GET" in (r.methods or ()) and not r.path.endswith((".atom", ".ics"))}
    addresses = [entry.path.format(**names).partition("?")[0] for entry in PAGES]
    unseen = {path for path, route in gets.items() if not any(route.path_regex.match(a) for a in addresses)}
    assert len(gets) > 30
    assert unseen == PARTIAL_ROUTES


def test_popups_of_the_editor_are_accessible(site: Site, windows: Windows, names: dict[str, str]) -> None:
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
    """Press Tab until the element with this name has the focus."""
    for _ in range(150):
        page.keyboard.press("Tab")
        if name in page.evaluate(
            "document.activeElement.getAttribute('aria-label') ?? document.activeElement.textContent"
        ):
            return
    raise AssertionError(f"Tab does not lead to {name!r}")


def test_a_command_can_be_written_previewed_and_posted_by_keyboard(site: Site, windows: Windows) -> None:
    site.api("quadruped").put("/robots/quadruped", json={"card": CARD}).raise_for_status()  # it is here now
    page = windows.open("alice")
    page.goto("/b/robots/new")
    expect(page.get_by_label("Title", exact=True)).to_be_focused()
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


def test_an_example_of_the_home_page_is_posted_by_keyboard(site: Site, windows: Windows) -> None:
    site.api("quadruped").put("/robots/quadruped", json={"card": CARD}).raise_for_status()
    page = windows.open("alice")
    page.goto("/")
    tab_to(page, "@quadruped take a photo")
    page.keyboard.press("Enter")
    box = page.get_by_label("Command", exact=True)
    expect(box).to_be_focused()
    expect(box).to_have_value("@quadruped take a photo")
    tab_to(page, "Send")
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", level=1)).to_have_text("Take a photo")


def test_a_waiting_command_can_be_approved_by_keyboard(site: Site, windows: Windows, names: dict[str, str]) -> None:
    asks = approval_commands(site)["asks"]
    page = windows.open("root", viewport={"width": 390, "height": 844})
    page.goto(f"/c/{asks}")
    tab_to(page, "Approve the command of alice to quadruped")
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"
    page.keyboard.press("Enter")
    expect(page.get_by_role("status").filter(has_text="You approved a command")).to_be_visible()
    answers = site.api("root").get(f"/posts/{asks}").json()["topic_id"]
    said = site.api("root").get(f"/topics/{answers}/posts").json()["items"][-1]
    assert (said["author"]["name"], said["raw"], said["reply_to"]) == ("root", f"@{ROBOT} approve", asks)


def test_escape_closes_the_name_list_and_an_email_address_does_not_open_it(site: Site, windows: Windows) -> None:
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


def test_escape_closes_the_name_list_also_while_names_are_being_looked_up(site: Site, windows: Windows) -> None:
    page = windows.open("alice")
    page.goto("/b/robots/new")
    held: list[Route] = []

    def hold(route: Route) -> None:
        held.append(route)

    page.route("**/names?q=qua", hold)
    text = page.get_by_label("Post", exact=True)
    text.press_sequentially("Ask @qu")
    expect(page.get_by_role("option")).to_have_count(1)
    with page.expect_request("**/names?q=qua"):
        text.press("a")
    text.press("Escape")
    with page.expect_response("**/names?q=qua"):
        held[0].continue_()
    page.unroute("**/names?q=qua")
    page.evaluate("fetch('/names?q=qua').then((answer) => answer.json())")  # later than the answer that was held
    expect(page.get_by_role("option")).to_have_count(0)
    text.press("Enter")
    expect(text).to_have_value("Ask @qua\n")


def test_the_first_tab_skips_to_the_content_and_stop_is_reachable_and_visible(
    site: Site, windows: Windows, names: dict[str, str]
) -> None:
    send_presence(site, names)
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
FOCUS_TOP = """() => { const top = document.createElement('span'); top.tabIndex = -1;
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


def radio_group_problems(page: Page) -> list[str]:
    """Step through the focused group of radio buttons with the arrow keys, back to the start; return the problems."""
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


def tab_order_problems(page: Page) -> list[str]:
    """Step through a page with Tab; return the problems: controls not reached, focus not visible, focus trapped."""
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
        wrong += radio_group_problems(page)
    else:
        wrong.append("Tab never leaves it")
    missing = sorted(set(range(marks)) - set(got))
    html = "n => document.querySelector(`[data-walk='${n}']`).outerHTML.slice(0, 120)"
    wrong += [f"not reached: {page.evaluate(html, n)}" for n in missing]
    return wrong + (["not in the order of the page"] if got != sorted(got) else [])


@pytest.mark.slow
@pytest.mark.parametrize("size", ["desktop", "phone"])
def test_every_control_is_reachable_by_tab_with_a_visible_focus(
    site: Site, windows: Windows, names: dict[str, str], size: str
) -> None:
    found: dict[str, list[str]] = {}
    for who in ("alice", "bob", "root", None):
        page = windows.open(who, viewport=dict(zip(("width", "height"), SIZES[size], strict=True)))
        page.add_init_script("window.setInterval = () => 0")  # nothing is renewed under the marks
        for entry in (s for s in PAGES if s.who == who):
            page.goto(entry.path.format(**names), wait_until="domcontentloaded")
            if page.locator(".replay").count():
                page.locator(".replay .live-controls").first.wait_for()  # added once the replay is loaded
            page.evaluate(FOCUS_TOP)
            found[entry.name] = tab_order_problems(page)
    windows.console_errors = [c for c in windows.console_errors if "404" not in c]  # the page that says so
    assert {name: wrong for name, wrong in found.items() if wrong} == {}


# -------------------------------------------------------------------- with the mouse
DATA = """bytes => { const data = new DataTransfer();
  data.items.add(new File([new Uint8Array(bytes)], 'map.png', { type: 'image/png' })); return data; }"""


@pytest.mark.parametrize("kind", ["paste", "drop"])
def test_a_pasted_or_dropped_picture_is_attached(
    site: Site, windows: Windows, names: dict[str, str], kind: str
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


def test_an_account_that_may_not_upload_is_told_so(site: Site, windows: Windows, names: dict[str, str]) -> None:
    page = windows.open("bob")
    page.goto(f"/t/{names['topic']}")
    data = page.evaluate_handle(DATA, list(png()))
    page.evaluate(
        "data => document.getElementById('body').dispatchEvent("
        "new ClipboardEvent('paste', { clipboardData: data, bubbles: true, cancelable: true }))",
        data,
    )
    expect(page.locator("[data-told]")).to_contain_text("Only operators can add pictures here")


def test_a_quote_is_inserted_into_the_draft_without_losing_text(
    site: Site, windows: Windows, names: dict[str, str]
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


def test_the_notification_count_updates_without_reloading(site: Site, windows: Windows, names: dict[str, str]) -> None:
    page = windows.open("bob")
    page.clock.install()
    page.goto("/robots")
    expect(page.get_by_role("link", name="Notifications", exact=True)).to_be_visible()
    body = {"body": "@bob look"}
    site.api("alice").post(f"/topics/{names['topic']}/posts", json=body).raise_for_status()
    page.clock.run_for(10_500)
    expect(page.get_by_role("link", name="Notifications 1 new")).to_be_visible()
