"""Fixtures: a simulated arm on a domain of its own, and the robot that moves it."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from agentrob_so101.arm import So101
from so101_world import LIMIT_S, WorldProcess, until

from agentrob.model import ActionResult, Primitive
from agentrob.robots.protocol import Watch
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt


@pytest.fixture(scope="module")
def process(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WorldProcess]:
    running = WorldProcess(tmp_path_factory.mktemp("world"))
    yield running
    running.close()


@pytest.fixture
def world(process: WorldProcess) -> WorldProcess:
    """The world as it is at its start, without faults."""
    process.reset()
    return process


class PatientArm(So101):
    """On a busy machine nothing may come for half a second, which ends a step as it should; then it begins again."""

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        end_s = time.monotonic() + LIMIT_S
        while (result := super().step(primitive, watch)).reason == "stale_state" and time.monotonic() < end_s:
            until(lambda: self.state().age_s < 0.1, "a fresh state")
        return result


@pytest.fixture
def patient(world: WorldProcess) -> Iterator[PatientArm]:
    arm = PatientArm(world.settings())
    yield arm
    arm.close()


@pytest.fixture
def robot(world: WorldProcess) -> Iterator[So101]:
    arm = So101(world.settings())
    yield arm
    arm.close()


@pytest.fixture
def guard(robot: So101, world: WorldProcess, tmp_path: Path) -> Iterator[Guard]:
    """The guard around the robot, as its driver has it."""
    guarded = Guard(robot, world.settings(), Halt(tmp_path / "halt"))
    yield guarded
    guarded.close()
