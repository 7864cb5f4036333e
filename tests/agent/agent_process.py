"""An agent in a process of its own, on a real board, with a robot's driver that the test started."""

from __future__ import annotations

import asyncio
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.agent.agent_scene import FINAL, ROBOT, Driver
from tests.board.running_board import RunningBoard

_AGENT = """
import asyncio, sys
from pathlib import Path
from agentrob.agent.agent import RobotAgent
from agentrob.process.logs import log_to_stderr
from agentrob.config.forum import ForumConfig
from agentrob.config.robots import RobotConfig
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.minds.rules import RulesMind
from agentrob.robots.driver.client import DriverClient
name, settings, socket, data, url, token = sys.argv[1:]
log_to_stderr()
async def main():
    agent = RobotAgent(name, RobotConfig.model_validate_json(settings), BoardForum(ForumConfig(url=url), token),
                       DriverClient(name, Path(socket)), RulesMind(), Path(data))
    await agent.run(on_ready=lambda: print("ready", flush=True))
asyncio.run(main())
"""


_running: list[subprocess.Popen[str]] = []


def start_agent(driver: Driver, folder: Path, board: RunningBoard) -> subprocess.Popen[str]:
    """Started and listening; ended with its test, if that does not end it."""
    settings = driver.settings.model_dump_json()
    arguments = [ROBOT, settings, str(driver.socket), str(folder), board.url, board.tokens[ROBOT]]
    process = subprocess.Popen([sys.executable, "-c", _AGENT, *arguments], stdout=subprocess.PIPE, text=True)
    _running.append(process)
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n"
    return process


def end_agent(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.wait()
    assert process.stdout is not None
    process.stdout.close()
    _running.remove(process)


def end_agents() -> None:
    """All that are left."""
    for process in list(_running):
        end_agent(process)


class Poster:
    """Somebody on the board, over its API."""

    def __init__(self, board: RunningBoard, name: str) -> None:
        self._http = board.client(name)

    async def post(self, body: str) -> str:
        """Begin a topic; its id."""
        content = {"board_id": "robots", "title": "A topic", "body": body}
        made = await asyncio.to_thread(self._http.post, "/topics", json=content)
        return str(made.raise_for_status().json()["topic"]["id"])

    async def states(self, topic: str) -> list[str]:
        """What the robot's status posts in a topic say."""
        items = (await asyncio.to_thread(self._http.get, f"/topics/{topic}/posts")).json()["items"]
        return [item["card"]["state"] for item in items if item["card"]]

    async def told(self, topic: str) -> str:
        """What the robot's newest status post in a topic says."""
        items = (await asyncio.to_thread(self._http.get, f"/topics/{topic}/posts")).json()["items"]
        return str([item["raw"] for item in items if item["card"]][-1])

    async def final(self, topic: str, limit_s: float = 60.0) -> list[str]:
        """The states once one of them is final."""
        async with asyncio.timeout(limit_s):
            while not set(states := await self.states(topic)) & FINAL:  # noqa: ASYNC110 (another process)
                await asyncio.sleep(0.05)
        return states

    def __enter__(self) -> Poster:
        return self

    def __exit__(self, *_: object) -> None:
        self._http.close()


async def until(driver: Driver, condition: Callable[[Any], bool], limit_s: float = 60.0) -> None:
    """Look at the robot until its state is so."""
    async with asyncio.timeout(limit_s), driver.client() as client:
        while not condition(await client.state()):  # noqa: ASYNC110 (another process)
            await asyncio.sleep(0.02)
