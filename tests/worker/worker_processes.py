"""Workers as processes of their own, on a real board, with a driver that writes what reached the robot."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from agentrob.config.forum import ForumConfig
from agentrob.config.journal import JournalConfig
from agentrob.config.load import Config
from tests.agent.agent_process import Poster
from tests.agent.agent_scene import ROBOT, Driver
from tests.agent.store.journal_store import database_of
from tests.board.running_board import RunningBoard
from tests.forked_process import ForkedCommand
from tests.waiting import until

LIMIT_S = 60.0


class Workers:
    """Starts workers as people do, and reads their ready lines."""

    def __init__(self, folder: Path, board: RunningBoard, driver: Driver) -> None:
        self.folder, self.config = folder, folder / "agentrob.toml"
        config = Config(
            data=str(folder), forum=ForumConfig(url=board.url), journal=JournalConfig(database=database_of(folder)),
            robots={ROBOT: driver.settings},
        )  # fmt: skip
        config.write(self.config)
        self._env = {"AGENTROB_RUNTIME": str(folder), "AGENTROB_TOKEN": board.tokens[ROBOT]}
        self._ledger = driver.socket.with_name("ledger.jsonl")

    @contextmanager
    def running(self, *arguments: str) -> Iterator[ForkedCommand]:
        """Start one; wait until it serves the robot, or waits for it as a standby."""
        log = self.folder / "workers.log"
        words = ("agent", "run", *arguments, "--config", str(self.config))
        process = ForkedCommand(self.folder, *words, log=log, **self._env)
        try:
            assert ROBOT in process.stdout.readline(), log.read_text()[-3000:]
            yield process
        finally:
            process.kill()
            process.wait()
            process.close()

    def ledger(self) -> list[dict[str, Any]]:
        """The steps and stops that reached the robot, in order."""
        lines = self._ledger.read_text().splitlines() if self._ledger.exists() else []
        return [json.loads(line) for line in lines]


async def until_state(op: Poster, topic: str, state: str) -> None:
    await until(lambda: op.states(topic), lambda states: state in states, limit_s=LIMIT_S)
