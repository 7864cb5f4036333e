"""Guarded fake robots for tests: steps, polling, and a second controller outside the guard."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace

import pytest

from agentrob.errors import RobotError
from agentrob.model import Direction, Op, Primitive
from agentrob.robots.control.controller import Velocity
from agentrob.robots.fake import FakeRobot
from agentrob.robots.safety.guard import Guard

F, B, L, R = Direction
Make = Callable[..., Guard]
#: The polling interval: tests get no notification of state changes.
LOOK_S = 0.01


def fake_of(guard: Guard) -> FakeRobot:
    robot = guard._robot
    assert isinstance(robot, FakeRobot)
    return robot


def age_states(guard: Guard, monkeypatch: pytest.MonkeyPatch, age_s: float) -> None:
    """Let every state be this old from now on."""
    seen = fake_of(guard)._seen
    monkeypatch.setattr(fake_of(guard), "_seen", lambda: replace(seen(), age_s=age_s))


def move(distance_m: float, direction: Direction = F, speed_mps: float | None = None) -> Primitive:
    return Primitive(Op.MOVE, direction, distance_m=distance_m, speed_mps=speed_mps)


def turn(degrees: float, direction: Direction = L) -> Primitive:
    return Primitive(Op.TURN, direction, degrees=degrees)


def can_set_home(guard: Guard) -> bool:
    try:
        guard.home("owner")
    except RobotError:
        return False
    return True


class ExternalController:
    """Let another controller drive the robot past every guard until the context ends."""

    def __init__(self, robot: FakeRobot) -> None:
        self._robot, self._ended = robot, threading.Event()
        self._thread = threading.Thread(target=self._push)

    def _push(self) -> None:
        while not self._ended.wait(0.02):
            self._robot.command(Velocity(0.5))

    def __enter__(self) -> None:
        self._thread.start()

    def __exit__(self, *_: object) -> None:
        self._ended.set()
        self._thread.join()
