"""The forum's layout in real Chromium: phone width, light and dark themes, contrast, structure, keyboard."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any

import pytest
from PIL import Image
from playwright.sync_api import expect

from agentrob.board.web.templating import STATES
from tests.board.web.browser_windows import (
    RUNNING,
    Windows,
    jpeg,
    new_topic,
    robot_posts,
)
from tests.board.web.forum_site import CARD, Site, running_site

pytestmark = pytest.mark.browser
UNTIL = {"until": "2026-11-22T20:14:05+00:00"}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("board"), sign_up=True) as site:
        site.api("quadruped").put("/robots/quadruped", json={"card": CARD}).raise_for_status()
        yield site


CONTRAST = """() => {
  const parse = text => (text.match(/[\\d.]+/g) || []).map(Number);
  const light = ([r, g, b]) => [r, g, b].map(v => v / 255)
    .map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const ground = element => {
    for (let e = element; e; e = e.parentElement) {
      const colour = parse(getComputedStyle(e).backgroundColor);
      if (colour.length === 3 || colour[3] === 1) return colour;
      if (colour[3] > 0) throw new Error('a half transparent ground');
    }
    return parse(getComputedStyle(document.documentElement).backgroundColor);
  };
  const poor = [];
  for (const element of document.querySelectorAll('body *')) {
    const said = [...element.childNodes].some(n => n.nodeType === 3 && n.data.trim());
    if (!said || !element.checkVisibility() || element.closest('.camera, noscript')) continue;
    const [a, b] = [light(parse(getComputedStyle(element).color)), light(ground(element))].sort((x, y) => y - x);
    const ratio = (a + 0.05) / (b + 0.05);
    if (ratio < 4.5) poor.push(`${element.tagName}.${element.className} ${ratio.toFixed(2)} "${element.textContent}"`);
  }
  return poor;
}"""

STRUCTURE = """() => {
  const wrong = [];
  if (document.querySelectorAll('h1').length !== 1) wrong.push('not one h1');
  if (!document.title || !document.documentElement.lang) wrong.push('no title or language');
  for (const field of document.querySelectorAll('input:not([type=hidden]), textarea'))
    if (!field.labels.length) wrong.push('no label: ' + field.name);
  for (const image of document.querySelectorAll('img'))
    if (!image.hasAttribute('alt')) wrong.push('no alt: ' + image.src);
  const ids = [...document.querySelectorAll('[id]')].map(e => e.id);
  if (new Set(ids).size !== ids.length) wrong.push('an id twice');
  for (const control of document.querySelectorAll('a, button')) {
    const name = control.textContent.trim() || control.getAttribute('aria-label') || control.querySelector('img')?.alt;
    if (!name) wrong.push('no name: ' + control.outerHTML);
  }
  for (const time of document.querySelectorAll('time'))
    if (time.getClientRects().length > 1) wrong.push('a time on two lines: ' + time.textContent);
  let level = 1;
  for (const heading of document.querySelectorAll('main h1, main h2, main h3')) {
    const here = Number(heading.tagName[1]);
    if (here > level + 1) wrong.push('a heading left out before ' + heading.textContent);
    level = here;
  }
  return wrong;
}"""


#: One pair of width and colour scheme; the other pairs are slow.
APPEARANCES = [
    *((390, "dark"), (1280, "light")),
    *(pytest.param(*look, marks=pytest.mark.slow) for look in ((390, "light"), (1280, "dark"))),
]


@pytest.fixture(scope="module")
def paths(site: Site) -> list[str]:
    """Write a thread with content of every kind; return the paths of all pages."""
    topic = new_topic(site, replies=2)
    site.board.add("owner-of-robots")
    site.admin_api().patch("/admin/robots/quadruped", json={"owner": "owner-of-robots"}).raise_for_status()
    long = "a" * 150
    robot_posts(
        site, topic, f"| step | asked | measured |\n|---|--:|--:|\n| {long} | 1 m | 1 m |\n\n```\n{long} {long}\n```"
    )
    robot_posts(site, topic, f"{long} https://example.org/{long}\n\n> quoted\n\n`{long}`", RUNNING)
    for state in STATES:
        robot_posts(site, topic, state, RUNNING | {"state": state, "doing": "a rather long description " * 4} | UNTIL)
    robot = site.api("quadruped")
    image = robot.post("/images", files={"file": ("a.jpg", jpeg(50), "image/jpeg")}).json()["id"]
    robot.post(f"/topics/{topic}/posts", json={"body": "wide", "images": [image]}).raise_for_status()
    post = site.api("bob").post(f"/topics/{topic}/posts", json={"body": "mine"}).json()["post"]["id"]
    site.api("bob").patch(f"/posts/{post}", json={"body": "mine, edited"})
    api = site.api("alice")
    api.post("/topics", json={"board_id": "talk", "title": "W" * 190, "body": "x"}).raise_for_status()
    own = [f"/p/{post}/edit", f"/p/{post}/remove", f"/p/{post}/history"]
    return ["/", "/b/robots", "/b/talk", "/b/robots/new", f"/t/{topic}", *own, "/robots", "/robots/quadruped", "/u/bob"]


@pytest.mark.parametrize(("width", "scheme"), APPEARANCES)
def test_pages_of_a_locked_or_homeless_robot_fit_and_have_contrast(
    site: Site, windows: Windows, scheme: Any, width: int
) -> None:
    robot = site.api("quadruped")
    last_action = {
        "action": "release",
        "by": "w" * 32,
        "at": datetime.now(UTC).isoformat(),
        "message": "It could not. " * 9,
    }
    lock = {"by": "w" * 90, "why": "a rather long reason of its guard " * 5, "at": "2026-11-22T16:00:05+00:00"}
    page = windows.open("root", viewport={"width": width, "height": 800}, color_scheme=scheme)
    try:
        for more in (
            {"lock": lock, "last_action": last_action, "homed": True},
            {"homed": False, "last_action": last_action | {"done": True}},
        ):
            robot.put("/robots/quadruped", json={"card": CARD | more}).raise_for_status()
            for path in ("/", "/robots", "/robots/quadruped", "/robots/quadruped/release", "/robots/quadruped/home"):
                page.goto(path, wait_until="domcontentloaded")
                assert page.evaluate("document.documentElement.scrollWidth") <= width, path
                assert page.evaluate(CONTRAST) == [], path
                assert page.evaluate(STRUCTURE) == [], path
    finally:
        robot.put("/robots/quadruped", json={"card": CARD}).raise_for_status()


@pytest.mark.parametrize(("width", "scheme"), APPEARANCES)
def test_every_page_fits_has_contrast_and_a_valid_structure(
    site: Site, windows: Windows, paths: list[str], scheme: Any, width: int
) -> None:
    size = {"width": width, "height": 800}
    signed_in = windows.open("bob", viewport=size, color_scheme=scheme)
    signed_out = windows.open(viewport=size, color_scheme=scheme)
    visits = [(signed_in, path) for path in paths]
    visits += [(signed_out, path) for path in ("/sign-in", "/sign-up", site.link("bob"))]
    for page, path in visits:
        page.goto(path, wait_until="domcontentloaded")
        assert page.evaluate("document.documentElement.scrollWidth") <= width, path
        assert page.evaluate(CONTRAST) == [], path
        assert page.evaluate(STRUCTURE) == [], path
    ground = signed_in.evaluate("getComputedStyle(document.body).backgroundColor")
    assert (sum(map(int, re.findall(r"\d+", ground))) > 380) == (scheme == "light")


def test_the_keyboard_reaches_the_content_first(windows: Windows) -> None:
    page = windows.open("bob")
    page.goto("/robots")
    page.keyboard.press("Tab")
    skip = page.get_by_role("link", name="Skip to content")
    expect(skip).to_be_focused()
    expect(skip).to_be_in_viewport()
    page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    assert page.evaluate("document.querySelector('main').contains(document.activeElement)")


def test_an_error_page_logs_no_console_errors(windows: Windows) -> None:
    page = windows.open("bob")
    answer = page.goto("/t/999999")
    assert answer is not None
    assert answer.status == 404
    expect(page.get_by_role("heading", name="Not found")).to_be_visible()
    windows.console_errors = [c for c in windows.console_errors if "404" not in c]


@pytest.mark.parametrize("motion", ["no-preference", "reduce"])
def test_a_recording_plays_in_the_thread_or_is_a_link_with_reduced_motion(
    site: Site, windows: Windows, motion: Any
) -> None:
    frames = [Image.new("RGB", (48, 36), (80 * k, 120, 60)) for k in range(3)]
    webp = io.BytesIO()
    frames[0].save(webp, "WEBP", save_all=True, append_images=frames[1:], duration=100)
    topic, robot = new_topic(site), site.api("quadruped")
    image = robot.post("/images", files={"file": ("a.webp", webp.getvalue(), "image/webp")}).json()["id"]
    robot.post(f"/topics/{topic}/posts", json={"body": "walked", "images": [image]}).raise_for_status()
    page = windows.open("bob")
    page.emulate_media(reduced_motion=motion)
    page.goto(f"/t/{topic}")
    recording, link = page.locator("a.moving img"), page.get_by_role("link", name="Play the recording")
    shown, hidden = (link, recording) if motion == "reduce" else (recording, page.locator("a.moving .play"))
    expect(shown).to_be_visible()
    expect(hidden).not_to_be_visible()
    if motion != "reduce":
        assert recording.evaluate("async i => { await i.decode(); return i.naturalWidth; }") == 48
