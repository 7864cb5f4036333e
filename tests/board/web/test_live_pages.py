"""The forum in real Chromium: threads update without jumping, stop works with and without scripts, the camera runs."""

from __future__ import annotations

import gzip
import re
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest
from playwright.sync_api import Page, Route, expect

from agentrob.board import server
from tests.board.web.browser_windows import (
    RUNNING,
    Windows,
    jpeg,
    new_topic,
    robot_edits,
    robot_posts,
)
from tests.board.web.forum_site import CARD, Site, running_site

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("board"), sign_up=True) as site:
        site.api("quadruped").put("/robots/quadruped", json={"card": CARD}).raise_for_status()
        yield site


def wait_live(page: Page) -> None:
    """Until the event stream is open."""
    page.wait_for_selector("html[data-live=on]", state="attached")


def top_of(page: Page, selector: str) -> float:
    return float(page.eval_on_selector(selector, "e => e.getBoundingClientRect().top"))


# -------------------------------------------------------------------- the live thread
def test_the_robots_reply_appears_without_reloading(site: Site, windows: Windows) -> None:
    page = windows.open()
    page.goto(site.link("alice"))
    page.get_by_role("button", name="Enter").click()
    expect(page.get_by_role("heading", name="Boards", exact=True)).to_be_visible()
    page.get_by_role("link", name="Robots", exact=True).last.click()
    page.goto("/b/robots")
    page.get_by_role("link", name="New topic").click()
    page.get_by_label("Title").fill("First steps")
    page.get_by_label("Post", exact=True).fill("@quadruped walk forward 1 metre")
    page.get_by_role("button", name="Post", exact=True).click()
    expect(page.get_by_role("heading", name="First steps")).to_be_visible()
    topic = page.url.rsplit("/", 1)[1]
    wait_live(page)
    page.evaluate("window.sameDocument = true")

    post = robot_posts(site, topic, "Seen.", RUNNING | {"state": "seen", "step": 0})
    article = page.locator(f"#post-{post}")
    expect(article.locator(".chip")).to_have_text("seen")
    expect(article.locator(".badge")).to_have_text("robot")
    robot_edits(site, post, "Queued.", RUNNING | {"state": "queued", "place": 1})
    expect(article.locator(".status")).to_contain_text("place 1 in the queue")
    robot_edits(site, post, "Step 2.", RUNNING)
    expect(article.locator(".status")).to_contain_text("step 2 of 4: turning")
    expect(article.get_by_role("button", name="Stop @quadruped")).to_be_visible()
    robot_edits(site, post, "**Asked 1.00 m, measured 1.02 m.**", RUNNING | {"state": "done", "step": 4})
    expect(article.locator(".chip")).to_have_text("done")
    expect(article.locator("strong")).to_have_text("Asked 1.00 m, measured 1.02 m.")
    expect(article.get_by_role("button")).to_have_count(0)
    expect(page.locator("article")).to_have_count(2)
    assert page.evaluate("window.sameDocument")


def test_a_part_of_several_robots_says_what_it_waits_for_and_to_whom_it_was_left(site: Site, windows: Windows) -> None:
    topic = new_topic(site)
    page = windows.open("bob")
    page.goto(f"/t/{topic}")
    wait_live(page)
    part = {"robot": "quadruped", "state": "queued", "trace_id": "t", "part": 1, "parts": 2}
    post = robot_posts(site, topic, "Waits.", part | {"until": "2030-01-01T10:00:00+00:00"})
    article = page.locator(f"#post-{post}")
    expect(article.locator(".status-line")).to_contain_text("waits for another part, at most until")
    robot_edits(site, post, "Bids.", part | {"bid_s": 8, "near_cm": 120, "room": "lab"})
    expect(article.locator(".status-line")).to_have_text("bids 8 s, 1.20 m away")
    robot_edits(site, post, "Left.", part | {"state": "cancelled", "left_to": "humanoid"})
    expect(article.locator(".chip")).to_have_text("left to @humanoid")
    takes = robot_posts(site, topic, "I do it.", part | {"state": "answered", "takes": 1})
    expect(page.locator(f"#post-{takes} .chip")).to_have_text("takes part 1")
    expect(page.locator(f"#post-{takes}").get_by_role("link", name="Record")).to_have_count(0)


def test_many_edits_in_a_row_end_with_the_last_one(site: Site, windows: Windows) -> None:
    topic = new_topic(site)
    page = windows.open("bob")
    page.goto(f"/t/{topic}")
    wait_live(page)
    post = robot_posts(site, topic, "edit 0")
    for n in range(1, 15):
        robot_edits(site, post, f"edit {n}")
    expect(page.locator(f"#post-{post} .body")).to_have_text("edit 14")
    expect(page.locator(f"#post-{post}")).to_have_attribute("data-version", "15")


def test_a_removed_post_disappears_from_open_pages(site: Site, windows: Windows) -> None:
    topic = new_topic(site)
    post = robot_posts(site, topic, "soon gone")
    page = windows.open("bob")
    page.goto(f"/t/{topic}")
    wait_live(page)
    site.api("admin").delete(f"/posts/{post}").raise_for_status()
    expect(page.locator(f"#post-{post}")).to_contain_text("This post was removed.")


def test_new_posts_do_not_move_the_text_that_is_being_read(site: Site, windows: Windows) -> None:
    topic = new_topic(site)
    first = robot_posts(site, topic, "short")
    for n in range(20):
        robot_posts(site, topic, f"number {n}\n\nand more")
    page = windows.open("bob")
    page.goto(f"/t/{topic}")
    wait_live(page)
    middle = f"#post-{int(first) + 10}"
    page.eval_on_selector(middle, "e => window.scrollTo(0, window.scrollY + e.getBoundingClientRect().top)")
    before = top_of(page, middle)
    robot_edits(site, first, "\n\n".join(["a much longer text"] * 12))
    expect(page.locator(f"#post-{first}")).to_have_attribute("data-version", "2")
    late = robot_posts(site, topic, "at the end")
    expect(page.locator(f"#post-{late}")).to_be_attached()
    assert abs(top_of(page, middle) - before) <= 1
    pill = page.get_by_role("link", name="1 new post below")
    expect(pill).to_be_visible()
    pill.click()
    expect(page.locator(f"#post-{late}")).to_be_in_viewport()
    expect(pill).to_have_count(0)
    expect(page.locator("#live")).to_have_text("")


def test_new_posts_do_not_move_the_reply_form_while_typing(site: Site, windows: Windows) -> None:
    topic = new_topic(site, replies=12)
    page = windows.open("bob")
    page.goto(f"/t/{topic}")
    wait_live(page)
    page.get_by_label("Reply").fill("half a sen")
    page.get_by_label("Reply").focus()
    before = top_of(page, "#reply")
    for n in range(3):
        post = robot_posts(site, topic, f"new {n}\n\nwith more lines\n\nand more")
        expect(page.locator(f"#post-{post}")).to_be_attached()
    assert abs(top_of(page, "#reply") - before) <= 1
    expect(page.get_by_label("Reply")).to_be_focused()
    expect(page.get_by_label("Reply")).to_have_value("half a sen")


def test_a_lost_stream_resumes_without_a_gap(site: Site, windows: Windows) -> None:
    topic = new_topic(site)
    page = windows.open("bob")
    page.add_init_script("""
        window.streams = [];
        window.EventSource = class extends EventSource {
          constructor(...how) { super(...how); window.streams.push(this); }
        };""")
    page.goto(f"/t/{topic}")
    wait_live(page)
    seen = robot_posts(site, topic, "before")
    expect(page.locator(f"#post-{seen}")).to_be_attached()
    page.evaluate("streams[0].close(); streams[0].dispatchEvent(new Event('error'))")
    expect(page.locator("#live")).to_have_text("Connection lost, trying again…")
    missed = robot_posts(site, topic, "meanwhile")
    robot_edits(site, seen, "edited meanwhile")
    expect(page.locator(f"#post-{missed}")).to_be_attached()
    expect(page.locator(f"#post-{seen} .body")).to_have_text("edited meanwhile")
    assert page.evaluate("streams.length") == 2


def test_a_page_before_the_last_offers_a_link_to_new_posts(site: Site, windows: Windows) -> None:
    topic = new_topic(site, replies=55)
    page = windows.open("bob")
    page.goto(f"/t/{topic}")
    wait_live(page)
    post = robot_posts(site, topic, "far away")
    page.get_by_role("link", name="New posts").click()
    expect(page.locator(f"#post-{post}")).to_be_in_viewport()


def test_a_board_page_announces_new_topics(site: Site, windows: Windows) -> None:
    page = windows.open("bob")
    page.goto("/b/robots")
    wait_live(page)
    new_topic(site)
    page.get_by_role("link", name="New posts: show them").click()
    expect(page.get_by_role("link", name="A walk").first).to_be_visible()


def test_a_page_from_before_a_restored_backup_offers_to_reload(site: Site, windows: Windows) -> None:
    def undone(route: Route) -> None:
        answer = route.fetch()
        body, changed = re.subn(r'data-after="(\d+)-\w+"', r'data-after="\1-1"', answer.text())
        assert changed == 1
        route.fulfill(response=answer, body=body)

    new_topic(site)
    page = windows.open("bob")
    page.route("**/b/robots", undone)
    page.goto("/b/robots")
    anew = page.get_by_role("link", name="The forum was restored from a backup: reload this page")
    expect(anew).to_be_visible(timeout=60_000)
    page.unroute("**/b/robots")
    anew.click()
    wait_live(page)
    assert [c for c in windows.console_errors if "404" in c], "the browser says that the stream was refused"
    windows.console_errors = [c for c in windows.console_errors if "404" not in c]


# -------------------------------------------------------------------- stop
def stops(site: Site, after: str) -> list[tuple[str, str]]:
    items = site.api("quadruped").get("/changes", params={"after": after}).json()["items"]
    return [(e["robot"], e["account"]["name"]) for e in items if e["kind"] == "robot.stop"]


def now(site: Site) -> str:
    return str(site.api("quadruped").get("/changes").json()["now"]["id"])


def test_stop_in_the_thread_with_scripts_stays_on_the_page(site: Site, windows: Windows) -> None:
    topic = new_topic(site)
    post = robot_posts(site, topic, "Running.", RUNNING)
    page = windows.open("bob")
    page.goto(f"/t/{topic}")
    before = now(site)
    page.evaluate("window.sameDocument = true")
    page.locator(f"#post-{post}").get_by_role("button", name="Stop @quadruped").click()
    sent = "Stop sent to @quadruped. Its reply says how fast it stopped, or that it did not confirm the stop."
    expect(page.locator("#live")).to_have_text(sent)
    assert stops(site, before) == [("quadruped", "bob")]
    assert page.evaluate("window.sameDocument")


def test_everything_works_with_scripts_disabled(site: Site, windows: Windows) -> None:
    page = windows.open("bob", java_script_enabled=False)
    topic = new_topic(site)
    post = robot_posts(site, topic, "Running.", RUNNING)
    page.goto(f"/t/{topic}")
    page.get_by_label("Reply").fill("I watch")
    page.get_by_role("button", name="Reply").click()
    expect(page.locator("article").last).to_contain_text("I watch")
    before = now(site)
    page.locator(f"#post-{post}").get_by_role("button", name="Stop @quadruped").click()
    expect(page.get_by_role("status").first).to_contain_text("Stop sent to @quadruped")
    assert stops(site, before) == [("quadruped", "bob")]


@pytest.mark.parametrize("scripts", [True, False], ids=["scripts", "no scripts"])
def test_law_17_emergency_stop_and_release_with_and_without_scripts(
    site: Site, windows: Windows, scripts: bool
) -> None:
    robot, before = site.api("quadruped"), now(site)
    page = windows.open("root", java_script_enabled=scripts)
    page.goto("/robots/quadruped", wait_until="domcontentloaded")  # without scripts the camera goes on for ever
    page.get_by_role("button", name="Emergency stop").click()
    expect(page.locator("main")).to_contain_text("Emergency stop sent to @quadruped")
    expect(page.locator("main")).to_contain_text("It stays locked until its owner releases it.")
    lock = {"by": "root", "why": "an emergency stop", "at": "2026-11-22T16:00:05+00:00"}
    robot.put("/robots/quadruped", json={"card": CARD | {"lock": lock, "homed": True}}).raise_for_status()
    if not scripts:
        page.goto("/robots/quadruped", wait_until="domcontentloaded")
    expect(page.locator(".lock")).to_contain_text("Locked by root since", timeout=60_000)
    page.get_by_role("link", name="Release @quadruped").click()
    expect(page.get_by_role("heading", name="Release @quadruped?")).to_be_visible()
    page.get_by_role("button", name="Release @quadruped").click()
    expect(page.get_by_role("status").first).to_contain_text("Asked @quadruped")
    last_action = {
        "action": "release",
        "by": "root",
        "at": datetime.now(UTC).isoformat(),
        "done": True,
        "message": "It was locked.",
    }
    robot.put(
        "/robots/quadruped", json={"card": CARD | {"lock": None, "homed": True, "last_action": last_action}}
    ).raise_for_status()
    if not scripts:
        page.goto("/robots/quadruped", wait_until="domcontentloaded")
    expect(page.get_by_text("Released (root, ")).to_be_visible(timeout=60_000)
    expect(page.locator(".lock")).to_have_count(0)
    items = robot.get("/changes", params={"after": before}).json()["items"]
    assert [(e["kind"], e["account"]["name"]) for e in items] == [("robot.estop", "root"), ("robot.release", "root")]


def test_stop_buttons_are_large_enough_for_a_thumb(site: Site, windows: Windows) -> None:
    topic = new_topic(site)
    robot_posts(site, topic, "Running.", RUNNING)
    page = windows.open("bob", viewport={"width": 390, "height": 844})
    for path in (f"/t/{topic}", "/robots/quadruped"):
        page.goto(path)
        sizes = page.eval_on_selector_all(".stop", "all => all.map(e => [e.offsetWidth, e.offsetHeight])")
        assert sizes
        assert all(width >= 44 and height >= 44 for width, height in sizes)


# -------------------------------------------------------------------- the robot's page
def frame(site: Site, shade: int = 100) -> int:
    """Send a camera frame as the robot's agent; return the number of viewers."""
    answer = site.api("quadruped").put(
        "/robots/quadruped/frame", content=jpeg(shade), headers={"Content-Type": "image/jpeg"}
    )
    return int(answer.json()["viewers"])


def wait_viewers(site: Site, number: int) -> None:
    end = time.monotonic() + 60
    while (seen := frame(site)) != number:
        assert time.monotonic() < end, f"{seen} look, not {number}"


def test_the_camera_runs_only_while_somebody_watches(site: Site, windows: Windows) -> None:
    wait_viewers(site, 0)
    page = windows.open("bob")
    page.goto("/robots/quadruped", wait_until="domcontentloaded")  # the camera may keep it loading
    wait_viewers(site, 1)
    frame(site)  # only pictures from after its arrival are a viewer's, and it shows one when the next one comes
    expect(page.locator(".camera img")).to_have_js_property("naturalWidth", 64)
    page.set_viewport_size({"width": 390, "height": 300})
    page.evaluate("window.scrollTo(0, document.body.scrollHeight)")
    wait_viewers(site, 0)
    page.locator(".camera").scroll_into_view_if_needed()
    wait_viewers(site, 1)
    page.goto("/robots")
    wait_viewers(site, 0)


def test_a_failed_camera_stream_is_retried(site: Site, windows: Windows) -> None:
    wait_viewers(site, 0)
    page = windows.open("bob")
    page.route("**/camera.mjpg*", lambda route: route.abort())
    with page.expect_event("requestfailed", lambda request: "camera.mjpg" in request.url):
        page.goto("/robots/quadruped", wait_until="domcontentloaded")
    page.unroute("**/camera.mjpg*")
    wait_viewers(site, 1)
    frame(site)
    expect(page.locator(".camera img")).to_have_js_property("naturalWidth", 64)
    page.goto("/robots")
    wait_viewers(site, 0)
    assert [c for c in windows.console_errors if "ERR_FAILED" in c], "the browser says that the picture did not come"
    windows.console_errors = [c for c in windows.console_errors if "ERR_FAILED" not in c]


def test_the_robots_state_is_updated(site: Site, windows: Windows) -> None:
    page = windows.open("bob")
    page.goto("/robots/quadruped", wait_until="domcontentloaded")  # the camera may keep it loading
    expect(page.locator(".facts-state")).to_contain_text("idle")
    site.api("quadruped").put("/robots/quadruped", json={"card": CARD | {"state": "walking", "battery_percent": 12}})
    expect(page.locator(".facts-state")).to_contain_text("walking")
    expect(page.locator(".battery")).to_contain_text("12 %")
    site.api("quadruped").put("/robots/quadruped", json={"card": CARD})


def test_the_forums_scripts_stay_small() -> None:
    """As they are sent; `test_home` limits the first page as a whole."""
    folder = Path(server.__file__).parent / "web/static"
    sizes = [len(gzip.compress((folder / name).read_bytes(), 9)) for name in ("live.js", "write.js")]
    assert min(sizes) > 0
    assert sum(sizes) <= 9_000
