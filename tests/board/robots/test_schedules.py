"""Schedules of robots on the board: their pages, the calendar, the API, the button that cancels, and pages of runs."""

from __future__ import annotations

import gzip
import json
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime, timedelta
from typing import Any
from zoneinfo import ZoneInfo

import pytest
from hypothesis import given
from hypothesis import strategies as st
from icalendar import Calendar

from agentrob.board.robots.schedules import schedule_view
from agentrob.model import Role
from tests.board.web.forum_site import CARD, Site, running_site

BERLIN = ZoneInfo("Europe/Berlin")
RUNNING = {"robot": "quadruped", "state": "done", "step": 1, "steps": 1, "trace_id": "5e01aa"}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("board")) as site:
        site.board.add("carol", role=Role.OPERATOR, password="correct horse battery")
        site.board.add("mona", role=Role.MODERATOR, password="correct horse battery")
        admin = site.admin_api()
        admin.patch("/admin/robots/quadruped", json={"owner": "carol"}).raise_for_status()
        vault = {"id": "vault", "name": "Vault", "read_role": "operator", "post_role": "operator"}
        admin.post("/admin/boards", json=vault).raise_for_status()
        yield site


def asked(
    site: Site, text: str = "every weekday at 9:00 take a photo", who: str = "alice", board: str = "robots"
) -> str:
    made = site.api(who).post("/topics", json={"board_id": board, "title": "Later", "body": f"@quadruped {text}"})
    made.raise_for_status()
    return str(made.json()["post"]["id"])


def at(days: int, hour: int = 9, zone: ZoneInfo = BERLIN) -> datetime:
    there = datetime.now(zone).replace(hour=hour, minute=0, second=0, microsecond=0)
    return there + timedelta(days=days)


def entry(post: str, *runs: datetime, **more: Any) -> dict[str, Any]:
    seconds = [int(run.timestamp()) for run in runs or (at(1), at(2), at(3), at(4))]
    until = at(60).isoformat()
    told = {"post": post, "text": "take a photo", "zone": "Europe/Berlin", "runs": seconds, "until": until}
    return told | {"renewable": True} | more


def publish(site: Site, *entries: Mapping[str, Any]) -> None:
    card = CARD | {"schedules": list(entries), "schedules_more": 0}
    site.api("quadruped").put("/robots/quadruped", json={"card": card}).raise_for_status()


def replies(site: Site, post: str) -> list[dict[str, Any]]:
    topic = site.api("alice").get(f"/posts/{post}").json()["topic_id"]
    items = site.api("alice").get(f"/topics/{topic}/posts").json()["items"]
    return [item for item in items if item["reply_to"] == post]


# -------------------------------------------------------------------- pages
@pytest.mark.parametrize("path", ["/schedules", "/schedules?part=list", "/robots/quadruped/schedules"])
def test_the_page_names_robot_author_command_next_three_runs_and_end(site: Site, path: str) -> None:
    post = asked(site)
    publish(site, entry(post))
    page = site.browser("bob").get(path).text
    assert f'href="/p/{post}"' in page
    for words in ("take a photo", "@quadruped", "asked by alice", "times in Europe/Berlin", "4 runs left"):
        assert words in page, words
    for day in (1, 2, 3):
        assert f"{at(day):%a %Y-%m-%d} 09:00" in page
    assert f"{at(4):%Y-%m-%d} 09:00" not in page
    assert f"the last on {at(4):%a %Y-%m-%d}; its author can renew it" in page
    assert "in 1 day" in page or "in 2 days" in page or "hours" in page


def test_the_robots_page_links_its_schedules_and_its_card_has_them_not_as_facts(site: Site) -> None:
    publish(site, entry(asked(site)))
    page = site.browser("bob").get("/robots/quadruped").text
    assert 'href="/robots/quadruped/schedules">1 schedule</a>' in page
    assert "Schedules more" not in page
    assert "schedules" not in site.api("bob").get("/robots/quadruped").json()["card"]
    assert 'href="/robots/quadruped/schedules.ics"' in site.browser("bob").get("/robots/quadruped/schedules").text
    publish(site)
    assert "/robots/quadruped/schedules" not in site.browser("bob").get("/robots/quadruped").text
    assert "There are no schedules that you may see" in site.browser("bob").get("/schedules").text


def test_schedules_of_posts_that_a_viewer_may_not_read_are_not_shown(site: Site) -> None:
    secret = asked(site, board="vault")
    gone = asked(site)
    publish(site, entry(secret, text="patrol the vault"), entry(gone, text="wave goodbye"))
    site.api("alice").delete(f"/posts/{gone}").raise_for_status()
    for who, sees in (("alice", True), ("bob", False)):
        shown = [site.browser(who).get(path).text for path in ("/schedules", "/robots/quadruped/schedules.ics")]
        shown.append(json.dumps(site.api(who).get("/robots/quadruped/schedules").json()))
        shown.append(site.browser(who).get("/robots/quadruped").text)
        assert ["patrol the vault" in text for text in shown] == [sees] * 4
        assert not any("wave goodbye" in text for text in shown)
    for path in ("/schedules", "/robots/quadruped/schedules", "/robots/quadruped/schedules.ics"):
        assert "patrol" not in site.browser().get(path).text


def test_an_unknown_robot_has_no_schedules(site: Site) -> None:
    for path in ("/robots/nobody/schedules", "/robots/nobody/schedules.ics"):
        assert site.browser("bob").get(path).status_code == 404
    assert site.api("bob").get("/robots/nobody/schedules").status_code == 404


def test_names_in_a_card_are_escaped(site: Site) -> None:
    publish(site, entry(asked(site), text="<script>alert(1)</script>", zone="<b>Mars</b>"))
    page = site.browser("bob").get("/schedules").text
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert(1)" in page
    assert "times in UTC" in page


_json = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=10), inner, max_size=4),
    max_leaves=12,
)
_fields = st.sampled_from(["post", "text", "zone", "runs", "until", "renewable"])


@given(st.dictionaries(_fields, _json, max_size=6))
def test_any_entry_of_a_card_can_be_rendered(told: dict[str, Any]) -> None:
    view = schedule_view(told, None, "quadruped", True, False)  # type: ignore[arg-type]
    assert isinstance(view.text, str)
    assert isinstance(view.last, str)
    assert all(isinstance(part, str) for run in view.next_runs for part in run)


@pytest.mark.parametrize("told", [None, "x", 5, {"a": 1}, [None, "x", {}], [{"post": "1" * 400}], [{"post": "-1"}]])
def test_a_malformed_list_of_schedules_is_not_an_error(site: Site, told: Any) -> None:
    site.api("quadruped").put("/robots/quadruped", json={"card": CARD | {"schedules": told}}).raise_for_status()
    for path in ("/schedules", "/robots/quadruped", "/robots/quadruped/schedules.ics"):
        assert site.browser("bob").get(path).status_code == 200


# -------------------------------------------------------------------- calendar and API
def test_the_calendar_has_each_run_at_its_moment_also_across_a_change_of_clocks(site: Site) -> None:
    post = asked(site)
    days = [
        datetime.now(BERLIN).replace(hour=9, minute=0, second=0, microsecond=0) + timedelta(days=n)
        for n in range(1, 300, 13)
    ]
    publish(site, entry(post, *days))
    answer = site.browser("bob").get("/robots/quadruped/schedules.ics")
    assert answer.headers["content-type"] == "text/calendar; charset=utf-8"
    assert all(len(line) <= 75 for line in answer.content.split(b"\r\n"))
    calendar = Calendar.from_ical(answer.content)
    events = calendar.walk("VEVENT")
    assert [event["dtstart"].dt for event in events] == [day.astimezone(UTC) for day in days]
    assert {day.utcoffset() for day in days} == {timedelta(hours=1), timedelta(hours=2)}
    assert len({str(event["uid"]) for event in events}) == len(days)
    assert str(events[0]["summary"]) == "@quadruped: take a photo"
    assert f"{days[0]:%a %Y-%m-%d} 09:00 (Europe/Berlin). Asked by alice." in str(events[0]["description"])
    assert str(events[0]["url"]).endswith(f"/p/{post}")


def test_text_in_the_calendar_cannot_add_lines(site: Site) -> None:
    publish(site, entry(asked(site), text="wave; \\, now\r\nEND:VCALENDAR\nX-EVIL:1 照" + "相" * 60))
    text = site.browser("bob").get("/robots/quadruped/schedules.ics").content
    assert text.count(b"END:VCALENDAR") == text.count(b"\r\nEND:VCALENDAR\r\n") + text.count(b"\\nEND:VCALENDAR")
    assert b"\r\nX-EVIL" not in text
    (summary,) = {str(event["summary"]) for event in Calendar.from_ical(text).walk("VEVENT")}
    assert summary.startswith("@quadruped: wave; \\, now")
    assert summary.endswith("相" * 60)


def test_the_api_lists_schedules(site: Site) -> None:
    post = asked(site)
    publish(site, entry(post))
    (item,) = site.api("bob").get("/robots/quadruped/schedules").json()["items"]
    runs = item.pop("runs")
    assert [datetime.fromisoformat(run) for run in runs] == [at(day) for day in (1, 2, 3, 4)]
    assert item.pop("until") is not None
    assert item == {
        "post_id": post, "url": f"{site.base}/p/{post}", "author": "alice", "text": "take a photo",
        "time_zone": "Europe/Berlin", "renewable": True,
    }  # fmt: skip


# -------------------------------------------------------------------- cancel
@pytest.mark.parametrize(
    ("who", "may"), [("alice", True), ("carol", True), ("mona", True), ("root", True), ("bob", False), (None, False)]
)
def test_author_owner_and_moderators_have_a_button_that_cancels(site: Site, who: str | None, may: bool) -> None:
    post = asked(site)
    publish(site, entry(post))
    browser = site.browser(who)
    action = f"/schedules/{post}/cancel"
    assert (action in browser.get("/schedules").text) is may
    if may:
        page = browser.send(action, page="/robots/quadruped/schedules")
        assert "You cancelled a schedule" in page.text
        (said,) = replies(site, post)
        assert (said["raw"], said["author"]["name"]) == ("@quadruped cancel the schedule", who)
    elif who is not None:
        fields = {"robot": "quadruped", "key": "k", "csrf": browser.csrf("/robots/quadruped")}
        assert browser.client.post(action, data=fields).status_code == 403
        assert replies(site, post) == []


def test_the_button_writes_in_the_language_of_the_post_and_once(site: Site) -> None:
    post = asked(site, "每个工作日九点拍照")
    publish(site, entry(post))
    alice = site.browser("alice")
    text = alice.get("/schedules").text
    fields = {"robot": "quadruped", "key": "twice", "csrf": alice.csrf("/schedules")}
    assert post in text
    for _ in range(2):
        alice.client.post(f"/schedules/{post}/cancel", data=fields)
    assert [said["raw"] for said in replies(site, post)] == ["@quadruped 取消日程"]


def test_a_post_without_a_schedule_is_not_cancelled(site: Site) -> None:
    post = asked(site)
    publish(site)
    alice = site.browser("alice")
    fields = {"robot": "quadruped", "key": "k", "csrf": alice.csrf("/robots/quadruped")}
    assert alice.client.post(f"/schedules/{post}/cancel", data=fields).status_code == 409
    assert alice.client.post(f"/schedules/{post}/cancel", data=fields | {"csrf": "x"}).status_code == 403
    assert replies(site, post) == []


# -------------------------------------------------------------------- pages of runs
def run_of(site: Site, post: str) -> str:
    """Send the report, record and replay of a run, as an agent does; return the id of the report's post."""
    robot = site.api("quadruped")
    topic = robot.get(f"/posts/{post}").json()["topic_id"]
    made = robot.post(f"/topics/{topic}/posts", json={"body": "Done.", "reply_to": post, "card": RUNNING}).json()
    report = str(made["post"]["id"])
    due = (datetime.now(UTC) - timedelta(seconds=2)).isoformat()
    record = {
        "robot": "quadruped", "status": "done", "trace_id": "5e01aa", "timings_ms": {"seen": 400.0},
        "run": {"at": due, "zone": "Europe/Berlin", "number": 2, "of": 3, "limited": False},
    }  # fmt: skip
    robot.put(f"/commands/{report}", json={"reply_id": report, "record": record}).raise_for_status()
    replay = gzip.compress(json.dumps({"t": [0], "pose": [[0], [0], [0]]}).encode())
    robot.put(f"/commands/{report}/replay", content=replay).raise_for_status()
    return report


def test_each_run_has_a_page_of_its_own_with_its_schedule(site: Site) -> None:
    post = asked(site)
    runs = [run_of(site, post) for _ in range(2)]
    bob = site.browser("bob")
    for report in runs:
        page = bob.get(f"/c/{report}")
        assert page.url.path == f"/c/{report}", "the page of a run is not that of its schedule"
        for words in ("A run of the schedule that", f'href="/p/{post}"', "take a photo", "2 of 3", "due", "+0.40"):
            assert words in page.text, words
        assert f'href="/c/{report}"' in bob.get(f"/p/{report}").text
        assert site.api("bob").get(f"/commands/{report}/replay?robot=quadruped").status_code == 200


def test_the_runs_of_a_removed_schedule_show_nothing(site: Site) -> None:
    post = asked(site)
    report = run_of(site, post)
    site.api("alice").delete(f"/posts/{post}").raise_for_status()
    page = site.browser("bob").get(f"/c/{report}").text
    assert "5e01aa" not in page
    assert "take a photo" not in page
    assert site.api("bob").get(f"/commands/{report}").json()["items"] == []
    assert site.api("bob").get(f"/commands/{report}/replay?robot=quadruped").status_code == 404
