"""What grows while one agent carries out many commands: rows of its journal, files, bytes on disk, memory, threads.

    python benchmarks/growth.py [--commands 1000] [--every 200]

A fake robot in its driver process, whose time runs as fast as it can, and a forum in this process's memory: its posts
are in the memory that is told. The agent keeps 100 commands, and lets go of the rest before each line is told, the
engine's rows without the hour that they are kept otherwise; claims are kept for a day whatever their number.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import sqlite3
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

from agentrob.agent import leftovers, retention
from agentrob.agent.turn import RobotAgent
from agentrob.config import RobotConfig
from agentrob.forums.memory import MemoryForum, MemoryWorld
from agentrob.minds.rules import RulesMind
from agentrob.model import AccountKind, Post, Role
from agentrob.robots.client import DriverClient

ROBOT = "quadruped"
DRIVER = """
import json, sys
from pathlib import Path
from agentrob.config import RobotConfig
from agentrob.robots.driver import run_driver
name, settings, socket, data = sys.argv[1:]
run_driver(name, RobotConfig.model_validate(json.loads(settings)), Path(socket), Path(data))
"""
SETTINGS = {
    "model": "fake", "simulated": True, "home_on_start": True, "domain": 1 + os.getpid() % 230,
    "options": {"time_scale": "inf"}, "fence": {"x_min_m": -90, "x_max_m": 90, "y_min_m": -90, "y_max_m": 90},
    "rates": {"commands_per_hour": 0, "cooldown_s": 0, "waiting": 0}, "retention": {"commands": 100},
}  # fmt: skip


async def _final(world: MemoryWorld, post: Post) -> Post:
    """The robot's last word on a post; no command here takes half a minute."""
    async with asyncio.timeout(30.0):
        while True:
            for said in reversed(list(world.posts.values())):
                if said.reply_to == post.id and said.card is not None and said.card.state in ("done", "failed"):
                    return said
            await world.wait(0.05)


def _line(folder: Path, commands: int, done: int) -> str:
    db = sqlite3.connect(folder / "journal.sqlite")
    counts = [
        db.execute(f"SELECT count(*) FROM {table}").fetchone()[0]
        for table in ("claim", "workflow_status", "operation_outputs")
    ]
    db.close()
    files = [path for path in folder.rglob("*") if path.is_file()]
    records = sum(path.parent.name == "records" for path in files)
    memory = next(x for x in Path("/proc/self/status").read_text().splitlines() if x.startswith("VmRSS"))
    mb = sum(path.stat().st_size for path in files) / 2**20
    shown = (commands, done, *counts, records, len(files), f"{mb:.1f}", int(memory.split()[1]) // 1024)
    return " | ".join(map(str, (*shown, threading.active_count(), len(os.listdir("/proc/self/task")))))


async def _measure(socket: Path, folder: Path, commands: int, every: int) -> None:
    world = MemoryForum.world()
    forum = world.sign_in(ROBOT, role=Role.MEMBER, kind=AccountKind.ROBOT_AGENT)
    alice = world.sign_in("alice", role=Role.OPERATOR)
    agent = RobotAgent(
        ROBOT, RobotConfig.model_validate(SETTINGS), forum, DriverClient(ROBOT, socket), RulesMind(), folder
    )
    serving = asyncio.create_task(agent.run())
    ready = asyncio.create_task(agent.ready.wait())
    await asyncio.wait({serving, ready}, return_when=asyncio.FIRST_COMPLETED, timeout=60.0)
    print("commands | done | claims | workflows | outputs | records | files | MB on disk | MB of memory", end="")
    print(" | Python threads | threads")
    done = 0
    for n in range(commands):
        text = f"@{ROBOT} turn {'left' if n % 2 else 'right'} 20 degrees"
        written = await alice.create_topic("robots", "A topic", text, key=f"k{n}")
        final = await _final(world, written.post)
        done += final.card is not None and final.card.state == "done"
        if (n + 1) % every == 0 or n == 0:
            await retention.prune(agent.journal, agent.records, agent.settings.retention)
            print(_line(agent.folder, n + 1, done), flush=True)
    serving.cancel()
    await asyncio.wait({serving})
    await agent.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--commands", type=int, default=1000)
    parser.add_argument("--every", type=int, default=200)
    options = parser.parse_args()
    leftovers.KEEP_S = -1.0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        command = [sys.executable, "-c", DRIVER, ROBOT, json.dumps(SETTINGS), str(folder / "d.sock"), str(folder)]
        driver = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        try:
            assert driver.stdout is not None
            driver.stdout.readline()
            asyncio.run(_measure(folder / "d.sock", folder / "data", options.commands, options.every))
        finally:
            driver.terminate()
            driver.wait(10.0)


if __name__ == "__main__":
    main()
