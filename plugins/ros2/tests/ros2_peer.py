"""Start the rclpy base of `peer_base.py` in a process of its own and ask it what is true; for tests and benchmarks."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

from agentrob.config.robots import RobotConfig
from agentrob.sim.domains import PrivateDomain

PYTHON = Path(__file__).parents[3] / ".venv-ros2/bin/python"
LIMIT_S = 60.0
MOUNTED: dict[str, Any] = {"scan": {"mount_m": [0.0, 0.0]}}


class Peer:
    """The rclpy base on a domain of its own."""

    def __init__(self, *arguments: str) -> None:
        assert (PYTHON.parents[1] / ".stamp").exists(), "the peers are not installed; scripts/ros2-peers does"
        self.domain = PrivateDomain()
        self._process = subprocess.Popen(
            [PYTHON, Path(__file__).with_name("peer_base.py"), *arguments],
            env={**os.environ, "ROS_DOMAIN_ID": str(self.domain.number)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._line()["ready"]

    def _line(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        facts: dict[str, Any] = json.loads(self._process.stdout.readline())
        return facts

    def ask(self, **what: Any) -> dict[str, Any]:
        """Change something, or nothing; returns the truth (see `Simulation.apply`)."""
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(what) + "\n")
        self._process.stdin.flush()
        return self._line()

    def settings(self, **options: Any) -> RobotConfig:
        return RobotConfig(
            model="ros2", domain=self.domain.number, simulated=True, home_on_start=True, options={**MOUNTED, **options}
        )

    def kill(self) -> None:
        self._process.kill()
        self._process.wait(LIMIT_S)

    def close(self) -> None:
        self._process.terminate()
        self._process.communicate(timeout=LIMIT_S)
        self.domain.close()
