"""Kill workers at random while people command a fleet: nothing is lost, nothing moves twice, every command is answered.

    python benchmarks/fleet.py --full      # 200 robots, 4 workers, 10,000 commands, PostgreSQL, 60 and 5 kills

A real board, real workers and, with `--postgres`, a real PostgreSQL for board and journals; without it these are
SQLite files. Fake robots behind real drivers write each step to a ledger, outside of what is killed. Fifty drivers
share a process, each with its own socket, leases, guard and lock (`benchmarks/instruments/robot_host.py`). A killed
worker starts again when others have taken over all its robots. The kills are spread over the commands. Every half
minute a line says how far it is; after `--minutes` nothing more is posted, and the run ends within three more.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import itertools
import json
import math
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from instruments.postgres import PostgresServer, postgres
from instruments.processor_time import ProcessorTime
from instruments.robot_host import robot_name, robot_settings

from agentrob.agent.execution.execute import holder_of
from agentrob.config.board import BoardConfig, BoardLimitsConfig
from agentrob.config.forum import ForumConfig
from agentrob.config.journal import JournalConfig
from agentrob.config.load import Config
from agentrob.demo.ports import free_port
from agentrob.errors import ForumError
from agentrob.forums.protocol import Forum
from agentrob.model import AccountKind, CommandState, EventKind, Post, Role
from agentrob.model.lifecycle import FINAL_STATES
from agentrob.process.child import Child, terminate_all
from agentrob.wiring import app

ROBOT_HOST = Path(__file__).parent / "instruments" / "robot_host.py"
ROBOTS_A_HOST = 50
POSTERS = 8
#: Posts of a poster in one topic.
POSTS_A_TOPIC = 50
#: How long a command may take to its final reply when workers die meanwhile.
END_S = 120.0
TAKEOVER_S, STOP_MS = 15.0, 200.0
#: How long until robots that were just taken are idle.
SETTLE_S = 5.0
#: How long the last stops have to reach their robots.
LAST_STOPS_S = 3.0
#: How often a line says how far it is.
PROGRESS_S = 30.0
#: The size that issue 17 asks for, at a rate that two cores can carry out.
FULL = {
    "postgres": True, "robots": 200, "workers": 4, "commands": 10_000, "rate": 2.5, "kills": 60, "database_kills": 5,
    "minutes": 110.0, "idle": 30.0,
}  # fmt: skip
WRONG = ("lost", "moved twice", "answered twice", "untrue")
#: Conditions under which a stop is delivered.
CALM, TAKEOVER, ORPHANED, DATABASE_DEAD = (
    "with every robot served", "while other robots are taken over", "while no worker serves the robot",
    "while the database is dead",
)  # fmt: skip
#: Final states that say that nothing moved.
UNMOVED = frozenset({CommandState.CANCELLED, CommandState.EXPIRED, CommandState.REFUSED, CommandState.ASKS_BACK})


class WorkerProcess:
    """One worker, whose ready lines are read as they come."""

    def __init__(self, fleet: Fleet, number: int) -> None:
        self._fleet = fleet
        self.number = number
        self.serving: set[str] = set()
        self._start()

    def _start(self) -> None:
        log = (self._fleet.folder / f"worker-{self.number}.log").open("a")
        command = ["agent", "run", "--all", "--most", str(self._fleet.room), "--config", str(self._fleet.config_path)]
        self.process = subprocess.Popen(
            [sys.executable, "-m", "agentrob", *command], stdout=subprocess.PIPE, stderr=log, text=True,
            env={**os.environ, **self._fleet.env},
        )  # fmt: skip
        threading.Thread(target=self._read, args=(self.process,), daemon=True).start()

    def _read(self, process: subprocess.Popen[str]) -> None:
        assert process.stdout is not None
        for line in process.stdout:
            with contextlib.suppress(ValueError):
                if (robot := json.loads(line).get("robot")) and process.poll() is None:
                    self._fleet.taken(robot, self)

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()

    def start_again(self) -> None:
        self._start()

    def end(self) -> None:
        self.process.terminate()
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()


@dataclass
class Command:
    """One posted command and what came of it."""

    robot: str
    posted_s: float
    trace_id: str = ""
    state: str = ""
    ended_s: float = 0.0
    replies: set[str] = field(default_factory=set)


@dataclass
class Stop:
    """A stop that was posted: when it was sent, and when the board had accepted it."""

    robot: str
    sent_s: float
    accepted_s: float


class Fleet:
    """The processes, and who serves which robot since when."""

    def __init__(
        self, folder: Path, robots: int, workers: int, room: int, database: PostgresServer | None = None
    ) -> None:
        self.folder = folder
        self._database = database
        self.robots = [robot_name(number) for number in range(robots)]
        self.room = room
        self.workers: list[WorkerProcess] = []
        #: For each robot of a killed worker, from when until when no worker served it.
        self.takeovers: list[tuple[float, float]] = []
        self.kills = self.database_kills = 0
        #: What went on for too long after a kill.
        self.late: list[str] = []
        self._count, self._changed = workers, threading.Condition()
        self._server: dict[str, WorkerProcess] = {}
        self._orphaned_s: dict[str, float] = {}
        #: For each robot, from when until when no worker served it.
        self.orphaned: defaultdict[str, list[tuple[float, float]]] = defaultdict(list)
        #: When each outage of the database began and ended.
        self.database_outages: list[tuple[float, float]] = []
        self._children: list[Child] = []
        self._hosts: list[subprocess.Popen[str]] = []
        port = free_port()
        url = f"http://127.0.0.1:{port}"
        where = database.url if database is not None else ""
        unlimited = BoardLimitsConfig.model_validate(dict.fromkeys(BoardLimitsConfig.model_fields, 0))
        self.config = Config(
            data=str(folder),
            board=BoardConfig(listen=f"127.0.0.1:{port}", base_url=url, database=where, limits=unlimited),
            forum=ForumConfig(url=url),
            journal=JournalConfig(database=where),
            robots={robot: robot_settings(20.0) for robot in self.robots},
        )
        self.config_path = folder / "agentrob.toml"
        self.config.write(self.config_path)
        self.env = {"AGENTROB_DATA": str(folder), "AGENTROB_RUNTIME": str(folder)}
        os.environ.update(self.env)

    @property
    def ledger(self) -> Path:
        return self.folder / "ledger.jsonl"

    def start(self) -> float:
        """Start everything; return the seconds until the workers served all robots."""
        app.board_account(self.config, "alice", AccountKind.HUMAN, Role.OPERATOR)
        for robot in self.robots:
            app.board_account(self.config, robot, AccountKind.ROBOT_AGENT, Role.MEMBER)
            variable = f"AGENTROB_TOKEN_{robot.upper().replace('-', '_')}"
            self.env[variable] = app.board_token(self.config, robot)
        board = ["board", "serve", "--config", str(self.config_path)]
        self._children.append(Child("board", board, self.folder / "board.log", self.env))
        self._children[0].wait_ready()
        runtime = self.folder / "agentrob"
        runtime.mkdir(exist_ok=True)
        for first in range(0, len(self.robots), ROBOTS_A_HOST):
            some = min(ROBOTS_A_HOST, len(self.robots) - first)
            where = ["--runtime", str(runtime), "--data", str(self.folder), "--ledger", str(self.ledger)]
            which = ["--robots", str(some), "--first", str(first)]
            host = subprocess.Popen(
                [sys.executable, str(ROBOT_HOST), *which, *where],
                stdout=subprocess.PIPE, text=True, stderr=(self.folder / "robots.log").open("a"),
            )  # fmt: skip
            self._hosts.append(host)
            assert host.stdout is not None
            assert json.loads(host.stdout.readline())["ready"]
        begun_s = time.monotonic()
        self.workers += [WorkerProcess(self, number) for number in range(self._count)]
        self.wait_served(120.0)
        return time.monotonic() - begun_s

    def taken(self, robot: str, worker: WorkerProcess) -> None:
        """A worker said that it serves a robot."""
        with self._changed:
            killed = robot not in self._server
            self._server[robot] = worker
            if (since_s := self._orphaned_s.pop(robot, None)) is not None:
                now_s = time.monotonic()
                self.orphaned[robot].append((since_s, now_s))
                if killed:
                    self.takeovers.append((since_s, now_s))
            self._changed.notify_all()

    def kill(self, among: Sequence[WorkerProcess]) -> None:
        """Kill a worker, wait until others serve its robots, and start it again."""
        with self._changed:
            worker = random.choice(among)
            worker.kill()
            self.kills += 1
            now_s = time.monotonic()
            for robot in [robot for robot, server in self._server.items() if server is worker]:
                self._orphaned_s[robot] = now_s
                del self._server[robot]
        try:
            self.wait_served(60.0)
        except TimeoutError as e:
            self.late.append(str(e))
        worker.start_again()

    def kill_database(self, database: PostgresServer) -> None:
        """Kill the database and start it again: every worker loses its robots until then."""
        with self._changed:
            now_s = time.monotonic()
            for robot in self.robots:
                self._orphaned_s.setdefault(robot, now_s)
        database.kill()
        self.database_outages.append((now_s, time.monotonic()))
        self.database_kills += 1

    def takeovers_s(self, database_dead: bool = False) -> list[float]:
        """The durations of takeovers: of those with the database running throughout, or of those during an outage."""
        return [
            end_s - begin_s
            for begin_s, end_s in self.takeovers
            if overlaps(self.database_outages, begin_s, end_s) is database_dead
        ]

    def condition(self, robot: str, begin_s: float, end_s: float) -> str:
        """The condition in this time that can delay a stop of this robot."""
        if overlaps(self.database_outages, begin_s, end_s):
            return DATABASE_DEAD
        if overlaps(self.orphaned[robot], begin_s, end_s):
            return ORPHANED
        orphaned = itertools.chain.from_iterable(self.orphaned.values())
        return TAKEOVER if overlaps(orphaned, begin_s, end_s) else CALM

    def processes(self) -> dict[str, list[int]]:
        """The first processes of each part of the system."""
        database = self._database.leader if self._database is not None else None
        return {
            "board": [child.process.pid for child in self._children],
            "workers": [worker.process.pid for worker in self.workers],
            "drivers": [host.pid for host in self._hosts],
            "database": [database] if database is not None else [],
        }

    def working(self) -> list[WorkerProcess]:
        """The workers that serve robots."""
        with self._changed:
            return [worker for worker in self.workers if worker in self._server.values()]

    def wait_served(self, limit_s: float) -> None:
        """Wait until each robot is served. Raises `TimeoutError` with the number of those that are not."""
        with self._changed:
            if not self._changed.wait_for(lambda: len(self._server) == len(self.robots), limit_s):
                raise TimeoutError(f"{len(self.robots) - len(self._server)} robots are not served after {limit_s:g} s")

    def end(self) -> None:
        for worker in self.workers:
            worker.end()
        for host in self._hosts:
            host.terminate()
            host.wait(20)
        terminate_all(self._children)

    def steps(self) -> Iterator[dict[str, Any]]:
        """The steps and stops that reached the robots."""
        with self.ledger.open() as lines:
            yield from map(json.loads, lines)


class Traffic:
    """People who command the robots, and what the forum shows of it."""

    def __init__(self, fleet: Fleet, commands: int, rate: float, limit_s: float = math.inf, stops: float = 1.0) -> None:
        self._fleet, self._rate, self._stop_rate, self._begun_s = fleet, rate, stops, time.monotonic()
        self._end_s = self._begun_s + limit_s
        self._left = iter(range(commands))
        self.commands: dict[str, Command] = {}
        self.stops: list[Stop] = []
        self._early: defaultdict[str, list[Post]] = defaultdict(list)
        self._ended: dict[str, asyncio.Event] = {}
        self._wanted, self._limit_s, self.ended = commands, limit_s, 0

    @property
    def progress(self) -> float:
        """Which share of the commands has ended, or of the time has passed: the larger one."""
        return max(self.ended / self._wanted, self.seconds / self._limit_s)

    @property
    def seconds(self) -> float:
        return time.monotonic() - self._begun_s

    async def tell(self, fleet: Fleet) -> None:
        """Print progress until cancelled."""
        while True:
            await asyncio.sleep(PROGRESS_S)
            left_s = min(self.seconds / max(1, self.ended) * (self._wanted - self.ended), self._limit_s - self.seconds)
            print(
                f"{self.seconds / 60:5.1f} min: {self.ended} of {self._wanted} ended, {len(self.stops)} stops; "
                f"{fleet.kills} workers and {fleet.database_kills} databases killed, "
                f"slowest takeover {max(fleet.takeovers_s(), default=0.0):.1f} s; about {left_s / 60:.0f} min left",
                flush=True,
            )

    async def run(self, forum: Forum) -> None:
        after, _ = await forum.now()
        watching = asyncio.create_task(self._watch(forum, after))
        stopping = asyncio.create_task(self._stop(forum))
        await asyncio.gather(*(self._post(forum) for _ in range(POSTERS)))
        stopping.cancel()
        await asyncio.gather(stopping, return_exceptions=True)
        await asyncio.sleep(LAST_STOPS_S)
        watching.cancel()
        await asyncio.gather(watching, return_exceptions=True)

    async def _post(self, forum: Forum) -> None:
        topic = ""
        for count, number in enumerate(self._left):
            await asyncio.sleep(max(0.0, self._begun_s + number / self._rate - time.monotonic()))
            if time.monotonic() > self._end_s:
                return
            robot = self._fleet.robots[number % len(self._fleet.robots)]
            text = f"@{robot} turn {'left' if number % 2 else 'right'} 90 degrees"
            begun_s = time.monotonic()
            post, _ = await self._write(forum, "" if count % POSTS_A_TOPIC == 0 else topic, text, str(number))
            topic = post.topic_id
            self.commands[post.id] = Command(robot, begun_s)
            ended = self._ended[post.id] = asyncio.Event()
            for status in self._early.pop(post.id, ()):
                self._note(status)
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(END_S):
                    await ended.wait()

    async def _write(self, forum: Forum, topic: str, text: str, key: str) -> tuple[Post, float]:
        """Post in a topic, or in a new one; again if the forum was away. The key makes it one post. Returns it, and
        when the attempt that was accepted began."""
        while True:
            sent_s = time.monotonic()
            with contextlib.suppress(ForumError):
                if topic:
                    return (await forum.reply(topic, text, key=key)).post, sent_s
                return (await forum.create_topic("robots", f"Fleet {key}", text, key=key)).post, sent_s
            await asyncio.sleep(0.2)

    async def _watch(self, forum: Forum, after: str) -> None:
        while True:
            with contextlib.suppress(ForumError):
                async for event in forum.stream(after):
                    after = event.id or after
                    if event.post is not None and event.kind is not EventKind.POST_REMOVED:
                        self._note(event.post)
            await asyncio.sleep(0.2)

    def _note(self, status: Post) -> None:
        if status.card is None or status.reply_to is None:
            return
        command = self.commands.get(status.reply_to)
        if command is None:
            self._early[status.reply_to].append(status)
            return
        command.replies.add(status.id)
        command.trace_id = status.card.trace_id or command.trace_id
        if status.card.state in FINAL_STATES:
            self.ended += not command.state
            command.state, command.ended_s = status.card.state, time.monotonic()
            self._ended[status.reply_to].set()

    async def _stop(self, forum: Forum) -> None:
        """Stop one robot after the other, each in a topic of its own."""
        for number in itertools.count() if self._stop_rate > 0 else ():
            await asyncio.sleep(1 / self._stop_rate)
            robot = random.choice(self._fleet.robots)
            _, sent_s = await self._write(forum, "", f"@{robot} stop", f"stop-{number}")
            self.stops.append(Stop(robot, sent_s, time.monotonic()))


@dataclass
class Findings:
    """The forum's replies compared with the steps that reached the robots."""

    states: Counter[str] = field(default_factory=Counter)
    #: Posts by what is wrong with them.
    wrong: dict[str, list[str]] = field(default_factory=lambda: {what: [] for what in WRONG})
    #: Until each stop reached its robot, or the robot stood because its worker was dead; by condition.
    stops_ms: defaultdict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    #: Until the board had accepted each of these.
    accepted_ms: defaultdict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    stops_lost: int = 0


@dataclass
class RobotMotion:
    """The stops that reached one robot, and from when until when it moved."""

    stops_s: list[float] = field(default_factory=list)
    moves_s: list[tuple[float, float]] = field(default_factory=list)
    begun_s: float = 0.0

    def stopped_s(self, sent_s: float) -> float | None:
        """When a stop that was sent then reached the robot; None if it never did."""
        return min((at_s for at_s in self.stops_s if at_s >= sent_s), default=None)

    def stood_s(self, since_s: float) -> float:
        """When the robot stood that may have moved then."""
        return next((end_s for begin_s, end_s in self.moves_s if begin_s <= since_s < end_s), since_s)


def judge(traffic: Traffic, fleet: Fleet) -> Findings:
    """Compare each command's replies with the ledger."""
    found, begun, done = Findings(), Counter[str](), Counter[str]()
    robots: defaultdict[str, RobotMotion] = defaultdict(RobotMotion)
    for step in fleet.steps():
        robot = robots[step["robot"]]
        if step["what"] == "stop":
            robot.stops_s.append(step["at_s"])
        elif step["what"] == "begun":
            begun[step["holder"]] += 1
            robot.begun_s = step["at_s"]
        else:
            robot.moves_s.append((robot.begun_s, step["at_s"]))
            if step["what"] == "done":
                done[step["holder"]] += 1
    for post_id, command in traffic.commands.items():
        holder = holder_of(command.trace_id)
        found.states[command.state or "lost"] += 1
        moved_unsaid = command.state in UNMOVED and begun[holder] > 0
        wrong = {
            "lost": not command.state,
            "answered twice": len(command.replies) > 1,
            "moved twice": begun[holder] > 1,
            "untrue": moved_unsaid or (command.state == CommandState.DONE and not done[holder]),
        }
        for what in (what for what, is_so in wrong.items() if is_so):
            found.wrong[what].append(post_id)
    for stop in traffic.stops:
        if (stopped_s := robots[stop.robot].stopped_s(stop.sent_s)) is None:
            found.stops_lost += 1
            continue
        condition = fleet.condition(stop.robot, stop.sent_s, stopped_s)
        if condition in (ORPHANED, DATABASE_DEAD):
            stopped_s = min(stopped_s, robots[stop.robot].stood_s(stop.sent_s))
        found.stops_ms[condition].append((stopped_s - stop.sent_s) * 1000)
        found.accepted_ms[condition].append((stop.accepted_s - stop.sent_s) * 1000)
    return found


async def _again_and_again(times: int, traffic: Traffic, done: asyncio.Event, kill: Callable[[], None]) -> None:
    """Kill processes at random moments, spread over the traffic."""
    for number in range(times):
        at = (number + random.random()) / times
        while traffic.progress < at:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(0.5):
                    await done.wait()
            if done.is_set():
                return
        await asyncio.to_thread(kill)


async def run(
    fleet: Fleet,
    commands: int,
    rate: float,
    kills: int,
    database: PostgresServer | None,
    database_kills: int,
    limit_s: float = math.inf,
    stops: float = 1.0,
) -> Traffic:
    """Let people command the fleet while workers and the database are killed; return what they saw."""
    forum = app.make_forum(fleet.config, app.board_token(fleet.config, "alice"))
    traffic, done = Traffic(fleet, commands, rate, limit_s, stops), asyncio.Event()
    killing = [asyncio.create_task(_again_and_again(kills, traffic, done, lambda: fleet.kill(fleet.working())))]
    if database is not None:
        killing.append(
            asyncio.create_task(_again_and_again(database_kills, traffic, done, lambda: fleet.kill_database(database)))
        )
    telling = asyncio.create_task(traffic.tell(fleet))
    try:
        await traffic.run(forum)
        done.set()
        await asyncio.gather(*killing)
    finally:
        for task in (*killing, telling):
            task.cancel()
        await forum.close()
    return traffic


def overlaps(spans: Iterable[tuple[float, float]], begin_s: float, end_s: float) -> bool:
    """Whether any of these intervals overlaps the one from `begin_s` to `end_s`."""
    return any(first_s < end_s and last_s > begin_s for first_s, last_s in spans)


def percentiles(values: Sequence[float]) -> tuple[float, float, float]:
    """The median, the 99th percentile and the largest."""
    ordered = sorted(values) or [0.0]
    return ordered[len(ordered) // 2], ordered[min(len(ordered) - 1, int(0.99 * len(ordered)))], ordered[-1]


def report(fleet: Fleet, found: Findings, seconds: float) -> list[str]:
    """Print the findings as a table, and return what was missed."""
    stops = list(itertools.chain.from_iterable(found.stops_ms.values()))
    p50, p99, worst = percentiles(stops)
    takeover_p50_s, _, takeover_s = percentiles(fleet.takeovers_s())
    delayed_s = fleet.takeovers_s(database_dead=True)
    states = ", ".join(f"{count} {state}" for state, count in found.states.most_common())
    print(f"final states: {states}")
    print(f"stops without effect: {found.stops_lost}")
    rows = {
        "robots, workers": f"{len(fleet.robots)}, {len(fleet.workers)}",
        "commands": f"{found.states.total()} in {seconds:.0f} s",
        "kills of workers, databases": f"{fleet.kills}, {fleet.database_kills}",
        " · ".join(found.wrong): " · ".join(str(len(posts)) for posts in found.wrong.values()),
        "takeovers p50, worst": f"{takeover_p50_s:.1f}, {takeover_s:.1f} s (wanted {TAKEOVER_S:g})",
        "takeovers while the database was dead too": f"{len(delayed_s)}, worst {max(delayed_s, default=0.0):.1f} s",
        "stops": str(len(stops)),
        "stop p50, p99, worst": f"{p50:.0f}, {p99:.0f}, {worst:.0f} ms (wanted p99 {STOP_MS:g})",
    }
    for condition, some in found.stops_ms.items():
        times = ", ".join(f"{ms:.0f}" for ms in percentiles(some))
        accepted = ", ".join(f"{ms:.0f}" for ms in percentiles(found.accepted_ms[condition]))
        rows[f"{len(some)} {condition}"] = f"{times} ms; accepted by the board after {accepted} ms"
    print("\n".join(f"| {what} | {value} |" for what, value in rows.items()))
    missed = [f"{what}: posts {', '.join(posts[:10])}" for what, posts in found.wrong.items() if posts]
    missed += fleet.late
    missed += [f"a takeover took {takeover_s:.1f} s"] if takeover_s > TAKEOVER_S else []
    return missed + ([f"stop p99 {p99:.0f} ms"] if p99 > STOP_MS else [])


def shares(spent_s: Counter[str], count: float) -> str:
    """Processor time of each part, divided by `count`."""
    parts = ", ".join(f"{part} {seconds / count:.2f}" for part, seconds in spent_s.most_common())
    return f"{sum(spent_s.values()) / count:.2f} ({parts})"


def main(argv: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--commands", type=int, default=400)
    parser.add_argument("--rate", type=float, default=5.0, help="Commands per second, at most.")
    parser.add_argument("--kills", type=int, default=6, help="How often a worker is killed.")
    parser.add_argument("--postgres", action="store_true", help="Board and journals on PostgreSQL.")
    parser.add_argument("--database-kills", type=int, default=0, help="How often PostgreSQL is killed.")
    parser.add_argument("--minutes", type=float, default=math.inf, help="Post no more commands after this time.")
    parser.add_argument("--stops", type=float, default=1.0, help="Stops per second.")
    parser.add_argument("--idle", type=float, default=0.0, help="Measure idle robots for so many seconds before.")
    parser.add_argument("--full", action="store_true", help=f"The size that is wanted: {FULL}.")
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--no-times", action="store_true", help="Judge only what must never happen, no times.")
    parser.add_argument("--keep", type=Path, help="Keep logs and ledger in this folder.")
    if parser.parse_known_args(argv)[0].full:
        parser.set_defaults(**FULL)  # other options still count
    options = parser.parse_args(argv)
    random.seed(options.seed)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    with contextlib.ExitStack() as stack:
        folder = options.keep or Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="agentrob-fleet-")))
        folder.mkdir(exist_ok=True)
        # When one of several workers is dead, several others have room for its robots.
        room = math.ceil(1.5 * options.robots / max(1, options.workers - 1))
        database = stack.enter_context(postgres(folder)) if options.postgres else None
        fleet = Fleet(folder, options.robots, options.workers, room, database)
        stack.callback(fleet.end)
        used = stack.enter_context(ProcessorTime(fleet.processes))
        start_s = fleet.start()
        print(f"all robots served after {start_s:.1f} s", flush=True)
        if options.idle:
            time.sleep(SETTLE_S)
            before = used.seconds()
            time.sleep(options.idle)
            print(
                "idle, per cent of a core a robot:",
                shares(used.seconds() - before, options.robots * options.idle / 100),
            )
        before, people_s, begun_s = used.seconds(), time.process_time(), time.monotonic()
        traffic = asyncio.run(
            run(
                fleet,
                options.commands,
                options.rate,
                options.kills,
                database,
                options.database_kills,
                60 * options.minutes,
                options.stops,
            )
        )
        seconds, spent = time.monotonic() - begun_s, used.seconds() - before
        spent["people"] = time.process_time() - people_s
        print("processor ms a command:", shares(spent, len(traffic.commands) / 1000))
        missed = report(fleet, judge(traffic, fleet), seconds)
    if options.no_times:
        missed = [line for line in missed if "posts" in line]
    raise SystemExit("missed: " + "; ".join(missed) if missed else 0)


if __name__ == "__main__":
    main()
