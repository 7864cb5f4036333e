"""Sample reports and records of commands for the forum's pages, written by the agent's own reporting code."""

from __future__ import annotations

import math
from dataclasses import asdict
from datetime import UTC, datetime, timedelta
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from agentrob.agent.media.pictures import Picture
from agentrob.agent.media.plot import path_plot
from agentrob.agent.media.replay import PoseLog, PoseSample, encoded
from agentrob.agent.media.room_map import RoomMap
from agentrob.agent.reporting import report as words
from agentrob.agent.reporting import visual_text
from agentrob.agent.reporting.command_page import public
from agentrob.agent.store.records import Records
from agentrob.agent.understanding.extract import Assessment
from agentrob.config.map import MapConfig
from agentrob.config.robots import RobotConfig
from agentrob.language.messages.catalog import say
from agentrob.minds.safety_review import SafetyReview
from agentrob.minds.usage import Usage
from agentrob.minds.visual_loop.loop import LoopCall, LoopEnd, LoopRecord
from agentrob.model import (
    Account,
    ActionResult,
    Command,
    CommandState,
    Decision,
    Direction,
    Intent,
    Op,
    Outcome,
    Plan,
    Pose,
    Posture,
    Primitive,
    Report,
    Role,
    StopResult,
    Understanding,
    Verdict,
)
from tests.board.web.forum_site import Site

IMAGES = Path(__file__).parents[3] / "docs/images"
ROBOT = "quadruped"
USAGE = Usage("clever", "vision-large", 1812, 140, 1952, 0.0041, "USD", 1640.0)
FLIP = Plan((Primitive(Op.BACKFLIP),))


def command(post: str, topic: str, trace: str) -> Command:
    alice = Account("2", "alice", role=Role.OPERATOR)
    return Command(post, topic, "h", alice, ROBOT, "…", "en", datetime.now(UTC), trace)


def walk(post: str, topic: str) -> Report:
    steps = (
        Primitive(Op.MOVE, Direction.FORWARD, distance_m=2.0),
        Primitive(Op.TURN, Direction.LEFT, degrees=90.0),
        Primitive(Op.GET_FRONT_IMAGE),
    )
    straight = tuple((0.1 * n, 0.049 * n, 0.02 * math.sin(n / 6), 0.0) for n in range(41))
    results = (
        ActionResult(steps[0], Outcome.DONE, {"distance_m": 1.98, "sideways_m": 0.02}, "", "", 0.0, 4.6, straight),
        ActionResult(steps[1], Outcome.DONE, {"degrees": 89.2}, "", "", 4.6, 7.1),
        ActionResult(steps[2], Outcome.DONE, {}, "", "", 7.1, 7.4, image=(IMAGES / "world-room.jpg").read_bytes()),
    )
    plan = Plan(steps, ("`turn left` had no angle: taken as 90°.",))
    timings = {"seen": 31.0, "first_motion": 148.0, "done": 7420.0}
    verdict = Verdict(Decision.ALLOW, "screen.passed")
    return Report(command(post, topic, "4f1c22aa"), CommandState.DONE, verdict, plan, results, timings_ms=timings)


def look(post: str, topic: str) -> Report:
    turn, move = Primitive(Op.TURN, Direction.LEFT, degrees=45.0), Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0)
    photo = Primitive(Op.GET_FRONT_IMAGE)
    results = (
        ActionResult(photo, Outcome.DONE, image=(IMAGES / "world-obstacles.jpg").read_bytes()),
        ActionResult(turn, Outcome.DONE, {"degrees": 44.1}, "", "", 1.0, 2.3),
        ActionResult(move, Outcome.FAILED, {"distance_m": 0.41}, "obstacle", "Something is 0.5 m ahead.", 3.0, 5.2),
    )
    report = Report(
        command(post, topic, "9ab3c7d1"), CommandState.FAILED, Verdict(Decision.ALLOW, "screen.goal"), results=results
    )
    timings = {"seen": 40.0, "first_motion": 2210.0}
    return Report(**fields(report) | {"goal": "the red ball", "timings_ms": timings, "message": "It was not reached."})


def loop_record() -> LoopRecord:
    left, ahead = {"direction": "left", "degrees": 45}, {"direction": "forward", "distance_m": 1}
    turns = (
        LoopCall("get_front_image", {}, outcome="done", step=1, latency_ms=1640.0),
        LoopCall("act_turn", left, outcome="done", step=2, words="It is on the left.", latency_ms=910.0),
        LoopCall("act_move", ahead | {"distance_m": 9}, problem="at most 5 m a step", latency_ms=870.0),
        LoopCall("act_move", ahead, outcome="failed", step=3, latency_ms=905.0),
    )
    end = LoopEnd("finished", "not_possible", ("a red ball behind a box",), "turned to it")
    return LoopRecord("the red ball", end, turns, (USAGE, USAGE), "clever")


def fields(report: Report) -> dict[str, Any]:
    return {name: getattr(report, name) for name in Report.__slots__}


def replay_of(report: Report) -> bytes:
    """The replay of a report, from its own path."""
    room = RoomMap(ROBOT, RobotConfig(map=MapConfig(room="lab", size_m=(8, 6))))
    start = Pose(*report.results[0].path[0][1:])
    log = PoseLog(plan=room.planned(start, [r.primitive for r in report.results]))
    for result in report.results:
        for at_s, *where in result.path:
            log.add(PoseSample(result.started_s + at_s, Pose(*where), Posture(0.0)))
    return encoded(log, robot=ROBOT, map=room.as_data(), geometry="")


def send_report(
    site: Site, topic: str, command: str, report: Report, loop: LoopRecord | None = None, **more: Any
) -> str:
    """Post a report in the thread and send its record, as the agent does; return the id of the report's post."""
    robot = site.api(ROBOT)
    page = robot.get(f"/commands/{command}").json()["url"]
    pictures = [Picture("step", r.image, n) for n, r in enumerate(report.results, 1) if r.image]
    if plot := path_plot(report.results):
        pictures.append(Picture("path", plot))
        pictures.append(Picture("recording", (IMAGES / "recording-room.webp").read_bytes()))
    images = [upload(robot, picture) for picture in pictures]
    notes = visual_text.paragraphs(loop, report.results, "en")
    steps = len(report.results)
    card = {"robot": ROBOT, "state": report.status, "step": steps, "steps": steps, "trace_id": report.command.trace_id}
    told = {
        "body": words.final(report, pictures, notes, page=page),
        "reply_to": command,
        "images": images,
        "card": card,
    }
    reply = str(robot.post(f"/topics/{topic}/posts", json=told).json()["post"]["id"])
    paged = command if report.command.run is None else reply
    if report.results and report.results[0].path:
        robot.put(f"/commands/{paged}/replay", content=replay_of(report)).raise_for_status()
    understood = Understanding(Intent.COMMAND, plan=report.plan)
    thought = Assessment(
        understood, "clever", report.verdict, (USAGE,), screened=SafetyReview("careful", usage=(USAGE,))
    )
    more |= {"looked": asdict(loop)} if loop else {}
    with TemporaryDirectory() as folder:
        facts = Records(Path(folder)).write(report, thought, **more)
    robot.put(f"/commands/{paged}", json={"reply_id": reply, "record": public(facts, pictures)}).raise_for_status()
    return reply


def upload(robot: Any, picture: Picture) -> str:
    answer = robot.post("/images", files={"file": ("picture", picture.data, "application/octet-stream")})
    answer.raise_for_status()
    return str(answer.json()["id"])


# -------------------------------------------------------------------- one report for each final state
def ask_for_approval(site: Site, topic: str, post: str) -> None:
    """Post the status in which the robot asks for an approval."""
    until = datetime.now(UTC) + timedelta(minutes=10)
    text = words.waits("a backflip", "A risky move needs an approval.", None, ROBOT, 600.0, "en")
    card = {"robot": ROBOT, "state": "waiting", "trace_id": "77aa01c4", "until": until.isoformat()}
    told = {"body": text, "reply_to": post, "card": card}
    key = {"Idempotency-Key": f"claim:{post}"}
    site.api(ROBOT).post(f"/topics/{topic}/posts", json=told, headers=key).raise_for_status()


def approval_record(yes: bool, post: str) -> dict[str, Any]:
    """Return the fields of a record about its approval."""
    at = datetime.now(UTC) - timedelta(seconds=5)
    by = {"by": "root", "role": "admin", "post": post, "at": at.isoformat()}
    return {"approval": {"until": (at + timedelta(minutes=9)).isoformat(), "approved": yes} | by}


def approved(post: str, topic: str) -> Report:
    flipped = ActionResult(FLIP.steps[0], Outcome.DONE, {}, "", "", 0.0, 3.4)
    verdict, timings = (
        Verdict(Decision.ALLOW, "screen.passed"),
        {"seen": 31.0, "first_motion": 40_200.0, "done": 43_600.0},
    )
    done = {"timings_ms": timings, "approved_by": "root"}
    return Report(command(post, topic, "1c00be51"), CommandState.DONE, verdict, FLIP, (flipped,), **done)  # type: ignore[arg-type]


def denied(post: str, topic: str) -> Report:
    verdict = Verdict(Decision.REFUSE, "approval.denied", say("agent.denied.by", "en", who="root"))
    return Report(command(post, topic, "2d11cf62"), CommandState.REFUSED, verdict, FLIP, timings_ms={"seen": 28.0})


def expired(post: str, topic: str) -> Report:
    verdict = Verdict(Decision.NEEDS_APPROVAL, "rights.approval", "A risky move needs an approval.")
    said = say("agent.lapsed", "en", seconds=120, wait="10 minutes")
    return Report(
        command(post, topic, "3e22d073"), CommandState.EXPIRED, verdict, FLIP, message=said, timings_ms={"seen": 30.0}
    )


def stopped(post: str, topic: str) -> Report:
    walk = Primitive(Op.MOVE, Direction.FORWARD, distance_m=3.0)
    result = ActionResult(walk, Outcome.STOPPED, {"distance_m": 1.12}, "stop", "Stopped by bob.", 0.0, 2.6)
    stop = StopResult(18.0, confirmed=True, was_moving=True, coasted_m=0.06)
    more: dict[str, Any] = {"message": "bob", "stop": stop, "timings_ms": {"seen": 30.0, "first_motion": 120.0}}
    verdict = Verdict(Decision.ALLOW, "screen.passed")
    return Report(command(post, topic, "4f33e184"), CommandState.STOPPED, verdict, Plan((walk,)), (result,), **more)
