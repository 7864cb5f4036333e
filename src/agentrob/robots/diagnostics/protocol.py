"""The protocol of a robot's class that can be examined by `agentrob doctor` while no driver holds the robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from agentrob.config.robots import RobotConfig
from agentrob.robots.diagnostics.findings import Finding


@runtime_checkable
class Examinable(Protocol):
    """A class of robots that knows what it needs. The class itself is asked, and no robot is constructed."""

    def examine(self, settings: RobotConfig) -> Sequence[Finding]:
        """Return findings in the order in which to mend them. Only reads, never moves anything. Called once in a
        process; takes some seconds at most."""
        ...
