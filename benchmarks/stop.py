"""Measure the time from an accepted stop to zero velocity: all processes of the demo, a simulated Go2 over DDS.

    python benchmarks/stop.py [--trials 200] [--condition quiet …] [--json]

In each trial a post makes the robot walk, and a stop is posted within 0.7 s of the first velocity command. Time counts
from when the board accepted the stop, by the board's clock. It ends on DDS, outside the driver: when a second reader of
`rt/api/sport/request` on the robot's domain, in this process, has received StopMove, or Move with zero velocity, and no
other velocity afterwards. This measures the command, not how soon the body rests. The second reader costs the driver
and the machine time, so the figures are too long rather than too short. All processes run on one host; the board's wall
clock is converted to this process's monotonic clock each time. All trials count; a command that does not end as stopped
ends the benchmark.

Conditions:
  quiet    no other load
  flood    another account writes talk into another thread: 50 accepted posts a second; fewer is a miss
  hostile  24 accounts write posts, edits and previews of 32 to 64 KiB that are expensive for a Markdown parser, and
           posts with 1,500 mentions, as fast as the board answers. Stops alternate between post and button, and time
           counts from before the request is sent, since delays occur before the board has accepted the stop
  camera   the command begins with a photo and the walk waits for it; pictures are drawn without GL, so they take long
  disk     while the robot walks, the agent can neither create nor extend files (RLIMIT_FSIZE 0; EFBIG instead of
           ENOSPC: a full disk accepts most writes of the journal, whose write-ahead log is reused). The limit is lifted
           50 ms after the zero, since no command could end otherwise. A stop is written to the journal once, so a stop
           that is missing there in the end could not be written. A last stop shows that others are written
  frozen   no stop is posted: the agent is frozen (SIGSTOP) while the robot walks; counts from the signal
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import itertools
import json
import math
import os
import resource
import signal
import sqlite3
import sys
import tempfile
import threading
import time
from collections.abc import AsyncIterator, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Self
from unittest import mock

import httpx2

from agentrob.board.auth.accounts import new_session
from agentrob.board.db.database import open_engine
from agentrob.demo.run import VISITOR, Demo, DemoSettings
from agentrob.forums.protocol import Forum
from agentrob.model import AccountKind, Post, Role
from agentrob.process.signals import sigterm_interrupts
from agentrob.sim.services.dds import Node  # before any type of the SDK
from agentrob.wiring import app

# isort: split
from unitree_sdk2py.idl.unitree_api.msg.dds_ import Request_, Response_

ROBOT = "quadruped"
CONDITIONS = ("quiet", "flood", "hostile", "camera", "disk", "frozen")
#: Limits of p99: for a stop, and for an agent that is gone (the lease of 1 s, and half a second to notice).
LIMIT_MS = {"frozen": 1500.0}
STOP_LIMIT_MS = 200.0
STOP_MOVE, MOVE, GET_IMAGE = 1003, 1008, 1001
WAIT_S = 30.0
#: Beyond this true position or heading the room is reset before the next trial.
STRAY_M, STRAY_DEG = 0.8, 25.0
FLOOD_PER_S = 50.0
#: The number of concurrent posts, and the share of the wanted rate that must be reached.
FLOOD_WRITERS, FLOOD_SHARE = 8, 0.98
HOSTILE_ACCOUNTS, HOSTILE_WITHIN_S = 24, 60.0
HOSTILE_POSTS = Path(__file__).parent / "instruments" / "hostile_posts.py"
#: How long after the zero the disk stays full, and the share of stops that must fail to be written.
FULL_S, FULL_SHARE = 0.05, 0.95


@dataclass(frozen=True, slots=True)
class Heard:
    """A message on DDS. `what`: go, zero, asked (for a picture), picture; `at_s` by the monotonic clock."""

    at_s: float
    what: str


@cache
def node(domain: int) -> Node:
    """This process's participant: a process can join a domain only once, and the next condition may use the same."""
    return Node(domain, "lo")


class Wire:
    """Records the messages between the driver and the robot on DDS."""

    def __init__(self, domain: int) -> None:
        self.heard: list[Heard] = []
        self._more = threading.Condition()
        observer = node(domain)
        self._readers: tuple[Any, ...] = (
            observer.reader("rt/api/sport/request", Request_, self._sport),
            observer.reader("rt/api/videohub/request", Request_, lambda r: self._video(r, "asked")),
            observer.reader("rt/api/videohub/response", Response_, lambda r: self._video(r, "picture")),
        )

    def close(self) -> None:
        self._readers = ()

    def _sport(self, request: Any) -> None:
        now_s, api = time.monotonic(), request.header.identity.api_id
        if api == STOP_MOVE:
            self._note(now_s, "zero")
        elif api == MOVE:
            velocity = json.loads(request.parameter)
            self._note(now_s, "go" if any(velocity[k] for k in "xyz") else "zero")

    def _video(self, message: Any, what: str) -> None:
        if message.header.identity.api_id == GET_IMAGE:
            self._note(time.monotonic(), what)

    def _note(self, at_s: float, what: str) -> None:
        with self._more:
            self.heard.append(Heard(at_s, what))
            self._more.notify_all()

    async def wait(self, what: str, mark: int, after_s: float = -math.inf, times: int = 1) -> None:
        """Wait for `times` messages `what` after `after_s`, without the first `mark`; `TimeoutError` after `WAIT_S`."""

        def there() -> bool:
            return sum(h.what == what and h.at_s >= after_s for h in self.heard[mark:]) >= times

        def wait() -> bool:
            with self._more:
                return self._more.wait_for(there, WAIT_S)

        if not await asyncio.to_thread(wait):
            raise TimeoutError(f"{what!r} was not received on DDS within {WAIT_S:.0f} s")

    def zero_s(self, mark: int, after_s: float) -> float:
        """The time of the first zero after `after_s` that no other velocity follows."""
        found = math.inf
        for heard in self.heard[mark:]:
            if heard.at_s >= after_s and heard.what == "zero":
                found = min(found, heard.at_s)
            elif heard.what == "go" and heard.at_s > found:
                found = math.inf
        return found


@dataclass(slots=True)
class Row:
    """The result of one condition."""

    condition: str
    limit_ms: float
    found_ms: list[float] = field(default_factory=list)
    note: str = ""
    #: Why the condition did not hold, which makes its times meaningless.
    void: str = ""

    def figures(self) -> dict[str, Any]:
        shares = {"p50_ms": 0.5, "p95_ms": 0.95, "p99_ms": 0.99, "worst_ms": 1.0}
        named = {name: round(percentile(self.found_ms, share), 1) for name, share in shares.items()}
        ok = named["p99_ms"] <= self.limit_ms and not self.void
        row = {"condition": self.condition, "trials": len(self.found_ms), **named, "limit_ms": self.limit_ms, "ok": ok}
        return {**row, "note": self.note, "void": self.void}


def percentile(values: Sequence[float], share: float) -> float:
    """The percentile by nearest rank."""
    return sorted(values)[max(0, math.ceil(share * len(values)) - 1)]


class Scene:
    """A running demo, the DDS messages of its robot, and a person who posts."""

    def __init__(self, demo: Demo, forum: Forum) -> None:
        self.demo, self.forum = demo, forum
        config = app.load(demo.data / "agentrob.toml")
        self.domain = config.robot(ROBOT).domain
        self.url = app.board_settings(config).base_url
        headers = {"Authorization": f"Bearer {demo.tokens[VISITOR]}"}
        self.http = httpx2.AsyncClient(headers=headers, trust_env=False, timeout=WAIT_S)
        self.wire = Wire(self.domain)
        self.worker = next(child for child in demo.children if child.name == "worker").process
        self._posts = 0
        self.late = 0  # stops that took effect after the event that they should have preceded
        self.unwritten = 0  # stops that could not be written to the journal

    @classmethod
    @contextlib.asynccontextmanager
    async def of(cls, demo: Demo) -> AsyncIterator[Self]:
        config = app.load(demo.data / "agentrob.toml")
        forum = app.make_forum(config, demo.tokens[VISITOR])
        scene = cls(demo, forum)
        try:
            yield scene
        finally:
            scene.wire.close()
            await scene.http.aclose()
            await forum.close()

    async def walk(self, first: str = "") -> Post:
        """Post a walk, alternately forward and backward, so that the robot stays in the middle of the room."""
        async with httpx2.AsyncClient(trust_env=False, timeout=10) as http:
            truth = (await http.get(f"{self.demo.room_url}/truth")).json()["robots"]["go2"]
            if math.hypot(truth["x_m"], truth["y_m"]) > STRAY_M or abs(truth["yaw_deg"]) > STRAY_DEG:
                (await http.post(f"{self.demo.room_url}/reset")).raise_for_status()
        self._posts += 1
        way = "forward" if truth["x_m"] < 0 else "backward"
        text = f"@{ROBOT} {first}walk {way} 2 metres"
        return (await self.forum.create_topic("robots", f"Trial {self._posts}", text, key=f"walk-{self._posts}")).post

    async def walking(self, mark: int) -> None:
        """Wait until the robot walks: from the first velocity command to 0.7 s later, varying by trial."""
        await self.wire.wait("go", mark, times=1 + self._posts % 15)

    async def stop(self, command: Post) -> tuple[Post, float]:
        """Post a stop; return it with the time when the board accepted it, by the monotonic clock."""
        post = (await self.forum.reply(command.topic_id, "stop", key=f"stop-{command.id}")).post
        return post, post.created_at.timestamp() - (time.time() - time.monotonic())

    @property
    def posts(self) -> int:
        """The number of commands posted."""
        return self._posts

    async def press(self) -> None:
        """Press the button that stops the robot."""
        (await self.http.post(f"{self.url}/api/v1/robots/{ROBOT}/stop")).raise_for_status()

    async def ended(self, command: Post) -> str:
        """The final state of a command."""
        end_s = time.monotonic() + WAIT_S
        while time.monotonic() < end_s:
            self.demo.check()
            for post in (await self.forum.posts(command.topic_id)).items:
                if post.reply_to == command.id and post.card and post.card.is_final:
                    return str(post.card.state)
            await asyncio.sleep(0.1)
        raise TimeoutError(f"no final answer to post {command.id} within {WAIT_S:.0f} s")

    def kept(self) -> str:
        """The time of the newest stop in the agent's journal, as stored there."""
        path = self.demo.data / "agents" / ROBOT / "journal.sqlite"
        with contextlib.closing(sqlite3.connect(f"file:{path}?mode=ro", uri=True, timeout=10)) as journal:
            row = journal.execute("SELECT value FROM meta WHERE key = 'stopped'").fetchone()
        return row[0] if row else ""


# ---------------------------------------------------------------------- trials
async def stopped(scene: Scene) -> float:
    """One stop by a post while the robot walks; milliseconds."""
    mark = len(scene.wire.heard)
    command = await scene.walk()
    await scene.walking(mark)
    _, accepted_s = await scene.stop(command)
    await scene.wire.wait("zero", mark, accepted_s)
    return await _settled(scene, command, mark, accepted_s)


async def stopped_however(scene: Scene) -> float:
    """One stop by a post or by the button while the robot walks; milliseconds from before the request."""
    mark = len(scene.wire.heard)
    command = await scene.walk()
    await scene.walking(mark)
    asked_s = time.monotonic()
    if scene.posts % 2:
        await scene.stop(command)
    else:
        await scene.press()
    await scene.wire.wait("zero", mark, asked_s)
    return await _settled(scene, command, mark, asked_s)


async def written(scene: Scene) -> bool:
    """Whether a stop is written to the journal under normal conditions."""
    mark = len(scene.wire.heard)
    command = await scene.walk()
    await scene.walking(mark)
    stop, _ = await scene.stop(command)
    await scene.ended(command)
    return scene.kept() >= stop.created_at.isoformat()


async def frozen(scene: Scene) -> float:
    """One agent frozen while its robot walks; milliseconds."""
    mark = len(scene.wire.heard)
    command = await scene.walk()
    await scene.walking(mark)
    asked_s = time.monotonic()
    scene.worker.send_signal(signal.SIGSTOP)
    try:
        await scene.wire.wait("zero", mark, asked_s)
    finally:
        scene.worker.send_signal(signal.SIGCONT)
    return await _settled(scene, command, mark, asked_s)


async def _settled(scene: Scene, command: Post, mark: int, since_s: float) -> float:
    """Wait until the command has ended, so that a velocity after the zero would be received; return milliseconds."""
    state = await scene.ended(command)
    if state not in ("stopped", "interrupted"):
        raise RuntimeError(f"the walk ended as {state} instead of stopped: the trial is invalid")
    return 1000 * (scene.wire.zero_s(mark, since_s) - since_s)


async def waiting_for_camera(scene: Scene) -> float:
    """One stop while the walk waits for a photo; milliseconds. Counts photos that arrive before the zero."""
    mark = len(scene.wire.heard)
    command = await scene.walk("take a photo and ")
    await scene.wire.wait("asked", mark)
    _, accepted_s = await scene.stop(command)
    await scene.wire.wait("zero", mark, accepted_s)
    found_ms = await _settled(scene, command, mark, accepted_s)
    zero_s = accepted_s + found_ms / 1000
    scene.late += any(heard.what == "picture" and heard.at_s < zero_s for heard in scene.wire.heard[mark:])
    return found_ms


async def flood(scene: Scene, over: asyncio.Event) -> tuple[int, float]:
    """Write talk until `over` is set; return the number of accepted posts and the seconds."""
    config = app.load(scene.demo.data / "agentrob.toml")
    app.board_account(config, "chatter", AccountKind.HUMAN, Role.MEMBER)
    forum = app.make_forum(config, app.board_token(config, "chatter"))
    accepted, numbers = 0, itertools.count()

    async def write() -> None:
        nonlocal accepted
        for number in numbers:
            await asyncio.sleep(max(0.0, begun_s + number / FLOOD_PER_S - time.monotonic()))
            if over.is_set():
                return
            written = await forum.reply(topic, f"Number {number} is a nice number", key=f"talk-{number}")
            accepted += written.created

    try:
        topic = (await forum.create_topic("robots", "Talk", "Let us talk", key="talk")).post.topic_id
        begun_s = time.monotonic()
        await asyncio.gather(*(write() for _ in range(FLOOD_WRITERS)))
    finally:
        await forum.close()
    return accepted, time.monotonic() - begun_s


@contextlib.asynccontextmanager
async def hostile(scene: Scene, row: Row) -> AsyncIterator[None]:
    """Let other accounts write hostile posts meanwhile."""
    config = app.load(scene.demo.data / "agentrob.toml")
    settings, accounts = app.board_settings(config), []
    engine = open_engine(settings, writes=True)
    for number in range(HOSTILE_ACCOUNTS):
        account = app.board_account(config, f"hostile{number}", AccountKind.HUMAN, Role.MEMBER)
        with engine.begin() as connection:
            session = new_session(connection, int(account.id))
        accounts.append({"name": account.name, "token": app.board_token(config, account.name), "session": session})
    engine.dispose()
    topic = (await scene.forum.create_topic("robots", "Hostile", "Come all", key="hostile")).post.topic_id
    words = {"url": scene.url, "topic": topic, "cookie": settings.cookie, "accounts": accounts}
    pipes = {"stdin": asyncio.subprocess.PIPE, "stdout": asyncio.subprocess.PIPE}
    writing = await asyncio.create_subprocess_exec(sys.executable, str(HOSTILE_POSTS), **pipes)
    assert writing.stdin is not None
    assert writing.stdout is not None
    begun_s = time.monotonic()
    writing.stdin.write(json.dumps(words).encode() + b"\n")
    await writing.stdin.drain()
    try:
        await asyncio.wait_for(writing.stdout.readline(), HOSTILE_WITHIN_S)  # one of each kind was accepted
        yield
    finally:
        writing.stdin.close()
        answered, _ = await writing.communicate()
    seconds, answers = time.monotonic() - begun_s, json.loads(answered)
    done = dict.fromkeys(("post", "edit", "preview", "names"), 0)
    done |= {what: sum(n for status, n in found.items() if int(status) < 300) for what, found in answers.items()}
    said = ", ".join(f"{done[what]} {what}s" for what in ("post", "edit", "preview"))
    row.note = f"{said} and {done['names']} posts of mentions accepted in {seconds:.0f} s"
    row.void = "" if all(done.values()) else f"hostile posts were not accepted: {answers}"


@contextlib.contextmanager
def full(agent: int) -> Iterator[None]:
    """Make all file writes of the agent fail meanwhile."""
    before = resource.prlimit(agent, resource.RLIMIT_FSIZE)
    resource.prlimit(agent, resource.RLIMIT_FSIZE, (0, before[1]))
    try:
        yield
    finally:
        resource.prlimit(agent, resource.RLIMIT_FSIZE, before)


async def full_disk(scene: Scene) -> float:
    """One stop after writes began to fail; they succeed again shortly after the zero."""
    mark = len(scene.wire.heard)
    command = await scene.walk()
    await scene.walking(mark)
    with full(scene.worker.pid):
        stop, accepted_s = await scene.stop(command)
        await scene.wire.wait("zero", mark, accepted_s)
        await asyncio.sleep(FULL_S)
    found_ms = await _settled(scene, command, mark, accepted_s)
    scene.unwritten += scene.kept() < stop.created_at.isoformat()
    return found_ms


# ---------------------------------------------------------------------- conditions
async def measure(demo: Demo, condition: str, trials: int) -> Row:
    """Run all trials of one condition."""
    row = Row(condition, LIMIT_MS.get(condition, STOP_LIMIT_MS))
    trials_of = {"hostile": stopped_however, "camera": waiting_for_camera, "disk": full_disk, "frozen": frozen}
    trial = trials_of.get(condition, stopped)
    over = asyncio.Event()
    async with Scene.of(demo) as scene:
        flooding = asyncio.create_task(flood(scene, over)) if condition == "flood" else None
        async with hostile(scene, row) if condition == "hostile" else contextlib.nullcontext():
            for _ in range(trials):
                row.found_ms.append(await trial(scene))
        over.set()
        if flooding:
            posts, seconds = await flooding
            row.note = f"{posts} posts accepted in {seconds:.0f} s: {posts / seconds:.1f} posts/s"
            row.void = "too few posts" if posts / seconds < FLOOD_SHARE * FLOOD_PER_S else ""
        if condition == "camera":
            row.note = f"{scene.late} of {trials} after the photo"
        if condition == "disk":
            row.note = f"{scene.unwritten} of {trials} stops could not be written to the journal"
            row.void = (
                "" if scene.unwritten >= FULL_SHARE * trials and await written(scene) else "the journal was written"
            )
    return row


def run(condition: str, trials: int) -> Row:
    """Start a new demo for one condition, measure, and end it."""
    with contextlib.ExitStack() as stack:
        data = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="agentrob-stop-")))
        if condition == "camera":
            stack.enter_context(mock.patch.dict(os.environ, {"MUJOCO_GL": "off"}))
        demo = stack.enter_context(Demo(DemoSettings(data, port=0)))
        demo.start()
        return asyncio.run(measure(demo, condition, trials))


def table(rows: Sequence[Row]) -> str:
    lines = ["| condition | trials | p50 | p95 | p99 | worst | limit | ok |", "|---|---|---|---|---|---|---|---|"]
    for row in rows:
        f = row.figures()
        name = f"{row.condition} ({row.note})" if row.note else row.condition
        times = " | ".join(f"{f[k]:.0f} ms" for k in ("p50_ms", "p95_ms", "p99_ms", "worst_ms", "limit_ms"))
        lines.append(f"| {name} | {f['trials']} | {times} | {'yes' if f['ok'] else 'NO'} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=200, help="trials of each condition (default 200)")
    parser.add_argument("--condition", nargs="+", choices=CONDITIONS, default=CONDITIONS)
    parser.add_argument("--json", action="store_true", help="print JSON with every single time")
    given = parser.parse_args()
    with sigterm_interrupts():
        rows = [run(condition, given.trials) for condition in given.condition]
    if given.json:
        print(json.dumps([{**row.figures(), "found_ms": [round(x, 2) for x in row.found_ms]} for row in rows]))
    else:
        print(table(rows))
    missed = [f"{row.condition} {row.void}".strip() for row in rows if not row.figures()["ok"]]
    raise SystemExit(f"missed: {', '.join(missed)}" if missed else 0)


if __name__ == "__main__":
    main()
