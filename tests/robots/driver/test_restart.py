"""A driver that was killed during a step, and its successor: what still moves is its own motion, for a moment (law
12)."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from agentrob.config.robots import RobotConfig
from agentrob.model import Op, RobotState
from agentrob.robots.contract import go_on
from agentrob.robots.control.controller import Velocity
from agentrob.robots.fake import FakeRobot
from agentrob.robots.safety.crash_marker import COUNTS_S, CrashMarker, InterruptedStep
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt
from agentrob.robots.safety.takeover import DECAY_S, TakeoverDetector
from tests.robots.driver_scene import FAR, NEAR, Drivers, moving
from tests.robots.guard_scene import ExternalController
from tests.waiting import wait_for

SETTINGS = RobotConfig(model="fake", simulated=True, home_on_start=True)
#: Its walk takes longer to fade than the time after which motion counts as a takeover.
SLOW = SETTINGS.model_copy(update={"options": {"faults": {"stop_s": 0.8}}})
Restart = Callable[[FakeRobot], Guard]


def leave_marker(path: Path, op: Op = Op.MOVE, mode: str = "walking") -> CrashMarker:
    """Return what a process that was killed during a step leaves on disk."""
    mark = CrashMarker(path)
    mark.begin(op, mode)
    return mark


@pytest.fixture
def restart(tmp_path: Path) -> Iterator[Restart]:
    """Return the guard of a new driver around a robot in its current state."""
    made: list[Guard] = []

    def restart(robot: FakeRobot) -> Guard:
        made.append(Guard(robot, SETTINGS, Halt(tmp_path / "fake.halt"), CrashMarker(tmp_path / "fake.step")))
        return made[-1]

    yield restart
    for guard in made:
        guard.close()


def speed(robot: FakeRobot) -> float:
    return abs((robot.state().velocity_mps or (0.0, 0.0))[0])


# ------------------------------------------------------------------ the guard after it
def test_law_12_a_walk_that_a_killed_driver_left_behind_is_stopped_and_is_no_halt(
    restart: Restart, tmp_path: Path
) -> None:
    robot = FakeRobot(SLOW)
    leave_marker(tmp_path / "fake.step")
    robot.command(Velocity(0.5))  # held for a second
    wait_for(lambda: speed(robot) > 0.4)
    guard = restart(robot)
    guard.settle()
    assert speed(robot) < 0.05
    wait_for(lambda: guard.state().homed)
    assert not guard.state().halted
    assert not (tmp_path / "fake.step").exists()
    robot.faults.stop_s = 0.15
    assert guard.step(NEAR, go_on).ok


def test_law_12_without_a_mark_the_same_walk_is_a_foreign_hand(restart: Restart) -> None:
    robot = FakeRobot(SLOW)
    robot.command(Velocity(0.5))
    wait_for(lambda: speed(robot) > 0.4)
    guard = restart(robot)
    guard.settle()
    wait_for(lambda: guard.state().halted)


@pytest.mark.parametrize("settles", [True, False])
def test_law_12_a_motion_that_does_not_die_down_is_a_halt_also_after_a_death(
    restart: Restart, tmp_path: Path, settles: bool
) -> None:
    robot = FakeRobot(SETTINGS)
    leave_marker(tmp_path / "fake.step")
    with ExternalController(robot):
        wait_for(lambda: speed(robot) > 0.4)
        guard = restart(robot)
        if settles:
            guard.settle()
        wait_for(lambda: guard.state().halted, limit_s=DECAY_S + 3.0)
    assert "did not command" in guard.step(NEAR, go_on).message


@pytest.mark.parametrize("mode", ["damping", "locked", "lying", "sitting"])
def test_law_12_a_mode_that_the_step_does_not_lead_to_is_a_halt_also_after_a_death(
    restart: Restart, tmp_path: Path, mode: str
) -> None:
    robot = FakeRobot(SETTINGS)
    leave_marker(tmp_path / "fake.step")
    robot.faults.mode = mode  # before the new driver has read any state
    guard = restart(robot)
    guard.settle()
    wait_for(lambda: guard.state().halted)
    assert mode in guard.step(NEAR, go_on).message


@pytest.mark.parametrize(
    ("op", "before", "after", "foreign"),
    [
        (Op.HELLO, "idle", "gesture", False),
        (Op.SIT, "gesture", "sitting", False),
        (Op.STAND, "sitting", "locked", False),
        (Op.MOVE, "locked", "walking", False),
        (Op.MOVE, "locked", "locked", False),
        (Op.HELLO, "gesture", "sitting", True),
        (Op.HELLO, "gesture", "lying", True),
        (Op.SIT, "gesture", "damping", True),
        (Op.MOVE, "walking", "gesture", True),
    ],
)
def test_law_12_only_what_the_step_leads_to_is_taken_for_ours(op: Op, before: str, after: str, foreign: bool) -> None:
    detector = TakeoverDetector()
    detector.inherit(0.0, op, before)
    found = detector.update(0.1, RobotState(age_s=0.0, mode=after), walking=False, gesturing=False)
    assert (found is not None) is foreign


# ------------------------------------------------------------------ the mark
def test_a_mark_is_there_while_a_step_runs_and_no_longer(tmp_path: Path) -> None:
    robot, mark = FakeRobot(SETTINGS), CrashMarker(tmp_path / "drivers" / "fake.step")
    guard = Guard(robot, SETTINGS, Halt(tmp_path / "fake.halt"), mark)
    wait_for(lambda: guard.state().homed)
    seen: list[InterruptedStep | None] = []
    try:
        assert guard.step(NEAR, lambda _: seen.append(CrashMarker(mark.path).interrupted_step())).ok
    finally:
        guard.close()
    assert seen[0] == InterruptedStep(Op.MOVE, "idle")
    assert seen[-1] is not None
    assert seen[-1].mode in ("walking", "idle")
    assert InterruptedStep(Op.MOVE, "walking") in seen  # it is renewed
    assert mark.path is not None
    assert not mark.path.exists()


@pytest.mark.parametrize(
    "changed",
    [
        {"alive_s": -COUNTS_S - 1.0},
        {"alive_s": 3600.0},
        {"alive_s": "soon"},
        {"boot": "another"},
        {"op": "Dance!"},
        {"mode": None, "op": None},
        None,
    ],
)
def test_law_12_a_mark_that_is_old_or_makes_no_sense_does_not_count(tmp_path: Path, changed: dict[str, Any]) -> None:
    path = tmp_path / "fake.step"
    leave_marker(path)
    record = json.loads(path.read_text())
    assert CrashMarker(path).interrupted_step() is not None
    if changed is None:
        path.write_text("")
    else:
        if isinstance(seconds := changed.get("alive_s"), float):
            changed = {"alive_s": time.monotonic() + seconds}
        path.write_text(json.dumps(record | changed))
    assert CrashMarker(path).interrupted_step() is None


def test_a_disk_that_refuses_the_mark_does_not_hold_up_a_step(tmp_path: Path) -> None:
    (tmp_path / "a file").write_text("not a folder")
    robot = FakeRobot(SETTINGS)
    guard = Guard(robot, SETTINGS, Halt(tmp_path / "fake.halt"), CrashMarker(tmp_path / "a file" / "fake.step"))
    wait_for(lambda: guard.state().homed)
    try:
        assert guard.step(NEAR, go_on).ok
    finally:
        guard.close()


# ------------------------------------------------------------------ real processes
async def test_law_12_a_driver_that_follows_a_killed_one_moves_its_robot_without_a_release(drivers: Drivers) -> None:
    name, process = drivers.start()
    mark = drivers.folder / "drivers" / f"{name}.step"
    async with drivers.client(name) as robot:
        async with robot.lease("walker") as lease:
            step = asyncio.create_task(robot.step(lease, FAR, 60))
            await moving(robot)
            process.kill()
            await asyncio.gather(step, return_exceptions=True)
        process.communicate()
        left = CrashMarker(mark).interrupted_step()
        assert left is not None
        assert left.op == Op.MOVE
        _, successor = drivers.start(name)
        assert not mark.exists()
        assert not (await robot.state()).halted
        async with robot.lease("walker") as lease:
            assert (await robot.step(lease, NEAR, 10)).ok
        successor.terminate()
        assert "died during move" in successor.communicate()[1]
