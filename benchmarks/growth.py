"""Measure growth while one agent carries out many commands: rows, files, disk, memory, threads and open files.

    nice -n 15 python benchmarks/growth.py [--commands 10000] [--every 500] [--together 3]

Agent, driver (a fake robot whose clock runs as fast as possible) and embedded forum (SQLite) each run in their own
process, as in use; this process writes the posts, and reads the memory of the others from /proc.
To reach the limits early, the agent keeps 100 commands and 2 MB of recordings, the forum 1,000 events, and both prune
every few seconds instead of once an hour. Data with a minimum age (claims and events: days, the engine's rows: an hour)
is deleted without it here, since the run is shorter. Posts are kept for ever, so the forum's own file grows with them.
"""

from __future__ import annotations

import argparse
import asyncio
import multiprocessing
import os
import signal
import sqlite3
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from agentrob.agent.agent import RobotAgent
from agentrob.agent.reporting import presence
from agentrob.agent.reporting.status_post import is_final
from agentrob.agent.store import journal as journals
from agentrob.agent.store import retention
from agentrob.board import server
from agentrob.board.admin import local_admin
from agentrob.board.admin import retention as board_retention
from agentrob.board.settings import BoardSettings
from agentrob.config.board import BoardConfig, BoardRetentionConfig
from agentrob.config.forum import ForumConfig
from agentrob.config.robots import RobotConfig
from agentrob.errors import ForumUnreachable
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.minds.rules import RulesMind
from agentrob.model import AccountKind, Role
from agentrob.process.logs import log_to_stderr
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.process import run_driver

ROBOT, EVENTS, LIMIT_S = "quadruped", 1000, 120.0
#: How often the agent and the forum prune; a line may include data that arrived since.
PRUNED_EVERY_S = 5.0
#: How soon the robot's page shows a change: with this many commands, most requests would be for the page.
SHOWN_EVERY_S = 2.0
_spawned = multiprocessing.get_context("spawn")


def _settings() -> RobotConfig:
    return RobotConfig.model_validate({
        "model": "fake", "simulated": True, "home_on_start": True, "domain": 1 + os.getpid() % 230,
        "options": {"time_scale": "inf"}, "fence": {"x_min_m": -90, "x_max_m": 90, "y_min_m": -90, "y_max_m": 90},
        "rates": {"commands_per_hour": 0, "cooldown_s": 0, "waiting": 0},
        "retention": {"commands": 100}, "recording": {"keep_mb": 2},
    })  # fmt: skip


# -------------------------------------------------------------------- the processes
def _board(folder: Path, told: Connection) -> None:
    log_to_stderr()
    board_retention.EVERY_S = PRUNED_EVERY_S
    keep = BoardRetentionConfig.model_construct(event_days=0.0, events=EVENTS)
    settings = replace(BoardSettings.from_config(BoardConfig(listen="127.0.0.1:0"), folder), retention=keep)
    local_admin.bootstrap(settings)
    robot = local_admin.create_account(settings, ROBOT, kind=AccountKind.ROBOT_AGENT)
    alice = local_admin.create_account(settings, "alice", role=Role.OPERATOR)
    tokens = [local_admin.issue_token(settings, account) for account in (robot, alice)]
    server.serve(settings, lambda served: told.send((served.base_url, *tokens)))


def _driver(settings: RobotConfig, folder: Path) -> None:
    log_to_stderr()
    run_driver(ROBOT, settings, folder / "d.sock", folder)


def _agent(settings: RobotConfig, folder: Path, url: str, token: str, told: Connection) -> None:
    log_to_stderr()
    retention.FIRST_S, retention.EVERY_S, journals.AT_LEAST_S = (0.0, 0.0), PRUNED_EVERY_S, 0.0
    presence.DEBOUNCE_S = SHOWN_EVERY_S

    async def run() -> None:
        forum = BoardForum(ForumConfig(url=url), token)
        driver = DriverClient(ROBOT, folder / "d.sock")
        agent = RobotAgent(ROBOT, settings, forum, driver, RulesMind(), folder)
        try:
            await agent.run(lambda: told.send(True))
        finally:
            await agent.close()

    asyncio.run(run())


@contextmanager
def _running(work: Callable[..., None], *args: Any) -> Iterator[int]:
    """Run a process, yield its id, and end it afterwards."""
    process = _spawned.Process(target=work, args=args, daemon=True)
    process.start()
    assert process.pid is not None
    try:
        yield process.pid
    finally:
        process.terminate()
        process.join(10.0)
        if process.is_alive():
            process.kill()


def _answer(pipe: Connection) -> Any:
    if not pipe.poll(LIMIT_S):
        sys.exit("a process did not start")
    return pipe.recv()


# -------------------------------------------------------------------- what is measured
COLUMNS = (
    "commands", "done", "claims", "assessments", "records", "files", "agent MB on disk", "agent MB", "agent threads",
    "agent open files", "driver MB", "events", "posts", "board MB on disk", "board MB", "board threads",
    "s per command",
)  # fmt: skip


def _counts(path: Path, *tables: str) -> list[int]:
    db = sqlite3.connect(f"file:{path}?mode=ro", uri=True, timeout=30.0)
    found = [db.execute(f"SELECT count(*) FROM {table}").fetchone()[0] for table in tables]
    db.close()
    return found


def _memory(pid: int) -> int:
    """The memory of a process in MB, without pages shared with files on disk."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    return int(next(line for line in lines if line.startswith("RssAnon")).split()[1]) // 1024


def _of(folder: Path) -> tuple[int, int, float]:
    """The number of files, the number of command records among them, and MB."""
    files, records, size = 0, 0, 0
    for path in folder.rglob("*"):
        with suppress(FileNotFoundError):
            if path.is_file():
                files, size = files + 1, size + path.stat().st_size
                records += path.parent.name == "records"
    return files, records, size / 2**20


def _line(folder: Path, pids: tuple[int, int, int], sent: int, done: int, each_s: float) -> str:
    agent, driver, board = pids
    claims, assessments = _counts(folder / "agents" / ROBOT / "journal.sqlite", "claim", "assessment")
    events, posts = _counts(folder / "board" / "board.sqlite3", "events", "posts")
    files, records, mb = _of(folder / "agents")
    shown = (
        sent, done, claims, assessments, records, files, f"{mb:.1f}", _memory(agent),
        len(os.listdir(f"/proc/{agent}/task")), len(os.listdir(f"/proc/{agent}/fd")), _memory(driver), events, posts,
        f"{_of(folder / 'board')[2]:.1f}",
        _memory(board), len(os.listdir(f"/proc/{board}/task")), f"{each_s:.2f}",
    )  # fmt: skip
    return " | ".join(map(str, shown))


def _command(number: int) -> str:
    """Mostly gestures, which have no pictures; every 10th command is a turn, whose path is drawn, and every 50th a
    walk, which also has an animation."""
    if number % 50 == 0:
        return f"@{ROBOT} walk 1 metre {'forward' if number % 100 else 'backward'}"
    if number % 10 == 0:
        return f"@{ROBOT} turn {'left' if number % 20 else 'right'} 20 degrees"
    return f"@{ROBOT} wave"


async def _measure(options: argparse.Namespace, url: str, token: str, folder: Path, pids: tuple[int, int, int]) -> None:
    alice = BoardForum(ForumConfig(url=url), token)
    finals: asyncio.Queue[tuple[str, str]] = asyncio.Queue()

    async def listen(after: str) -> None:
        while True:
            with suppress(ForumUnreachable):  # on a very busy machine the forum may fall silent
                async for event in alice.stream(after):
                    after, post = event.id or after, event.post
                    if post is not None and post.reply_to and is_final(post.card):
                        assert post.card is not None
                        finals.put_nowait((post.reply_to, post.card.state))

    listening = asyncio.create_task(listen((await alice.now())[0]))
    print(" | ".join(COLUMNS), flush=True)
    sent, done, begun, before = 0, 0, time.monotonic(), 0
    waiting: set[str] = set()
    for n in range(1, options.commands + 1):
        while len(waiting) < options.together and sent < options.commands:
            sent += 1
            written = await alice.create_topic("robots", f"Topic {sent}", _command(sent), key=f"k{sent}")
            waiting.add(written.post.id)
        async with asyncio.timeout(LIMIT_S):
            while (final := await finals.get())[0] not in waiting:
                pass
        waiting.remove(final[0])
        done += final[1] == "done"
        if n % options.every == 0 or n == 1:
            each_s = (time.monotonic() - begun) / (n - before)
            print(_line(folder, pids, n, done, each_s), flush=True)
            begun, before = time.monotonic(), n
    listening.cancel()
    await asyncio.wait({listening})
    await alice.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--commands", type=int, default=10_000)
    parser.add_argument("--every", type=int, default=500)
    parser.add_argument("--together", type=int, default=3, help="number of commands open at once")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # the other processes are ended too
    settings = _settings()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (mine, board_s), (also_mine, agent_s) = _spawned.Pipe(), _spawned.Pipe()
        with _running(_board, folder, board_s) as board:
            url, robots_token, token = _answer(mine)
            with _running(_driver, settings, folder) as driver:
                while not (folder / "d.sock").exists():
                    time.sleep(0.1)
                with _running(_agent, settings, folder, url, robots_token, agent_s) as agent:
                    _answer(also_mine)
                    pids = agent, driver, board
                    asyncio.run(_measure(options, url, token, folder, pids))


if __name__ == "__main__":
    main()
