"""Run the arm's world in a process of its own, change it and ask what is true there; for tests and benchmarks."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from agentrob_so101.operations import HOME_POSE
from agentrob_so101.pose import ArmPose, action_of
from agentrob_so101.simulated import Channel, address
from agentrob_so101.world import CUBE_AT_M, Faults

from agentrob.config.robots import RobotConfig
from agentrob.process.child import Child, terminate_all
from agentrob.sim.domains import PrivateDomain

LIMIT_S = 60.0


class WorldProcess:
    """`agentrob simulator so101` on a domain of its own."""

    def __init__(self, folder: Path, **env: str) -> None:
        self.domain = PrivateDomain()
        arguments = ["simulator", "so101", "--domain", str(self.domain.number)]
        self._process = Child("simulator", arguments, folder / "simulator.log", env)
        self._process.wait_ready(LIMIT_S)
        self._channel = Channel(address("lo", self.domain.number), LIMIT_S)

    def settings(self, **options: Any) -> RobotConfig:
        return RobotConfig(
            model="so101", domain=self.domain.number, simulated=True, home_on_start=True, options=options
        )

    def apply(self, **what: Any) -> dict[str, Any]:
        """See `agentrob_so101.world.World.apply`."""
        return self._channel.ask(do="apply", what=what)

    def reset(self) -> None:
        """Remove the faults, and put arm and cube where they are at the start."""
        self.apply(**asdict(Faults()), put=action_of(HOME_POSE), cube=[*CUBE_AT_M, 0.0])

    def pose(self) -> ArmPose:
        return ArmPose(*self.apply()["pose"])

    def goal(self) -> ArmPose:
        return ArmPose(*self.apply()["goal"])

    def close(self) -> None:
        self._channel.close()
        terminate_all([self._process])
        self.domain.close()


def until(condition: Callable[[], Any], what: str) -> None:
    end_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < end_s, f"not within {LIMIT_S:.0f} s: {what}"
        time.sleep(0.01)
