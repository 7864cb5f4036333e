"""The command page and the robot page show the agents' records, whatever these contain."""

from __future__ import annotations

import re
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import text

from agentrob.board.admin.moderation import erase_content
from agentrob.board.db.database import open_engine
from agentrob.board.db.records import StoredPost
from agentrob.board.robots.command_view import command_view
from agentrob.board.robots.commands import CommandRecord
from agentrob.model import Account, AccountKind, Role
from tests.board.web.browser_windows import RUNNING, jpeg
from tests.board.web.forum_site import CARD, Site, running_site

RECORD: dict[str, Any] = {
    "status": "failed",
    "message": "",
    "trace_id": "4f1c22aa",
    "verdict": {"decision": "allow", "rule": "screen.passed", "reason": ""},
    "steps": [
        {
            "op": "move",
            "asked": {"direction": "forward", "distance_m": 2.0},
            "measured": {"distance_m": 0.4, "sideways_m": 0.0},
            "outcome": "failed",
            "reason": "stalled",
            "message": "Asked 2 m, measured 0.4 m.",
            "duration_s": 5.2,
        }
    ],
    "timings_ms": {"seen": 24.0, "first_motion": 140.8},
    "mind": "clever",
    "models": [{"mind": "clever", "model": "gpt-x", "input_tokens": 812, "output_tokens": 40, "latency_ms": 640.2}],
    "looked": {
        "goal": "the ball",
        "turns": [{"tool": "act_move", "arguments": {"distance_m": 2}, "words": "<b>near</b>"}],
    },
    "pictures": [{"kind": "step", "step": 1}, {"kind": "path"}],
}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("board")) as site:
        yield site


def post_command(site: Site) -> tuple[str, str]:
    body = {"board_id": "robots", "title": "Go", "body": "@quadruped walk forward 2 m"}
    made = site.api("alice").post("/topics", json=body).json()
    return made["topic"]["id"], made["post"]["id"]


def report_command(site: Site, topic: str, command: str, pictures: int = 2) -> str:
    robot = site.api("quadruped")
    shown = [
        robot.post("/images", files={"file": ("a.jpg", jpeg(n), "image/jpeg")}).json()["id"] for n in range(pictures)
    ]
    reply = {"body": "Failed.", "reply_to": command, "images": shown, "card": RUNNING | {"state": "failed"}}
    made = robot.post(f"/topics/{topic}/posts", json=reply).json()["post"]["id"]
    robot.put(f"/commands/{command}", json={"reply_id": made, "record": RECORD}).raise_for_status()
    return str(made)


def test_the_command_page_shows_the_decision_and_the_measurements(site: Site) -> None:
    topic, command = post_command(site)
    reply = report_command(site, topic, command)
    page = site.browser("bob").get(f"/c/{command}").text
    for shown in (
        "walk forward 2 m",
        "0.40 m",
        "screen.passed",
        "4f1c22aa",
        "+0.14\u00a0s",
        "Asked 2 m, measured 0.4 m.",
        "812 + 40",
    ):
        assert shown in page, shown
    assert "Photo of step 1" in page
    assert "Path that was measured" in page
    assert "&lt;b&gt;near&lt;/b&gt;" in page
    assert f'href="/p/{reply}"' in page
    assert f'href="/c/{reply}"' in site.browser("bob").get(f"/p/{reply}").text
    assert site.browser("bob").get(f"/c/{reply}").url.path == f"/c/{command}"
    items = site.api("bob").get(f"/commands/{command}").json()["items"]
    assert [(i["robot"], i["reply_id"], i["record"]) for i in items] == [("quadruped", reply, RECORD)]
    assert items[0]["url"] == f"{site.base}/c/{command}"


def test_zero_drift_is_hidden_and_no_amount_is_negative_zero(site: Site) -> None:
    _, command = post_command(site)

    def said(**measured: float) -> str:
        steps = [{**RECORD["steps"][0], "measured": measured}]
        record = RECORD | {"steps": steps, "notes": ["I read `2 metres` as 2 m."]}
        site.api("quadruped").put(f"/commands/{command}", json={"record": record}).raise_for_status()
        page = site.browser("bob").get(f"/c/{command}").text
        assert "I read &#34;2 metres&#34; as 2 m." in page
        found = re.search(r'<th scope="row">1</th><td>[^<]*</td><td>([^<]*)</td>', page)
        assert found
        return found[1]

    assert said(distance_m=1.98, sideways_m=-0.004, heading_deg=0.04, drift_m=0.0049) == "1.98 m"
    strayed = said(distance_m=1.98, sideways_m=-0.006, heading_deg=-0.06, drift_m=0.0129)
    assert strayed == "1.98 m, -0.01 m sideways, -0.1° off, 0.01 m drifted"
    assert said(distance_m=-0.001) == "0.00 m"


def test_a_record_can_be_replaced_only_by_the_robot_that_replied(site: Site) -> None:
    topic, command = post_command(site)
    reply = report_command(site, topic, command)
    robot = site.api("quadruped")
    robot.put(
        f"/commands/{command}", json={"reply_id": reply, "record": RECORD | {"status": "done"}}
    ).raise_for_status()
    items = site.api("bob").get(f"/commands/{command}").json()["items"]
    assert [i["record"]["status"] for i in items] == ["done"]
    answers = [
        site.api("alice").put(f"/commands/{command}", json={"record": RECORD}),
        robot.put(f"/commands/{command}", json={"reply_id": command, "record": RECORD}),
        robot.put("/commands/999999", json={"record": RECORD}),
        robot.put(f"/commands/{command}", json={"record": {"a": "x" * 70_000}}),
        robot.put(f"/commands/{command}", json={"record": {"a": 2**60}}),
        robot.put(f"/commands/{command}", json={"record": RECORD, "robot": "other"}),
    ]
    assert [a.status_code for a in answers] == [403, 403, 404, 413, 422, 422]


def test_stopped_denied_and_approved_by_are_plain_text_without_markdown(site: Site) -> None:
    robot, visitor = site.api("quadruped"), site.browser("bob")
    at = datetime.now(UTC).isoformat()

    def page(**record: object) -> str:
        _, command = post_command(site)
        robot.put(f"/commands/{command}", json={"record": RECORD | record}).raise_for_status()
        return visitor.get(f"/c/{command}").text

    stopped = page(status="stopped", message="carol", stopped_by="carol")
    assert '<dt>Stopped by</dt><dd dir="auto">carol</dd>' in stopped
    assert stopped.count("carol") == 1, "the handle alone is no sentence"
    assert ">Expired. Nobody approved it.<" in page(status="expired", message="**Expired.** Nobody approved it.")
    approved = page(approval={"approved": True, "by": "carol", "at": at})
    assert "</time> approved <" in approved
    assert "<dt>Approved by</dt>" in approved
    assert "</time> denied <" in page(approval={"approved": False, "by": "carol", "at": at})
    for wrong in ("yesterday", "2026-11-22T10:00:00", 7, None, "0001-01-01T00:00:00+00:00"):
        page(approval={"approved": True, "by": "carol", "at": wrong})


def test_the_page_of_a_removed_command_shows_nothing_of_it(site: Site) -> None:
    topic, command = post_command(site)
    report_command(site, topic, command)
    site.api("alice").delete(f"/posts/{command}").raise_for_status()
    page = site.browser("bob").get(f"/c/{command}")
    assert page.status_code == 200
    assert "This post was removed" in page.text
    assert "0.40 m" not in page.text
    assert site.api("bob").get(f"/commands/{command}").json()["items"] == []
    assert site.api("quadruped").put(f"/commands/{command}", json={"record": RECORD}).status_code == 404


@pytest.mark.parametrize("whose", ["who asked", "the robot"])
def test_erasing_an_account_deletes_the_records_of_its_commands(site: Site, whose: str) -> None:
    name = "erased1" if whose == "who asked" else "erased2"
    site.board.add(name, kind=AccountKind.HUMAN if whose == "who asked" else AccountKind.ROBOT_AGENT)
    by = name if whose == "who asked" else "alice"
    robot = "quadruped" if whose == "who asked" else name
    body = {"board_id": "talk", "title": "Go", "body": f"@{robot} walk on"}
    command = site.api(by).post("/topics", json=body).json()["post"]["id"]
    kept = post_command(site)[1]
    record = RECORD | {"message": "axolotl"}
    for post, sent_by in ((command, robot), (kept, "quadruped")):
        site.api(sent_by).put(f"/commands/{post}", json={"record": record}).raise_for_status()
    assert "axolotl" in site.browser("bob").get(f"/c/{command}").text
    site.board.run(erase_content(site.board.services, "root", name))
    assert site.api("bob").get(f"/commands/{command}").json()["items"] == []
    assert "axolotl" not in site.browser("bob").get(f"/c/{command}").text
    assert len(site.api("bob").get(f"/commands/{kept}").json()["items"]) == 1
    engine = open_engine(site.settings, writes=False)
    with engine.connect() as connection:
        left = connection.execute(
            text("SELECT post_id FROM commands WHERE post_id IN (:a, :b)"), {"a": int(command), "b": int(kept)}
        )
        assert left.scalars().all() == [int(kept)]
    engine.dispose()


def test_an_unfinished_command_can_be_stopped_on_its_page(site: Site) -> None:
    topic, command = post_command(site)
    visitor = site.browser("bob")
    for path in (f"/c/{command}", f"/c/{command}?part=views"):
        assert 'action="/robots/quadruped/stop"' in visitor.get(path).text
    report_command(site, topic, command)
    assert "/stop" not in visitor.get(f"/c/{command}").text


def test_a_command_without_a_record_says_so_and_other_posts_are_404(site: Site) -> None:
    _, command = post_command(site)
    visitor = site.browser("bob")
    assert "No robot has recorded this command" in visitor.get(f"/c/{command}").text
    assert [visitor.get(f"/c/{wrong}").status_code for wrong in ("999999", "abc", "4f1c22aa")] == [404] * 3


def test_steps_that_never_started_and_external_recordings_are_shown(site: Site) -> None:
    _, command = post_command(site)
    links = [
        {"kind": "recording", "step": 0, "url": "https://bucket.example/a?b=c", "until": "2026-11-22T00:00:00+00:00"},
        {"kind": "data", "step": 0, "url": "javascript:alert(1)", "until": ""},
    ]
    plan = [{"op": "move", "direction": "forward", "distance_m": 90.0}]
    record = RECORD | {"status": "refused", "steps": [], "plan": plan, "links": links}
    waiting = site.browser("bob").get(f"/c/{command}").text
    assert f'data-refresh="/c/{command}?part=views"' in waiting
    site.api("quadruped").put(f"/commands/{command}", json={"record": record}).raise_for_status()
    page = site.browser("bob").get(f"/c/{command}?part=views").text
    assert "<html" not in page
    assert "walk forward 90 m" in page
    assert "not started" in page
    assert 'href="https://bucket.example/a?b=c"' in page
    assert 'until <time datetime="2026-11-22T00:00:00.000Z"' in page
    assert "javascript:" not in page


def test_camera_pictures_hidden_from_the_reader_are_replaced_by_a_note(site: Site) -> None:
    topic, command = post_command(site)
    reply = report_command(site, topic, command)
    admin_api = site.admin_api()
    paths = (f"/t/{topic}", f"/c/{command}", f"/p/{reply}/fragment")
    try:
        admin_api.patch("/admin/robots/quadruped", json={"camera_role": "operator"}).raise_for_status()
        for path in paths:
            page = site.browser("bob").get(path).text
            assert "are hidden from you by its owner" in page, path
            assert "/images/" not in page, path
            assert "/images/" in site.browser("alice").get(path).text, path
    finally:
        admin_api.patch("/admin/robots/quadruped", json={"camera_role": "guest"}).raise_for_status()


plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=8,
)


@settings(suppress_health_check=list(HealthCheck), max_examples=60)
@given(st.fixed_dictionaries({}, optional=dict.fromkeys(RECORD, plain)), st.sampled_from(["steps", "models", "looked"]))
def test_any_record_can_be_rendered(record: dict[str, Any], wrapped: str) -> None:
    author = Account("1", "alice", AccountKind.HUMAN, Role.OPERATOR)
    post = StoredPost("1", "1", "robots", author, "", "", 1, datetime.now(UTC))
    for one in (record, record | {wrapped: [record]}, record | {"looked": {"turns": [record], "usage": [record]}}):
        assert command_view(post, CommandRecord("quadruped", post.created_at, None, one)).robot == "quadruped"


# -------------------------------------------------------------------- the robot's page
def test_the_robots_page_has_its_owner_queue_and_last_pictures(site: Site) -> None:
    topic, command = post_command(site)
    report_command(site, topic, command)
    robot = site.api("quadruped")
    waiting = post_command(site)[1]
    robot.put("/robots/quadruped", json={"card": CARD | {"line": [waiting, "999999", 7, "x"]}}).raise_for_status()
    page = site.browser("bob").get("/robots/quadruped").text
    queue = page.split('class="queue"')[1].split("</ol>")[0]
    assert queue.count("<li>") == 1
    assert f'href="/p/{waiting}"' in queue
    assert re.search(r'class="thumb" src="/images/\d+/thumb"', page.split("Latest replies")[1])
    assert 'href="/b/robots"' in page
    fragment = site.browser("bob").get("/robots/quadruped/fragment").text
    assert f'href="/p/{waiting}"' in fragment


@pytest.mark.parametrize(
    ("asked", "shown"),
    [
        ({"op": "move", "direction": "forward", "distance_m": 1.0}, "walk forward 1 m"),
        ({"op": "move", "direction": "left", "distance_m": 0.5, "speed_mps": 0.2}, "walk left 0.5 m at 0.2 m/s"),
        ({"op": "turn", "direction": "left", "degrees": 90.0}, "turn left 90°"),
        ({"op": "get_front_image"}, "take a photo"),
        ({"op": "backflip"}, "backflip"),
        ({"op": "move", "distance_m": 1.0}, "walk 1.00 m"),
        ({"op": "move", "direction": "forward", "distance_m": 1e300}, "walk forward, 1"),
        ({"op": "move", "direction": "up", "distance_m": "far"}, "walk up, far"),
        ({"op": "fly_away", "height_m": 2}, "fly away height m 2"),
    ],
)
def test_a_step_is_named_as_in_reports_and_replays(asked: dict[str, Any], shown: str) -> None:
    post = StoredPost("1", "1", "robots", Account("1", "ann"), "", "", 1, datetime.now(UTC))
    (step,) = command_view(post, CommandRecord("quadruped", post.created_at, None, {"plan": [asked]})).steps
    assert step.asked.startswith(shown)
    done = {"op": asked["op"], "asked": {k: v for k, v in asked.items() if k != "op"}}
    (step,) = command_view(post, CommandRecord("quadruped", post.created_at, None, {"steps": [done]})).steps
    assert step.asked.startswith(shown)
