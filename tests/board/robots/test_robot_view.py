"""The board stores any card that a robot's agent sends, and the page renders no markup from it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.board.events.presence import LIVE_FOR
from agentrob.board.robots.view import robot_view
from agentrob.board.web.templating import own_path, status_card
from tests.board.web.forum_site import CARD, Site, running_site

json = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=10), inner, max_size=4),
    max_leaves=12,
)
fields = st.sampled_from(
    [*CARD, "lock", "homed", "last_action", "owner", "robot", "step", "steps", "doing", "place", "trace_id", "<b>"]
)
cards = st.dictionaries(fields, json, max_size=10)


@given(cards)
def test_any_card_of_a_robot_can_be_rendered(card: dict[str, Any]) -> None:
    view = robot_view("quadruped", card, None)
    assert not view.live
    assert view.battery is None or 0 <= view.battery <= 100
    assert all(isinstance(word, str) for word in (view.state, view.model, *view.ops))
    assert all(isinstance(value, str) for line in view.facts + view.limits for value in line)


@given(cards)
def test_any_card_of_a_command_can_be_rendered(card: dict[str, Any]) -> None:
    view = status_card(card)
    assert view.state.replace("_", "").isalpha() or view.state.strip("_") == ""
    assert view.step >= 0
    assert view.steps >= 0
    assert "/" not in view.robot


@given(st.text())
def test_a_return_address_is_always_on_this_forum(path: str) -> None:
    own = own_path(path)
    assert own.startswith("/")
    assert not own.startswith(("//", "/\\"))
    assert own.isascii()
    assert own.isprintable()


def test_an_absurdly_large_number_is_not_an_error() -> None:
    view = robot_view("quadruped", {"battery_percent": 10**400, "limits": {"speed_mps": 10**400}}, None)
    assert view.battery is None
    assert view.limits == (("Speed", "? m/s"),)


def test_a_robot_is_live_while_its_agent_sends_cards() -> None:
    now = datetime.now(UTC)
    assert robot_view("quadruped", CARD, now).live
    assert not robot_view("quadruped", CARD, now - timedelta(seconds=20)).live


def test_limits_of_walks_and_turns_are_not_shown_for_a_robot_that_does_neither() -> None:
    limits = CARD["limits"] | {"turn_dps": 45, "step_m": 5, "step_deg": 360, "command_steps": 10}
    arm = robot_view("arm", CARD | {"ops": ["hello", "photo"], "limits": limits}, None)
    assert arm.limits == (("One command", "60 s, 10 steps"),)
    head = robot_view("head", CARD | {"ops": ["turn"], "limits": limits}, None)
    assert head.limits == (("One command", "60 s, 10 steps"), ("Turning", "45°/s"), ("One turn", "360°"))


def test_the_limits_of_a_command_are_one_line() -> None:
    view = robot_view("quadruped", CARD, None)
    assert view.limits == (("Speed", "0.5 m/s"), ("One command", "10 m, 60 s"))
    assert view.ops == ("walk", "turn", "wave", "take a photo")
    assert ("Model", "go2") in view.facts


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("board")) as site:
        yield site


def test_the_page_of_a_robot_without_a_camera_has_no_picture_area(site: Site) -> None:
    robot, visitor = site.api("quadruped"), site.browser("bob")
    for card, there in (({"model": "rover", "camera": False}, False), ({"model": "go2", "camera": True}, True)):
        robot.put("/robots/quadruped", json={"card": card}).raise_for_status()
        page = visitor.get("/robots/quadruped").text
        assert ("camera.mjpg" in page) is ("The camera runs while you watch" in page) is there
    robot.put("/robots/quadruped", json={"card": {"model": "of before"}}).raise_for_status()
    assert "camera.mjpg" in visitor.get("/robots/quadruped").text


LOCK = {"by": "bob", "why": "an emergency stop", "at": "2026-11-22T16:00:05.123+00:00"}


def publish(site: Site, **card: Any) -> None:
    site.api("quadruped").put("/robots/quadruped", json={"card": CARD | card}).raise_for_status()


def test_law_17_a_locked_robot_is_red_and_shows_who_locked_it_when_and_why(site: Site) -> None:
    publish(site, lock=LOCK, state="halted", owner="alice", homed=True)
    bob, root, alice = site.browser("bob"), site.browser("root"), site.browser("alice")
    for path in ("/robots/quadruped", "/robots/quadruped/fragment?part=lock"):
        for visitor, may in ((bob, False), (root, True), (alice, True)):
            page = visitor.get(path).text
            assert 'class="note bad lock"' in page
            assert "Locked by bob since" in page
            assert "22 Nov 2026, 16:00 UTC" in page
            assert "(an emergency stop)." in page
            assert "agentrob release quadruped" in page
            assert ('href="/robots/quadruped/release"' in page) is may
    assert "<strong class=locked>locked</strong>" in bob.get("/robots/quadruped/fragment").text
    for path in ("/", "/robots"):
        page = bob.get(path).text
        assert "Locked by bob since" in page
        assert "is-locked" in page
    assert "(locked)" in bob.get("/b/robots/new").text
    publish(site, lock=None, homed=True)
    for path in ("/robots/quadruped", "/robots/quadruped/fragment?part=lock", "/", "/robots"):
        page = root.get(path).text
        assert "Locked" not in page
        assert "is-locked" not in page
        assert "/release" not in page


def test_law_17_release_needs_a_confirmation_and_shows_its_outcome(site: Site) -> None:
    publish(site, lock=LOCK, homed=True)
    root, bob = site.browser("root"), site.browser("bob")
    assert bob.get("/robots/quadruped/release").status_code == 403
    assert bob.client.post("/robots/quadruped/release", data={"csrf": bob.csrf("/robots/quadruped")}).status_code == 403
    asked = root.get("/robots/quadruped/release").text
    assert "Release @quadruped?" in asked
    assert "Locked by bob since" in asked
    assert root.client.post("/robots/quadruped/release").status_code == 403, "without the form's token"
    page = root.send("/robots/quadruped/release")
    assert page.url.path == "/robots/quadruped"
    assert "It has not answered yet" in page.text  # no agent runs here
    last_action = {
        "action": "release",
        "by": "root",
        "at": datetime.now(UTC).isoformat(),
        "done": True,
        "message": "It was locked.",
    }
    publish(site, lock=None, homed=True, last_action=last_action)
    assert "Released (root, " in bob.get("/robots/quadruped").text
    publish(site, lock=LOCK, last_action=last_action | {"done": False, "message": "I could not."})
    page = bob.get("/robots/quadruped").text
    assert "Not released (root, " in page
    assert "I could not." in page
    publish(site, lock=LOCK, last_action=last_action | {"at": "2026-11-22T16:00:05+00:00"})
    assert "Released (root, " not in bob.get("/robots/quadruped").text, "that was long ago"
    publish(site)


def test_release_is_not_offered_on_a_robot_that_is_not_locked(site: Site) -> None:
    publish(site, lock=None, homed=True)
    root = site.browser("root")
    assert "release" not in root.get("/robots/quadruped").text.lower().replace("until its owner releases it", "")
    page = root.get("/robots/quadruped/release").text
    assert "@quadruped is not locked" in page
    assert "There is nothing to release." in page
    assert "Release @quadruped" not in page
    assert re.findall(r"<button[^>]*>([^<]*)</button>", page.partition("<main")[2].partition("</main")[0]) == [
        "Clear the stop"
    ]
    assert root.send("/robots/quadruped/release").url.path == "/robots/quadruped"


def test_set_home_is_offered_once_and_only_while_the_robot_is_connected(site: Site) -> None:
    root, link = site.browser("root"), 'href="/robots/quadruped/home"'
    for card in ({"homed": True}, {"homed": False}, {"homed": False, "lock": LOCK}, {}):
        publish(site, **card)
        assert root.get("/robots/quadruped").text.count(link) == 1, card
    services = site.board.services
    services.presence.robot("quadruped").seen_at = datetime.now(UTC) - 2 * LIVE_FOR
    assert link not in root.get("/robots/quadruped").text
    publish(site)


def test_law_9_a_robot_without_home_says_so_and_its_owner_sets_it(site: Site) -> None:
    publish(site, homed=False)
    root, bob = site.browser("root"), site.browser("bob")
    for visitor, may in ((bob, False), (root, True)):
        page = visitor.get("/robots/quadruped").text
        assert "It has no home, so it refuses to move." in page
        assert "agentrob home quadruped" in page
        assert ('href="/robots/quadruped/home"' in page) is may
    assert "It has no home, so it refuses to move." in bob.get("/").text
    assert root.get("/robots/quadruped").text.count('href="/robots/quadruped/home"') == 1
    asked = root.get("/robots/quadruped/home").text
    assert "Set the home of @quadruped where it stands?" in asked
    assert '<button class="primary" type="submit">Set home here</button>' in asked
    assert bob.get("/robots/quadruped/home").status_code == 403
    assert root.send("/robots/quadruped/home").url.path == "/robots/quadruped"
    publish(site, homed=True)
    assert "has no home" not in root.get("/robots/quadruped").text


def test_law_17_everybody_signed_in_has_a_separate_emergency_stop_button(site: Site) -> None:
    publish(site)
    before = site.api("quadruped").get("/changes").json()["now"]["id"]
    page = site.browser("bob").send("/robots/quadruped/estop", "/robots/quadruped")
    assert "Emergency stop sent to <strong>@quadruped</strong>" in page.text
    assert "stays locked until its owner releases it" in page.text
    events = site.api("quadruped").get("/changes", params={"after": before}).json()["items"]
    assert [(e["kind"], e["account"]["name"]) for e in events] == [("robot.estop", "bob")]
    assert site.browser().client.post("/robots/quadruped/estop").status_code in (401, 403)


def test_a_card_of_an_earlier_version_has_neither_lock_nor_home(site: Site) -> None:
    publish(site)
    page = site.browser("root").get("/robots/quadruped").text
    assert "Locked" not in page
    assert "has no home" not in page


def test_markup_in_cards_is_shown_as_text(site: Site) -> None:
    nasty = "<img src=x onerror=alert(1)>\"'"
    robot = site.api("quadruped")
    card = {"model": nasty, "state": nasty, "ops": [nasty], "limits": {nasty: nasty}, nasty: [nasty], "board": nasty}
    robot.put("/robots/quadruped", json={"card": card}).raise_for_status()
    visitor = site.browser("bob")
    status = {"robot": "quadruped", "state": nasty[:32], "doing": nasty, "trace_id": nasty}
    topic = robot.post("/topics", json={"board_id": "robots", "title": nasty, "body": "x"}).json()["topic"]["id"]
    other = {"body": nasty, "card": status | {"robot": nasty}}
    assert robot.post(f"/topics/{topic}/posts", json=other).status_code == 403, "no other name, least of all this"
    robot.post(f"/topics/{topic}/posts", json={"body": nasty, "card": status}).raise_for_status()
    for path in ("/", "/b/robots", f"/t/{topic}", "/robots", "/robots/quadruped", "/robots/quadruped/fragment"):
        page = visitor.get(path)
        assert page.status_code == 200
        assert "<img src=x" not in page.text
