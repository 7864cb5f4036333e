"""Where exactly the guard refuses a step or ends it: the age of the robot's state, and the time that is left."""

from __future__ import annotations

import math
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from agentrob.config.robots import FenceConfig, RobotConfig
from agentrob.errors import RobotError
from agentrob.model import Op, Outcome, Pose, Primitive, RobotState
from agentrob.robots.contract import go_on
from agentrob.robots.fake import FakeRobot
from agentrob.robots.safety.crash_marker import CrashMarker, InterruptedStep
from agentrob.robots.safety.fence import Fence
from agentrob.robots.safety.guard import Guard, SimulatedTime
from agentrob.robots.safety.lock import Halt
from tests.robots.guard_scene import ExternalController, Make, age_states, can_set_home, fake_of, move, turn
from tests.waiting import wait_for

#: Needs no range readings, which an old state does not bring.
HELLO = Primitive(Op.HELLO)


@pytest.fixture
def guard(make: Make, monkeypatch: pytest.MonkeyPatch) -> Guard:
    """A guard that is homed and does not wait for readings that will not come."""
    monkeypatch.setattr("agentrob.robots.safety.guard.PREPARE_S", 0.1)
    made = make()
    wait_for(lambda: made.state().homed)
    return made


@pytest.mark.parametrize(("age_s", "done"), [(0.49, True), (0.5, False)])
def test_law_8_a_step_begins_only_with_a_state_younger_than_half_a_second(
    guard: Guard, monkeypatch: pytest.MonkeyPatch, age_s: float, done: bool
) -> None:
    age_states(guard, monkeypatch, age_s)
    result = guard.step(HELLO, go_on)
    assert result.ok is done, result.message
    if not done:
        assert (result.outcome, result.reason) == (Outcome.REFUSED, "stale_state")
        assert result.message == "The robot's state is 0.5 s old; it must be younger than 0.5 s."


@pytest.mark.parametrize(("age_s", "done"), [(0.49, True), (0.5, False)])
def test_law_8_a_state_that_becomes_half_a_second_old_ends_the_step(
    guard: Guard, monkeypatch: pytest.MonkeyPatch, age_s: float, done: bool
) -> None:
    def watch(_: RobotState) -> None:
        age_states(guard, monkeypatch, age_s)

    result = guard.step(HELLO, watch)
    assert result.ok is done, result.message
    if not done:
        assert (result.outcome, result.reason) == (Outcome.STOPPED, "stale_state")
        assert "The robot's state was 0.5 s old." in result.message


def test_law_8_states_that_come_too_seldom_tell_nothing_about_free_space(
    guard: Guard, monkeypatch: pytest.MonkeyPatch
) -> None:
    age_states(guard, monkeypatch, 0.3)
    wait_for(lambda: not guard._ranges.enough)
    result = guard.step(move(0.3), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "stale_state")
    assert "comes too seldom" in result.message


def test_law_9_home_is_set_only_by_a_state_younger_than_half_a_second(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    guard = make()
    wait_for(lambda: guard.state().homed)
    age_states(guard, monkeypatch, 0.5)
    with pytest.raises(RobotError, match=r"is 0.5 s old; it must be younger than 0.5 s"):
        guard.home("owner")


@pytest.mark.parametrize(
    ("step", "deadline_s", "begins"),
    [
        (move(1.0), 2.0, False),
        (move(1.0), 2.5, True),
        (move(0.5, speed_mps=0.1), 5.0, False),
        (move(0.5, speed_mps=0.1), 6.0, True),
        (turn(90), 2.0, False),
        (turn(90), 2.5, True),
        (move(3.1, speed_mps=0.05), None, False),
        (move(3.1, speed_mps=0.05), 100.0, False),
        (HELLO, 0.01, True),
    ],
)
def test_law_10_a_step_begins_only_if_it_may_end_in_time_and_within_the_limit_of_a_command(
    make: Make, step: Primitive, deadline_s: float | None, begins: bool
) -> None:
    guard = make()
    result = guard.step(step, go_on, deadline_s)
    assert (result.outcome is not Outcome.REFUSED) is begins, result.message
    assert begins or result.reason == "deadline"


def test_law_10_a_turn_needs_no_time_for_a_distance(make: Make) -> None:
    guard = make()
    needed_s = 90 / guard.capabilities.limits.turn_dps
    assert guard.step(turn(90), go_on, needed_s).outcome is Outcome.REFUSED
    assert guard.step(turn(90), go_on, needed_s + 0.01).outcome is not Outcome.REFUSED


def test_what_the_robot_cannot_do_is_refused_with_what_it_can(make: Make) -> None:
    guard = make()
    guard.capabilities = replace(guard.capabilities, ops=frozenset({Op.MOVE, Op.HELLO}))
    result = guard.step(Primitive(Op.SIT), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "unsupported")
    assert result.message == "This robot cannot sit; it can: hello, move."


def test_a_robot_without_a_camera_is_not_looked_through(make: Make) -> None:
    guard = make()
    assert guard.look()
    guard.capabilities = replace(guard.capabilities, ops=frozenset({Op.MOVE}))
    with pytest.raises(RobotError, match="no camera"):
        guard.look()


def test_home_can_be_set_again_after_a_step(make: Make) -> None:
    guard = make()
    assert guard.step(move(0.3), go_on).ok
    wait_for(lambda: can_set_home(guard))
    at_home = guard.posture().pose
    assert at_home is not None
    assert (at_home.x_m, at_home.y_m) == pytest.approx((0.0, 0.0), abs=0.01)


def test_law_12_a_mode_right_after_our_own_stop_is_no_takeover(make: Make) -> None:
    guard = make()
    wait_for(lambda: guard.state().homed and guard._takeover._mode != "")
    guard.stop()
    fake_of(guard).faults.mode = "locked"
    wait_for(lambda: guard._takeover._mode == "locked")
    assert not guard.state().halted


def test_law_9_without_a_position_no_home_is_set_and_the_reason_is_told(make: Make) -> None:
    guard = make(home_on_start=False)
    fake_of(guard).carry(Pose(math.nan, 0.0, 0.0))
    with pytest.raises(RobotError, match="cannot set home: The robot tells no position"):
        guard.home("owner")


def test_a_closed_guard_closes_its_robot(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    guard, closed = make(), list[bool]()
    monkeypatch.setattr(fake_of(guard), "close", lambda: closed.append(True))
    guard.close()
    assert closed == [True]


def test_law_9_no_home_is_set_while_somebody_moves_the_robot(make: Make) -> None:
    guard = make({"time_scale": 1}, home_on_start=False)
    with ExternalController(fake_of(guard)):
        wait_for(lambda: (guard.state().velocity_mps or (0.0, 0.0))[0] > 0.3)
        with pytest.raises(RobotError, match="while the robot moves"):
            guard.home("owner")


def test_law_9_no_home_is_set_during_a_gesture_even_if_the_body_stays_in_its_place(make: Make) -> None:
    guard, refusals = make(home_on_start=False), list[str]()
    wait_for(lambda: can_set_home(guard))  # it has been still for a while
    home = guard.home("owner")
    assert home == guard.state().pose

    def set_home(_: object) -> None:
        with pytest.raises(RobotError) as error:
            guard.home("owner")
        refusals.append(str(error.value))

    assert guard.step(HELLO, set_home).ok
    assert refusals
    assert all("while the robot moves" in refusal for refusal in refusals)


def test_law_17_a_release_returns_the_lock_that_it_removed(make: Make) -> None:
    guard = make()
    guard.halt("bob", "smoke")
    removed = guard.release("owner")
    assert removed is not None
    assert (removed.by, removed.why) == ("bob", "smoke")
    assert guard.release("owner") is None


def test_law_17_a_halt_that_cannot_be_removed_from_the_disk_stays(make: Make, tmp_path: Path) -> None:
    (tmp_path / "fake.halt").mkdir()
    guard = make()
    with pytest.raises(RobotError, match=r"the halt stays: .*fake.halt cannot be removed"):
        guard.release("owner")
    assert guard.step(move(0.3), go_on).reason == "halted"


def test_law_12_a_step_is_marked_on_the_disk_while_it_runs(tmp_path: Path) -> None:
    settings = RobotConfig(model="fake", simulated=True, home_on_start=True, options={"time_scale": math.inf})
    path, marked = tmp_path / "fake.step", list[InterruptedStep | None]()
    guard = Guard(FakeRobot(settings), settings, Halt(tmp_path / "fake.halt"), CrashMarker(path))
    try:
        result = guard.step(move(0.3), lambda _: marked.append(CrashMarker(path).interrupted_step()))
        assert result.ok, result.message
        assert {mark.op for mark in marked if mark is not None} == {Op.MOVE}
        assert None not in marked
        assert not path.exists()
    finally:
        guard.close()


def test_law_8_a_step_that_sees_its_way_does_not_say_that_it_did_not(make: Make) -> None:
    result = make().step(move(0.3), go_on)
    assert result.ok
    assert "range" not in result.message


@pytest.mark.parametrize(("asked_mps", "at_most_mps"), [(0.1, 0.1), (0.3, 0.2), (None, 0.2)])
def test_law_8_a_step_without_readings_is_no_faster_than_it_was_asked_for(
    make: Make, asked_mps: float | None, at_most_mps: float
) -> None:
    guard = make({"faults": {"ranges": "missing"}}, allow_unknown_ranges=True)
    assert guard.step(move(0.3, speed_mps=asked_mps), go_on).ok
    assert fake_of(guard).commanded.forward_mps == pytest.approx(at_most_mps)


def test_the_pose_of_a_posture_is_in_the_frame_of_home_and_unknown_without_one(
    make: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert make(home_on_start=False).posture().pose is None
    settings = RobotConfig(model="fake", simulated=True, options={"time_scale": math.inf})
    robot = FakeRobot(settings)
    time = SimulatedTime(robot.now_s, lambda seconds: robot.wait_until(robot.now_s() + seconds))
    guard = Guard(robot, settings, Halt(tmp_path / "homed.halt"), simulated_time=time, home=Pose(3.0, 4.0, 0.5))
    robot.carry(Pose(3.0, 5.0, 0.5))
    pose = guard.posture().pose
    assert pose is not None
    assert (pose.x_m, pose.y_m, pose.yaw_rad) == pytest.approx((math.sin(0.5), math.cos(0.5), 0.0))
    seen = robot._seen
    monkeypatch.setattr(robot, "_seen", lambda: replace(seen(), pose=None))
    assert guard.posture().pose is None


@pytest.mark.parametrize(
    ("simulated", "home_on_start", "warned"), [(True, True, False), (False, True, True), (False, False, False)]
)
def test_law_9_the_log_says_that_home_on_start_does_not_home_a_real_robot(
    make: Make, caplog: pytest.LogCaptureFixture, simulated: bool, home_on_start: bool, warned: bool
) -> None:
    make(simulated=simulated, home_on_start=home_on_start)
    assert ("home_on_start homes simulated robots only" in caplog.text) is warned


def test_the_observer_of_a_guard_is_a_daemon_thread_that_ends_when_it_is_closed(make: Make) -> None:
    before = set(threading.enumerate())
    guard = make()
    (observer,) = (t for t in set(threading.enumerate()) - before if t.name == "guard-observer")
    assert observer.daemon
    guard.close()
    observer.join(60)
    assert not observer.is_alive()


def test_law_8_a_step_is_refused_while_a_fresh_state_has_no_position(
    guard: Guard, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = fake_of(guard)._seen
    monkeypatch.setattr(fake_of(guard), "_seen", lambda: replace(seen(), pose=None))
    result = guard.step(HELLO, go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "stale_state")
    assert result.message == "The robot tells no position: its odometry is missing or not a number."


def test_law_9_a_simulated_robot_that_lost_its_home_is_refused_without_a_word_on_real_ones(
    guard: Guard, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(RobotConfig, "homes_itself", False)  # as before it stands still long enough
    monkeypatch.setattr(guard, "_fence", None)
    result = guard.step(HELLO, go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "not_homed")
    assert result.message == "The robot has no home, so its fence is unknown; its owner must set home first."


def test_law_18_a_step_whose_state_was_lost_for_a_moment_is_not_measured(
    guard: Guard, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot, lost = fake_of(guard), threading.Event()
    seen, rest = robot._seen, robot.rest

    def come_to_rest() -> None:
        lost.clear()
        rest()

    monkeypatch.setattr(robot, "_seen", lambda: replace(seen(), age_s=1.0) if lost.is_set() else seen())
    monkeypatch.setattr(robot, "rest", come_to_rest)
    result = guard.step(move(0.3), lambda state: lost.set() if state.pose.x_m > 0.1 else None)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stale_state")
    assert guard.state().age_s < 0.5, "its state has come again"
    assert not result.measured


@pytest.mark.parametrize("tells_speed", [True, False])
def test_law_8_a_walk_that_nears_the_fence_ends_so_that_the_robot_rests_inside(
    make: Make, monkeypatch: pytest.MonkeyPatch, tells_speed: bool
) -> None:
    guard = make()
    wait_for(lambda: guard.state().homed)
    robot, edge_m = fake_of(guard), 0.6
    seen = robot._seen
    if not tells_speed:  # then it counts as fast as it was asked to go
        monkeypatch.setattr(robot, "_seen", lambda: replace(seen(), velocity_mps=None))

    def narrow(state: RobotState) -> None:
        if state.pose.x_m > 0.3:  # on the way, since a step that leads out of the fence is never begun
            guard._fence = Fence(FenceConfig(x_min_m=-1, x_max_m=edge_m, y_min_m=-1, y_max_m=1), Pose(0, 0, 0))

    result = guard.step(move(1.0, speed_mps=0.5), narrow)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "fence")
    assert 0.3 < robot.pose.x_m <= edge_m


def test_a_turn_beside_the_fence_is_done(make: Make) -> None:
    guard = make(fence={"x_min_m": -0.2, "x_max_m": 0.2, "y_min_m": -0.2, "y_max_m": 0.2})
    assert guard.step(turn(30), go_on).ok


def test_a_walk_is_not_ended_because_it_is_measured_faster_than_its_limit(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    guard = make(fence={"x_min_m": -9, "x_max_m": 9, "y_min_m": -9, "y_max_m": 9})
    wait_for(lambda: guard.state().homed)
    seen = fake_of(guard)._seen
    monkeypatch.setattr(fake_of(guard), "_seen", lambda: replace(seen(), velocity_mps=(1.0, 0.0)))
    assert guard.step(move(0.3), go_on).reason != "limit_speed_mps"
