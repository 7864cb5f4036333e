"""A forum with everything on it that a page can show, and the list of all pages: for axe, and for the pictures in docs.

What the robot tells is made by the agent's own report, plot and record.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from pages_world import CARD, World
from sqlalchemy import update

from agentrob.agent import look_words
from agentrob.agent.extract import Thought
from agentrob.agent.pictures import Picture
from agentrob.agent.plot import path_plot
from agentrob.agent.publish import public
from agentrob.agent.records import Records
from agentrob.agent.report import final
from agentrob.board import admin
from agentrob.board import schema as db
from agentrob.minds.loop import Looked, LoopEnd, Turn
from agentrob.minds.screening import Screened
from agentrob.minds.usage import Usage
from agentrob.model import (
    Account,
    ActionResult,
    Command,
    Decision,
    Direction,
    Intent,
    Op,
    Outcome,
    Plan,
    Primitive,
    Report,
    Role,
    Understanding,
    Verdict,
)

IMAGES = Path(__file__).parents[2] / "docs/images"
ROBOT = "quadruped"
CARD_SHOWN = CARD | {
    "ops": ["move", "turn", "hello", "heart", "get_front_image"],
    "limits": {"speed_mps": 0.5, "turn_dps": 45, "step_m": 5, "command_m": 10, "command_s": 60, "command_steps": 10},
    "state": "walking",
    "queue": 1,
}
USAGE = Usage("clever", "vision-large", 1812, 140, 1952, 0.0041, "USD", 1640.0)


@dataclass(frozen=True, slots=True)
class Shown:
    """One page: what it is called, its address with the names of `fill`, and who looks (None: nobody signed in)."""

    name: str
    path: str
    who: str | None = "alice"


PAGES = (
    Shown("home", "/"),
    Shown("board", "/b/robots"),
    Shown("topic", "/t/{topic}"),
    Shown("command", "/c/{walk}"),
    Shown("command-looked", "/c/{look}"),
    Shown("command-none", "/c/{waiting}"),
    Shown("robot", f"/robots/{ROBOT}"),
    Shown("robots", "/robots"),
    Shown("search", "/search?q=walk"),
    Shown("search-empty", "/search"),
    Shown("search-chinese", "/search?q=机器人 前进"),
    Shown("latest", "/latest"),
    Shown("unread", "/unread", "bob"),
    Shown("tags", "/tags"),
    Shown("tag", "/tags/window"),
    Shown("topic-tags", "/t/{topic}/tags"),
    Shown("notices", "/notices"),
    Shown("new-topic", "/b/robots/new?to=quadruped"),
    Shown("quote", "/t/{topic}?quote={said}#reply"),
    Shown("edit", "/p/{walk}/edit"),
    Shown("history", "/p/{said}/history"),
    Shown("remove", "/p/{walk}/remove"),
    Shown("me", "/u/alice"),
    Shown("person", "/u/bob"),
    Shown("password", "/password"),
    Shown("not-found", "/t/999999"),
    Shown("sign-in", "/sign-in", None),
    Shown("sign-up", "/sign-up", None),
    Shown("enter", "{enter}", None),
    Shown("invite", "{invite}", None),
    Shown("set-password", "{password}", None),
    Shown("admin-accounts", "/admin/accounts", "root"),
    Shown("admin-account", "/admin/accounts/bob", "root"),
    Shown("admin-boards", "/admin/boards", "root"),
    Shown("admin-robots", "/admin/robots", "root"),
    Shown("admin-robot", f"/admin/robots/{ROBOT}", "root"),
    Shown("admin-invites", "/admin/invites", "root"),
    Shown("admin-audit", "/admin/audit", "root"),
    Shown("moderate-topic", "/t/{topic}/moderate", "root"),
    Shown("moderate-post", "/p/{said}/moderate", "root"),
)


def fill(world: World) -> dict[str, str]:
    """Let people and the robot write; the names in the addresses of `PAGES`."""
    alice, bob, robot = (world.api(name) for name in ("alice", "bob", ROBOT))
    robot.put(f"/robots/{ROBOT}", json={"card": CARD_SHOWN}).raise_for_status()
    begin = alice.post(
        "/topics", json={"board": "talk", "title": "机器人记录", "body": "机器人前进了两米。", "tags": ["记录"]}
    )
    begin.raise_for_status()
    text = f"@{ROBOT} walk forward 2 metres, turn left and take a photo"
    topic = {"board": "robots", "title": "A walk to the window", "body": text, "tags": ["window", "photo", "窗户"]}
    made = alice.post("/topics", json=topic).json()
    topic, walk = made["topic"]["id"], made["post"]["id"]
    earlier(world, walk, 8.0)
    _tell(world, topic, walk, _walk(walk, topic))
    said = _says(
        world, "bob", topic, f"> walk forward 2 metres\n\n@alice that was **quick**. Next: `@{ROBOT} wave`?", walk
    )
    bob.patch(
        f"/posts/{said}", json={"body": f"> walk forward 2 metres\n\n@alice that was quick. Next: `@{ROBOT} wave`?"}
    )
    look = _says(world, "alice", topic, f"@{ROBOT} go and look for the red ball")
    earlier(world, look, 5.0)
    _tell(world, topic, look, _look(look, topic), _looked())
    waiting = _says(
        world, "alice", topic, f"@{ROBOT} turn right by 90 degrees\n\n| lap | time |\n|---|--:|\n| 1 | 12 s |"
    )
    ahead = _says(world, "alice", topic, f"@{ROBOT} wave")
    card = {"robot": ROBOT, "state": "running", "step": 1, "steps": 2, "doing": "turn right 90°", "trace_id": "5e01aa"}
    robot.post(f"/topics/{topic}/posts", json={"body": "Step 1 of 2.", "reply_to": waiting, "card": card})
    names = {"topic": topic, "walk": walk, "said": said, "look": look, "waiting": waiting, "next": ahead}
    alive(world, names)
    return names | links(world)


def alive(world: World, names: Mapping[str, str]) -> None:
    """The robot's agent tells what it does, and what its room's camera sees."""
    robot, jpeg = world.api(ROBOT), (IMAGES / "world-room.jpg").read_bytes()
    card = CARD_SHOWN | {"line": [names["waiting"], names["next"]]}
    robot.put(f"/robots/{ROBOT}", json={"card": card}).raise_for_status()
    robot.put(f"/robots/{ROBOT}/frame", content=jpeg, headers={"Content-Type": "image/jpeg"}).raise_for_status()


def earlier(world: World, post: str, seconds: float) -> None:
    """As if it had been written so long ago."""
    with admin.writing(world.settings) as connection:
        mine, at = db.posts.c.id == int(post), db.posts.c.created_us
        connection.execute(update(db.posts).where(mine).values(created_us=at - int(seconds * 1e6)))


def links(world: World) -> dict[str, str]:
    """Links of admins to people."""
    chief = world.chief()
    chief.patch(f"/admin/robots/{ROBOT}", json={"owner": "alice"}).raise_for_status()
    invite = chief.post("/admin/invites", json={"role": "member", "uses": 3, "days": 7}).json()["url"]
    password = chief.post("/admin/accounts/bob/link", json={"purpose": "password"}).json()["url"]
    return {"enter": world.link("bob"), "invite": _path(world, invite), "password": _path(world, password)}


def _path(world: World, url: str) -> str:
    return url.removeprefix(world.base)


def _says(world: World, who: str, topic: str, body: str, reply_to: str | None = None) -> str:
    answer = world.api(who).post(f"/topics/{topic}/posts", json={"body": body, "reply_to": reply_to})
    answer.raise_for_status()
    return str(answer.json()["post"]["id"])


# -------------------------------------------------------------------- what the robot did
def _command(post: str, topic: str, trace: str) -> Command:
    alice = Account("2", "alice", role=Role.OPERATOR)
    return Command(post, topic, "h", alice, ROBOT, "…", "en", datetime.now(UTC), trace)


def _walk(post: str, topic: str) -> Report:
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
    return Report(_command(post, topic, "4f1c22aa"), "done", verdict, plan, results, timings_ms=timings)


def _look(post: str, topic: str) -> Report:
    turn, move = Primitive(Op.TURN, Direction.LEFT, degrees=45.0), Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0)
    photo = Primitive(Op.GET_FRONT_IMAGE)
    results = (
        ActionResult(photo, Outcome.DONE, image=(IMAGES / "world-obstacles.jpg").read_bytes()),
        ActionResult(turn, Outcome.DONE, {"degrees": 44.1}, "", "", 1.0, 2.3),
        ActionResult(move, Outcome.FAILED, {"distance_m": 0.41}, "obstacle", "Something is 0.5 m ahead.", 3.0, 5.2),
    )
    report = Report(
        _command(post, topic, "9ab3c7d1"), "failed", Verdict(Decision.ALLOW, "screen.goal"), results=results
    )
    timings = {"seen": 40.0, "first_motion": 2210.0}
    return Report(**_fields(report) | {"goal": "the red ball", "timings_ms": timings, "message": "It was not reached."})


def _looked() -> Looked:
    left, ahead = {"direction": "left", "degrees": 45}, {"direction": "forward", "distance_m": 1}
    turns = (
        Turn("get_front_image", {}, outcome="done", step=1, latency_ms=1640.0),
        Turn("act_turn", left, outcome="done", step=2, words="It is on the left.", latency_ms=910.0),
        Turn("act_move", ahead | {"distance_m": 9}, problem="at most 5 m a step", latency_ms=870.0),
        Turn("act_move", ahead, outcome="failed", step=3, latency_ms=905.0),
    )
    end = LoopEnd("finished", "not_possible", ("a red ball behind a box",), "turned to it")
    return Looked("the red ball", end, turns, (USAGE, USAGE), "clever")


def _fields(report: Report) -> dict[str, Any]:
    return {name: getattr(report, name) for name in Report.__slots__}


def _tell(world: World, topic: str, command: str, report: Report, looked: Looked | None = None) -> None:
    """Say it in the thread as the agent does, and send its record."""
    robot = world.api(ROBOT)
    page = robot.get(f"/commands/{command}").json()["url"]
    pictures = [Picture("step", r.image, n) for n, r in enumerate(report.results, 1) if r.image]
    if plot := path_plot(report.results):
        pictures.append(Picture("path", plot))
        pictures.append(Picture("recording", (IMAGES / "recording-room.webp").read_bytes()))
    images = [_upload(robot, picture) for picture in pictures]
    notes = look_words.paragraphs(looked, report.results, "en")
    steps = len(report.results)
    card = {"robot": ROBOT, "state": report.status, "step": steps, "steps": steps, "trace_id": report.command.trace_id}
    told = {"body": final(report, pictures, notes, page=page), "reply_to": command, "images": images, "card": card}
    reply = robot.post(f"/topics/{topic}/posts", json=told).json()["post"]["id"]
    understood = Understanding(Intent.COMMAND, plan=report.plan)
    thought = Thought(understood, "clever", report.verdict, (USAGE,), screened=Screened("careful", usage=(USAGE,)))
    more: Mapping[str, Any] = {"looked": asdict(looked)} if looked else {}
    with TemporaryDirectory() as folder:
        facts = Records(Path(folder)).write(report, thought, **more)
    robot.put(f"/commands/{command}", json={"reply": reply, "record": public(facts, pictures)}).raise_for_status()


def _upload(robot: Any, picture: Picture) -> str:
    answer = robot.post("/images", files={"file": ("picture", picture.data, "application/octet-stream")})
    answer.raise_for_status()
    return str(answer.json()["id"])
