"""A Reachy Mini keeps the contract that every robot keeps, on the simulated daemon that the package ships."""

from __future__ import annotations

from agentrob.robots.contract import RobotContract


class TestReachyMini(RobotContract):
    """Over HTTP, as with its own daemon."""
