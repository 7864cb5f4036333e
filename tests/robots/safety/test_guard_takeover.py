"""Laws 9 and 12: an invalid home, and another controller that moves the robot."""

from __future__ import annotations

import math

import pytest

from agentrob.model import Op, Outcome, Pose, Primitive, RobotState
from agentrob.robots.contract import go_on
from agentrob.robots.control.odometry import OdometryMonitor
from agentrob.robots.safety.takeover import TakeoverDetector
from tests.robots.guard_scene import ExternalController, Make, can_set_home, fake_of, move, turn
from tests.waiting import wait_for


def test_law_9_a_jump_at_rest_voids_home_and_only_a_simulation_homes_itself_again(make: Make) -> None:
    for simulated in (True, False):
        guard = make(simulated=simulated)
        wait_for(lambda guard=guard: can_set_home(guard))
        fake_of(guard).carry(Pose(3.0, 1.0, 1.0))
        wait_for(lambda guard=guard: not guard.state().homed or guard._fence.home.x_m > 2)
        if simulated:
            wait_for(lambda guard=guard: guard.state().homed)
            assert guard.step(move(0.3), go_on).ok
        else:
            assert guard.step(move(0.3), go_on).reason == "not_homed"


@pytest.mark.parametrize(("silent_s", "void"), [(5, False), (9, False), (11, True), (15, True), (19, True), (60, True)])
def test_law_9_a_silence_in_which_a_robot_may_restart_voids_home(silent_s: float, void: bool) -> None:
    odometry, here = OdometryMonitor(), Pose(0.0, 0.0, 0.0)
    reasons = list[str]()
    for i in range(20 * (int(silent_s) + 2)):  # polled 20 times a second all the time
        now_s = i / 20
        age_s = now_s % silent_s  # the first state at 0, the next after the silence, at the same position
        if why := odometry.update(now_s, RobotState(age_s=age_s, pose=here)):
            reasons.append(why)
    assert bool(reasons) is void
    assert not void or "restarted" in reasons[0]


def test_law_12_a_mode_that_we_did_not_command_is_a_halt(make: Make) -> None:
    guard = make()
    assert guard.step(move(0.3), go_on).ok
    wait_for(lambda: guard._takeover._mode == "idle")
    with guard._looking:  # the observer must not be processing an earlier state
        guard._takeover._ours_until_s = 0.0  # the last step of this driver is long ago
    fake_of(guard).faults.mode = "locked"
    wait_for(lambda: guard.state().halted)
    fake_of(guard).faults.mode = ""
    result = guard.step(move(0.3), go_on)
    assert result.reason == "halted"
    assert "locked" in result.message
    wait_for(guard._halt.path.exists)  # a release while the lock is being written would leave the robot locked
    guard.release("owner")
    assert guard.step(move(0.3), go_on).ok


def test_law_12_the_robot_is_locked_before_it_is_stopped_and_the_lock_is_written_down(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    guard = make()
    wait_for(lambda: guard._takeover._mode == "idle")
    monkeypatch.setattr(guard, "halt", lambda *_: None)  # as if the stop, or the disk, took long
    fake_of(guard).faults.mode = "damping"
    wait_for(lambda: guard.state().halted)


def test_law_12_a_takeover_does_not_change_who_locked_the_robot(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    guard = make()
    wait_for(lambda: guard._takeover._mode == "idle")
    guard.halt("bob", "smoke")
    seen, update = list[str](), guard._takeover.update

    def noted(now_s: float, state: RobotState, **ours: bool) -> str | None:
        seen.append(state.mode)
        return update(now_s, state, **ours)

    monkeypatch.setattr(guard._takeover, "update", noted)
    fake_of(guard).faults.mode = "damping"
    wait_for(lambda: seen.count("damping") > 2)  # then the guard has done what it does about the first of them
    lock = guard.state().lock
    assert lock is not None
    assert (lock.by, lock.why) == ("bob", "smoke")


def test_law_12_damping_during_a_gesture_is_a_halt(make: Make) -> None:
    guard = make({"time_scale": 1})
    wait_for(lambda: guard.state().homed)

    def damp(_: RobotState) -> str | None:
        fake_of(guard).faults.mode = "damping"
        return None

    result = guard.step(Primitive(Op.HELLO), damp)
    assert result.outcome is Outcome.STOPPED
    assert result.reason in ("halted", "stop")  # whether the step or the observer saw it first
    assert guard.state().halted
    assert "damping" in guard.step(move(0.3), go_on).message


def test_law_12_damping_right_after_our_own_step_is_a_halt(make: Make) -> None:
    guard = make()
    assert guard.step(move(0.3), go_on).ok
    fake_of(guard).faults.mode = "damping"
    wait_for(lambda: guard.state().halted)
    fake_of(guard).faults.mode = ""
    assert guard.step(move(0.3), go_on).reason == "halted"


@pytest.mark.parametrize("primitive", [move(0.3), turn(30), Primitive(Op.STAND)])
def test_law_12_a_robot_that_was_damped_before_we_came_is_not_moved(make: Make, primitive: Primitive) -> None:
    guard = make({"faults": {"mode": "damping"}})
    result = guard.step(primitive, go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "posture")
    assert not guard.state().halted
    assert fake_of(guard).commanded == (0, 0, 0)
    fake_of(guard).faults.mode = ""  # another controller made it stand up
    assert guard.step(primitive, go_on).ok


@pytest.mark.parametrize("mode", ["locked", "damping"])
def test_a_mode_that_is_there_when_the_first_state_comes_is_nobodys_change(mode: str) -> None:
    detector = TakeoverDetector()
    for now_s, state in enumerate([RobotState(age_s=math.inf), RobotState(age_s=0.0, mode=mode)]):
        assert detector.update(now_s, state, walking=False, gesturing=False) is None


def test_law_12_a_robot_that_somebody_else_walks_is_halted(make: Make) -> None:
    guard = make({"time_scale": 1})
    wait_for(lambda: guard.state().homed)
    with ExternalController(fake_of(guard)):
        wait_for(lambda: guard.state().halted)
    assert "did not command" in guard.step(move(0.3), go_on).message
