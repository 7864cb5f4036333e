"""An agent in its own process, on a real board, with a robot's driver that the test started."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from agentrob.agent.agent import RobotAgent
from agentrob.config.forum import ForumConfig
from agentrob.config.robots import RobotConfig
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.minds.rules import RulesMind
from agentrob.process.logs import log_to_stderr
from agentrob.robots.driver.client import DriverClient
from tests.agent.agent_scene import FINAL, ROBOT, Driver
from tests.agent.store.journal_store import open_journal
from tests.board.running_board import RunningBoard
from tests.forked_process import ForkedProcess
from tests.waiting import until

_running: list[ForkedProcess] = []


def run_agent(settings: RobotConfig, socket: Path, folder: Path, url: str, token: str) -> None:
    """Run an agent; the main function of its process."""
    log_to_stderr()

    async def main() -> None:
        forum, driver = BoardForum(ForumConfig(url=url), token), DriverClient(ROBOT, socket)
        opened = partial(open_journal, folder, ROBOT)
        agent = RobotAgent(ROBOT, settings, forum, driver, RulesMind(), folder, open_journal=opened)
        await agent.run(on_ready=lambda: print("ready", flush=True))  # noqa: T201

    asyncio.run(main())


def start_agent(driver: Driver, folder: Path, board: RunningBoard) -> ForkedProcess:
    """Start an agent and wait until it listens. It ends with the test at the latest."""
    arguments = driver.settings, driver.socket, folder, board.url, board.tokens[ROBOT]
    process = ForkedProcess(run_agent, *arguments, keep_stderr=False)
    _running.append(process)
    assert process.stdout.readline() == "ready\n"
    return process


def end_agent(process: ForkedProcess) -> None:
    process.kill()
    process.wait()
    process.close()
    _running.remove(process)


def end_agents() -> None:
    """End all agents that still run."""
    for process in list(_running):
        end_agent(process)


class Poster:
    """An account on the board, used over its API."""

    def __init__(self, board: RunningBoard, name: str) -> None:
        self._http = board.client(name)

    async def post(self, body: str) -> str:
        """Start a topic and return its id."""
        content = {"board_id": "robots", "title": "A topic", "body": body}
        made = await asyncio.to_thread(self._http.post, "/topics", json=content)
        return str(made.raise_for_status().json()["topic"]["id"])

    async def states(self, topic: str) -> list[str]:
        """Return the states of the robot's status posts in a topic."""
        items = (await asyncio.to_thread(self._http.get, f"/topics/{topic}/posts")).json()["items"]
        return [item["card"]["state"] for item in items if item["card"]]

    async def status_text(self, topic: str) -> str:
        """Return the text of the robot's newest status post in a topic."""
        items = (await asyncio.to_thread(self._http.get, f"/topics/{topic}/posts")).json()["items"]
        return str([item["raw"] for item in items if item["card"]][-1])

    async def final(self, topic: str, limit_s: float = 60.0) -> list[str]:
        """Wait for a final state and return all states."""
        return await until(lambda: self.states(topic), lambda states: set(states) & FINAL, limit_s=limit_s)

    def __enter__(self) -> Poster:
        return self

    def __exit__(self, *_: object) -> None:
        self._http.close()


async def until_state(driver: Driver, condition: Callable[[Any], bool], limit_s: float = 60.0) -> None:
    """Wait until the robot's state meets a condition."""
    async with driver.client() as client:
        await until(client.state, condition, limit_s=limit_s)
