"""The live map and the replay in real Chromium, under the board's content policy, and as pictures without scripts."""

from __future__ import annotations

import gzip
import json
from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.board.web.browser_windows import Windows
from tests.board.web.forum_site import CARD, Site, running_site
from tests.waiting import wait_for

pytestmark = pytest.mark.browser

MAP = {
    "room": "lab",
    "size_m": [8, 6],
    "fence": [[-2, -2], [2, -2], [2, 2], [-2, 2]],
    "things": [
        {"name": "table", "at_m": [1, -2], "size_m": [1.2, 0.7]},
        {"name": "ball", "at_m": [2, 1], "radius_m": 0.2},
    ],
    "pose": [0.5, 1.0, 0.0],
    "geometry": "",
}
REPLAY = {
    "version": 1, "robot": "quadruped", "map": MAP, "geometry": "", "plan": [[0, 0], [2, 0]],
    "steps": [[0, "move forward 2 m"], [2000, "turn left 90°"]], "t": [0] + [100] * 40,
    "pose": [[0] + [50] * 40, [0] * 41, [0] * 41], "body": [],
}  # fmt: skip


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("board")) as site:
        card = CARD | {"boards": ["robots"], "map": MAP}
        site.api("quadruped").put("/robots/quadruped", json={"card": card}).raise_for_status()
        yield site


def command(site: Site) -> tuple[str, str]:
    """A topic with a command, and the command's post."""
    new = {"board_id": "robots", "title": "A walk", "body": "@quadruped walk forward 2 metres"}
    made = site.api("alice").post("/topics", json=new).json()
    return str(made["topic"]["id"]), str(made["post"]["id"])


def pose(site: Site, x: float, y: float, **more: Any) -> int:
    sent = site.api("quadruped").put("/robots/quadruped/pose", json={"pose": [x, y, 0.0], **more})
    return int(sent.json()["viewers"])


def mark_at(page: Page) -> tuple[float, float]:
    """Where the map shows the robot, in metres of the room."""
    text = page.locator(".map-mark").first.get_attribute("transform") or ""
    x, y = text.removeprefix("translate(").split(")")[0].split()
    return float(x), -float(y)


def wait_until_at(page: Page, x: float, y: float) -> None:
    page.wait_for_function(
        """([x, y]) => {
          const told = document.querySelector(".map-mark").getAttribute("transform");
          const [, a, b] = /translate\\(([-.\\d]+) ([-.\\d]+)\\)/.exec(told);
          return Math.hypot(a - x, -b - y) < 0.02;
        }""",
        arg=[x, y],
    )


def test_the_robot_moves_on_the_map_of_an_open_topic(site: Site, windows: Windows) -> None:
    topic, _ = command(site)
    page = windows.open("alice")
    page.goto(f"/t/{topic}")
    assert mark_at(page) == (0.5, 1.0), "where its card says that it was"
    expect(page.locator(".map-thing")).to_have_count(2)
    page.wait_for_function("() => document.querySelector('.live-view') !== null")
    wait_for(lambda: pose(site, 0.5, 1.0, plan=[[0.5, 1], [1.5, 1]], trail=[[0.5, 1]]) > 0)
    expect(page.locator(".live-state")).to_have_text("now")
    pose(site, 1.5, 1.0)
    wait_until_at(page, 1.5, 1.0)
    assert page.locator(".map-plan").get_attribute("points") == "0.50,-1.00 1.50,-1.00"
    assert (page.locator(".map-path").get_attribute("points") or "").endswith("1.50,-1.00")
    expect(page.locator(".live-state")).to_contain_text("no position now")


def test_poses_stop_when_the_page_is_left(site: Site, windows: Windows) -> None:
    page = windows.open("alice")
    page.goto("/robots/quadruped")
    wait_for(lambda: pose(site, 0.5, 1.0) > 0)
    page.goto("/robots")
    wait_for(lambda: pose(site, 0.5, 1.0) == 0)


def test_the_3d_view_is_loaded_only_when_asked_for_and_falls_back_to_the_map(site: Site, windows: Windows) -> None:
    topic, _ = command(site)
    page = windows.open("alice")
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    missing = "no 3D model of a rover is known"
    card = CARD | {"map": MAP | {"no_geometry": missing}}
    page.goto(f"/t/{topic}")
    site.api("quadruped").put("/robots/quadruped", json={"card": card}).raise_for_status()
    page.get_by_role("button", name="3D").click()
    expect(page.locator(".live-state")).to_contain_text(f"3D is not available here: {missing}")
    expect(page.locator(".map")).to_be_visible()
    expect(page.get_by_role("button", name="3D")).to_have_count(0)
    assert not [url for url in asked if "viewer3d" in url], "without a shape three.js is not loaded either"


def test_a_robot_without_a_shape_has_no_3d_button(site: Site, windows: Windows) -> None:
    topic, _ = command(site)
    card = CARD | {"map": MAP | {"no_geometry": "the robot's owner shows its map only"}}
    site.api("quadruped").put("/robots/quadruped", json={"card": card}).raise_for_status()
    page = windows.open("alice")
    page.goto(f"/t/{topic}")
    expect(page.locator(".map")).to_be_visible()
    expect(page.locator(".live-state")).not_to_have_text("")
    expect(page.get_by_role("button", name="3D")).to_have_count(0)


def test_the_replay_plays_pauses_and_goes_to_a_time(site: Site, windows: Windows) -> None:
    topic, post = command(site)
    robot = site.api("quadruped")
    reply = robot.post(f"/topics/{topic}/posts", json={"body": "Done.", "reply_to": post}).json()["post"]["id"]
    record = {"robot": "quadruped", "status": "done", "steps": []}
    robot.put(f"/commands/{post}", json={"reply_id": reply, "record": record}).raise_for_status()
    robot.put(f"/commands/{post}/replay", content=gzip.compress(json.dumps(REPLAY).encode())).raise_for_status()
    page = windows.open("alice")
    page.goto(f"/c/{post}")
    slider = page.get_by_label("Time in the replay")
    assert mark_at(page) == (2.0, 0.0), "it shows the end"
    slider.fill("1000")
    wait_until_at(page, 0.5, 0.0)
    expect(page.locator(".live-step")).to_have_text("move forward 2 m")
    page.get_by_label("Speed").select_option("4")
    page.get_by_role("button", name="Play").click()
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    wait_until_at(page, 2.0, 0.0)
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    expect(page.locator(".live-step")).to_have_text("turn left 90°")
    slider.fill("2000")
    page.get_by_role("button", name="Copy link").click()
    page.wait_for_url("**/c/*at=2.0*")
    shared = page.url
    assert shared.endswith("#replay-quadruped")
    page.goto("/robots")
    page.goto(shared)
    wait_until_at(page, 1.0, 0.0)


def test_without_scripts_the_pages_show_the_last_picture(site: Site) -> None:
    topic, post = command(site)
    site.api("quadruped").put(f"/commands/{post}", json={"record": {"robot": "quadruped"}}).raise_for_status()
    replay = gzip.compress(json.dumps(REPLAY).encode())
    site.api("quadruped").put(f"/commands/{post}/replay", content=replay).raise_for_status()
    alice = site.browser("alice")
    for path, at in ((f"/t/{topic}", "translate(0.5 -1.0)"), ("/robots/quadruped", "translate(0.5 -1.0)")):
        assert at in alice.get(path).text, path
    shown = alice.get(f"/c/{post}").text
    assert "translate(2.0 -0.0)" in shown
    assert 'class="map-path" points="0.00,-0.00 0.05,-0.00' in shown
    assert shown.count('class="map-thing"') == 2


def test_whoever_is_asked_to_approve_sees_the_preview_replayed_and_it_is_never_called_measured(site: Site) -> None:
    topic, post = command(site)
    robot, alice = site.api("quadruped"), site.browser("alice")
    card = {"robot": "quadruped", "state": "waiting", "trace_id": "0123456789ab"}
    asked = {"body": "**Waits for approval.**", "reply_to": post, "card": card}
    robot.post(f"/topics/{topic}/posts", json=asked).raise_for_status()
    simulated = gzip.compress(json.dumps(REPLAY | {"simulated": True}).encode())
    robot.put(f"/commands/{post}/replay", content=simulated).raise_for_status()
    waiting = alice.get(f"/c/{post}").text
    assert "Waits for approval." in waiting
    assert "Replay of the preview: simulated, nothing moved" in waiting
    assert "</i> simulated</span>" in waiting
    robot.put(
        f"/commands/{post}", json={"record": {"robot": "quadruped", "steps": [{"op": "move"}]}}
    ).raise_for_status()
    assert "Replay of the preview: simulated, nothing moved" in alice.get(f"/c/{post}").text  # no other one came
    robot.put(f"/commands/{post}/replay", content=gzip.compress(json.dumps(REPLAY).encode())).raise_for_status()
    assert "Replay of the preview" not in alice.get(f"/c/{post}").text


def test_who_may_not_read_the_robots_boards_sees_no_map(site: Site) -> None:
    admin = site.admin_api()
    admin.post("/admin/boards", json={"id": "open", "name": "Open"}).raise_for_status()
    roles = {"read_role": "moderator", "post_role": "moderator", "command_role": "moderator"}
    admin.patch("/admin/boards/robots", json=roles).raise_for_status()
    try:
        assert "live-view" not in site.browser("bob").get("/robots/quadruped").text
        assert "live-view" in site.browser("root").get("/robots/quadruped").text
    finally:
        open_again = {"read_role": "guest", "post_role": "member", "command_role": "operator"}
        admin.patch("/admin/boards/robots", json=open_again).raise_for_status()
