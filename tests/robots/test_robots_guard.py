"""Laws 8, 9, 10 and 12: what the guard refuses, what it ends on the way, and what never happens whatever is asked."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agentrob.config import FenceConfig, RobotConfig
from agentrob.errors import RobotError
from agentrob.model import Direction, Op, Outcome, Pose, Primitive, RobotState
from agentrob.robots.contract import go_on
from agentrob.robots.fake import FakeRobot
from agentrob.robots.fence import Fence
from agentrob.robots.guard import Guard
from agentrob.robots.halt import Halt
from agentrob.robots.motion import known
from agentrob.robots.odometry import Hands, Odometry
from agentrob.robots.ranges import Ranges

F, B, L, R = Direction
Make = Callable[..., Guard]


def fake_of(guard: Guard) -> FakeRobot:
    robot = guard._robot
    assert isinstance(robot, FakeRobot)
    return robot


@pytest.fixture
def make(tmp_path: Path) -> Iterator[Make]:
    """Makes guarded fake robots that take no time; keywords are settings and, as `options`, the fake's."""
    made: list[Guard] = []

    def make(options: dict[str, Any] | None = None, **changed: Any) -> Guard:
        given: dict[str, Any] = {"model": "fake", "simulated": True, "home_on_start": True, **changed}
        config = RobotConfig(options={"time_scale": math.inf, **(options or {})}, **given)
        guard = Guard(FakeRobot(config), config, Halt(tmp_path / "fake.halt"))
        made.append(guard)
        return guard

    yield make
    for guard in made:
        guard.close()


def move(distance_m: float, direction: Direction = F, speed_mps: float | None = None) -> Primitive:
    return Primitive(Op.MOVE, direction, distance_m=distance_m, speed_mps=speed_mps)


def turn(degrees: float, direction: Direction = L) -> Primitive:
    return Primitive(Op.TURN, direction, degrees=degrees)


def until(true: Callable[[], bool], limit_s: float = 10.0) -> None:
    """Wait for what must become true."""
    end_s = time.monotonic() + limit_s
    while not true():
        assert time.monotonic() < end_s, "it did not become true"
        time.sleep(0.01)


# ------------------------------------------------------------------ before a step
@pytest.mark.parametrize(
    ("primitive", "word", "number"),
    [
        (move(5.1), "limit_step_m", "5 m"),
        (move(1e9), "limit_step_m", "5 m"),
        (move(1.0, speed_mps=0.6), "limit_speed_mps", "0.5 m/s"),
        (turn(361), "limit_step_deg", "360°"),
        (move(0), "invalid", "0.01 m"),
        (move(-1), "invalid", "0.01 m"),
        (move(math.nan), "invalid", "0.01 m"),
        (move(5e-324), "invalid", "0.01 m"),
        (move(math.inf), "limit_step_m", "5 m"),
        (move(1.0, speed_mps=math.nan), "invalid", "0.05 m/s"),
        (move(1.0, speed_mps=0.0), "invalid", "0.05 m/s"),
        (move(1.0, speed_mps=1e-300), "invalid", "0.05 m/s"),
        (Primitive(Op.MOVE, F), "invalid", "0.01 m"),
        (Primitive(Op.MOVE, None, distance_m=1.0), "invalid", "0.01 m"),
        (Primitive(Op.TURN, F, degrees=90), "invalid", "left or right"),
        (turn(math.nan), "invalid", "1°"),
        (turn(-90), "invalid", "1°"),
        (move(4.95), "fence", "5 m"),
        (move(4.95, B), "fence", "-5"),
    ],
)
def test_law_10_beyond_a_limit_is_refused_with_the_limit_named(
    make: Make, primitive: Primitive, word: str, number: str
) -> None:
    guard = make()
    result = guard.step(primitive, go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, word)
    assert number in result.message
    assert fake_of(guard).commanded == (0, 0, 0)


@pytest.mark.parametrize(
    ("faults", "word"),
    [
        ({"stale": True}, "stale_state"),
        ({"fallen": True}, "fallen"),
        ({"ranges": "missing"}, "ranges_unknown"),
        ({"ranges": "zero"}, "ranges_unknown"),
        ({"ranges": "constant"}, "ranges_unknown"),
    ],
)
def test_law_8_a_robot_in_no_fit_state_is_not_moved(make: Make, faults: dict[str, Any], word: str) -> None:
    guard = make({"faults": faults})
    if word == "stale_state":
        guard.step(move(0.1), go_on)  # virtual time stands still between steps
        fake_of(guard).wait_until(fake_of(guard).now_s() + 1.0)
    result = guard.step(move(0.5), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, word)
    assert fake_of(guard).pose.x_m < 0.2


def test_law_8_unknown_ranges_need_consent_and_then_mean_slow_and_the_result_says_so(make: Make) -> None:
    guard = make({"faults": {"ranges": "missing"}}, allow_unknown_ranges=True)
    result = guard.step(move(0.5), go_on)
    assert result.outcome is Outcome.DONE, result.message
    assert result.primitive == move(0.5)
    assert "0.2 m/s" in result.message
    assert "unknown" in result.message
    assert guard.step(turn(30), go_on).ok
    forward, left, turning = fake_of(guard).commanded
    assert max(forward, left) <= 0.2 + 1e-9
    assert turning * 0.4 <= 0.2 + 1e-9


def test_law_8_an_obstacle_at_hand_refuses_what_goes_towards_it_only(make: Make) -> None:
    guard = make({"obstacles": [[0.9, 0.0, 0.3]]})
    result = guard.step(move(1.0), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "obstacle")
    assert "0.60 m ahead" in result.message
    assert guard.step(move(0.5, B), go_on).ok


def test_law_8_a_turn_needs_room_all_around(make: Make) -> None:
    guard = make({"room": [-3, 3, -0.3, 3]})
    result = guard.step(turn(90), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "obstacle")
    assert "to the right" in result.message


def test_law_9_no_home_no_motion(make: Make) -> None:
    guard = make(home_on_start=False)
    result = guard.step(move(0.5), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "not_homed")
    until(lambda: _homes(guard))
    assert guard.state().homed
    assert guard.step(move(0.5), go_on).ok


def _homes(guard: Guard) -> bool:
    try:
        guard.home("owner")
    except RobotError:
        return False
    return True


def test_a_real_robot_never_homes_itself(make: Make) -> None:
    guard = make(simulated=False)
    assert guard.step(move(0.5), go_on).reason == "not_homed"


def test_the_fence_lies_around_home_and_turns_with_it(make: Make) -> None:
    guard = make(fence=FenceConfig(x_min_m=-0.5, x_max_m=2, y_min_m=-0.5, y_max_m=0.5), home_on_start=False)
    fake_of(guard).carry(Pose(3.0, -2.0, math.pi / 2))
    until(lambda: _homes(guard))
    assert guard.step(move(1.8), go_on).ok
    assert fake_of(guard).pose.y_m == pytest.approx(-0.2, abs=0.05)
    refused = guard.step(move(0.5, L), go_on)
    assert refused.reason == "fence"
    assert "y 0.5" in refused.message


def test_a_step_that_cannot_end_in_time_is_not_begun(make: Make) -> None:
    guard = make()
    result = guard.step(move(2.0), go_on, deadline_s=3.0)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "deadline")
    assert "4.0 s" in result.message
    assert guard.step(move(0.5), go_on, deadline_s=-1.0).reason == "deadline"
    assert guard.step(move(0.5), go_on, deadline_s=math.nan).outcome is not Outcome.DONE


def test_law_10_a_flip_needs_the_owners_consent_on_a_real_robot(make: Make) -> None:
    flip = Primitive(Op.BACKFLIP)
    real = make(simulated=False)
    until(lambda: _homes(real))
    assert real.step(flip, go_on).reason == "consent"
    willing = make(simulated=False, allow_flip=True)
    until(lambda: _homes(willing))
    assert willing.step(flip, go_on).ok
    assert make().step(flip, go_on).ok


def test_looking_is_always_allowed(make: Make) -> None:
    guard = make({"faults": {"fallen": True}}, home_on_start=False)
    guard.halt("owner")
    assert guard.step(Primitive(Op.GET_FRONT_IMAGE), go_on).ok


# ------------------------------------------------------------------ on the way
@pytest.mark.parametrize(
    ("faults", "word"),
    [
        ({"stale": True, "after_m": 0.5}, "stale_state"),
        ({"fallen": True, "after_m": 0.5}, "fallen"),
        ({"jump_m": 1.0, "after_m": 0.5}, "odometry_jump"),
        ({"ranges": "zero", "after_m": 0.5}, "ranges_unknown"),
        ({"mode": "damping", "after_m": 0.5}, "halted"),
    ],
)
def test_law_8_trouble_on_the_way_ends_the_step(make: Make, faults: dict[str, Any], word: str) -> None:
    guard = make({"faults": faults})
    result = guard.step(move(2.0), go_on)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, word), result.message
    assert "measured" in result.message
    assert fake_of(guard).pose.x_m - (1.0 if faults.get("jump_m") else 0.0) < 1.2


def test_law_8_an_obstacle_on_the_way_ends_the_move_before_it(make: Make) -> None:
    guard = make({"obstacles": [[2.0, 0.0, 0.3]]})
    result = guard.step(move(2.0), go_on)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "obstacle")
    assert "ahead" in result.message
    assert 0.8 < result.measured["distance_m"] < 1.35


def test_the_deadline_ends_a_step(make: Make) -> None:
    guard = make({"time_scale": 1})
    began_s = time.monotonic()
    result = guard.step(move(0.2), go_on, deadline_s=0.5)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "deadline")
    assert time.monotonic() - began_s < 5.0


def test_a_robot_that_answers_but_does_not_move_has_failed(make: Make) -> None:
    guard = make({"faults": {"frozen": True}})
    result = guard.step(move(1.0), go_on)
    assert (result.outcome, result.reason) == (Outcome.FAILED, "stalled")
    assert "Asked 1 m, measured 0.00 m" in result.message


def test_lost_commands_do_not_spoil_a_step(make: Make) -> None:
    guard = make({"faults": {"drops": 0.3}})
    result = guard.step(move(1.0), go_on)
    assert result.ok, result.message


def test_a_stop_that_the_robot_does_not_follow_is_told(make: Make) -> None:
    guard = make({"faults": {"unconfirmed": True}, "time_scale": 10})
    moving = threading.Event()

    def watch(state: RobotState) -> str | None:
        if state.pose and state.pose.x_m > 0.2:
            moving.set()
        return None

    thread = threading.Thread(target=lambda: guard.step(move(3.0), watch))
    thread.start()
    assert moving.wait(5)
    stopped = guard.stop()
    thread.join(5)
    assert stopped.was_moving
    assert not stopped.confirmed
    assert stopped.coasted_m is None
    assert stopped.message


def test_two_steps_at_once_are_not_done(make: Make) -> None:
    guard = make({"time_scale": 1})
    inside = threading.Event()

    def watch(_: RobotState) -> str | None:
        inside.set()
        return None

    thread = threading.Thread(target=lambda: guard.step(move(1.0), watch))
    thread.start()
    assert inside.wait(5)
    assert guard.step(turn(10), go_on).reason == "busy"
    guard.stop()
    thread.join(5)


# ------------------------------------------------------------------ home and hands
def test_law_9_a_jump_at_rest_voids_home_and_only_a_simulation_homes_itself_again(make: Make) -> None:
    for simulated in (True, False):
        guard = make(simulated=simulated)
        until(lambda guard=guard: _homes(guard))
        fake_of(guard).carry(Pose(3.0, 1.0, 1.0))
        until(lambda guard=guard: not guard.state().homed or guard._fence.home.x_m > 2)
        if simulated:
            until(lambda guard=guard: guard.state().homed)
            assert guard.step(move(0.3), go_on).ok
        else:
            assert guard.step(move(0.3), go_on).reason == "not_homed"


@pytest.mark.parametrize(("silent_s", "void"), [(5, False), (9, False), (11, True), (15, True), (19, True), (60, True)])
def test_law_9_a_silence_in_which_a_robot_may_restart_voids_home(silent_s: float, void: bool) -> None:
    odometry, here = Odometry(), Pose(0.0, 0.0, 0.0)
    told = list[str]()
    for i in range(20 * (int(silent_s) + 2)):  # looked at 20 times a second, all the while
        now_s = i / 20
        age_s = now_s % silent_s  # the first state at 0, the next after the silence, at the very same place
        if why := odometry.see(now_s, RobotState(age_s=age_s, pose=here)):
            told.append(why)
    assert bool(told) is void
    assert not void or "restarted" in told[0]


def test_law_12_a_mode_that_we_did_not_command_is_a_halt(make: Make) -> None:
    guard = make()
    assert guard.step(move(0.3), go_on).ok
    guard._hands._ours_until_s = 0.0  # our own step is long ago
    until(lambda: guard._hands._mode == "idle")
    fake_of(guard).faults.mode = "locked"
    until(lambda: guard.state().halted)
    fake_of(guard).faults.mode = ""
    result = guard.step(move(0.3), go_on)
    assert result.reason == "halted"
    assert "locked" in result.message
    guard.release("owner")
    assert guard.step(move(0.3), go_on).ok


def test_law_12_damping_during_a_gesture_is_a_halt(make: Make) -> None:
    guard = make({"time_scale": 1})
    until(lambda: guard.state().homed)

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
    until(lambda: guard.state().halted)
    fake_of(guard).faults.mode = ""
    assert guard.step(move(0.3), go_on).reason == "halted"


@pytest.mark.parametrize("primitive", [move(0.3), turn(30), Primitive(Op.STAND)])
def test_law_12_a_robot_that_was_damped_before_we_came_is_not_moved(make: Make, primitive: Primitive) -> None:
    guard = make({"faults": {"mode": "damping"}})
    result = guard.step(primitive, go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "posture")
    assert not guard.state().halted
    assert fake_of(guard).commanded == (0, 0, 0)
    fake_of(guard).faults.mode = ""  # somebody made it stand up
    assert guard.step(primitive, go_on).ok


def test_a_mode_that_is_there_when_the_first_state_comes_is_nobodys_change() -> None:
    hands = Hands()
    for now_s, state in enumerate([RobotState(age_s=math.inf), RobotState(age_s=0.0, mode="locked")]):
        assert hands.see(now_s, state, walking=False, gesturing=False) is None


def test_law_14_a_stop_while_a_step_is_prepared_ends_it(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    guard = make()
    until(lambda: guard.state().homed)
    look, stops = fake_of(guard).state, list[bool]()

    def state() -> RobotState:
        if threading.current_thread() is threading.main_thread() and not stops:  # the step's first look
            stops.append(True)
            guard.stop()
        return look()

    monkeypatch.setattr(fake_of(guard), "state", state)
    result = guard.step(move(1.0), go_on)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stop")
    assert fake_of(guard).commanded == (0, 0, 0)
    assert guard.step(move(0.3), go_on).ok


def test_law_12_a_robot_that_somebody_else_walks_is_halted(make: Make) -> None:
    guard = make({"time_scale": 1})
    until(lambda: guard.state().homed)
    end_s = time.monotonic() + 10

    def drive() -> None:
        from agentrob.robots.motion import Velocity

        while time.monotonic() < end_s and not guard.state().halted:
            fake_of(guard).command(Velocity(0.5))
            time.sleep(0.05)

    drive()
    assert guard.state().halted
    assert "did not command" in guard.step(move(0.3), go_on).message


# ------------------------------------------------------------------ halt
def test_law_17_a_halt_lasts_across_restarts_until_released(make: Make) -> None:
    first = make()
    assert first.halt("owner", "smoke").confirmed
    second = make()
    result = second.step(move(0.3), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "halted")
    assert "smoke" in result.message
    second.release("owner")
    assert second.step(move(0.3), go_on).ok
    assert not make().state().halted


def test_a_halt_file_that_cannot_be_read_is_a_halt(tmp_path: Path) -> None:
    path = tmp_path / "fake.halt"
    for write in (lambda: path.write_text("{nonsense"), lambda: path.write_bytes(b"\xff\xfe"), path.mkdir):
        path.unlink(missing_ok=True)
        write()
        assert Halt(path).why is not None


def test_a_halt_that_the_disk_refuses_holds_while_the_process_lives_and_says_so(make: Make, tmp_path: Path) -> None:
    guard = make()
    guard._halt.path = tmp_path / "a file" / "x.halt"
    (tmp_path / "a file").write_text("not a folder")
    stopped = guard.halt("owner")
    assert "disk" in stopped.message
    assert guard.step(move(0.3), go_on).reason == "halted"


# ------------------------------------------------------------------ whatever is asked
steps = st.one_of(
    st.builds(
        move,
        st.one_of(st.floats(0.05, 6.0), st.floats(), st.just(0.3)),
        st.sampled_from(list(Direction)),
        st.one_of(st.none(), st.floats(0.05, 0.7), st.floats()),
    ),
    st.builds(turn, st.one_of(st.floats(5, 400), st.floats()), st.sampled_from([L, R])),
    st.sampled_from([Primitive(Op.HELLO), Primitive(Op.SIT), Primitive(Op.BACKFLIP)]),
)
FENCE = FenceConfig(x_min_m=-1.0, x_max_m=2.0, y_min_m=-1.5, y_max_m=1.2)


def test_whatever_is_asked_the_robot_stays_inside_its_fence_and_limits(make: Make) -> None:
    guard = make(fence=FENCE)
    until(lambda: guard.state().homed)
    robot, done = fake_of(guard), list[bool]()

    @settings(max_examples=60, deadline=None, database=None)
    @given(st.lists(steps, min_size=1, max_size=8))
    def property_holds(plan: list[Primitive]) -> None:
        for primitive in plan:
            result = guard.step(primitive, go_on)
            done.append(result.ok)
            assert result.outcome is not Outcome.REFUSED or not result.path
            for x, y in [point[1:3] for point in result.path] + [(robot.pose.x_m, robot.pose.y_m)]:
                assert FENCE.x_min_m <= x <= FENCE.x_max_m
                assert FENCE.y_min_m <= y <= FENCE.y_max_m
        assert math.hypot(*robot.commanded[:2]) <= 0.5 * math.sqrt(2) + 1e-9  # largest of each axis
        assert max(robot.commanded[:2]) <= 0.5 + 1e-9
        assert robot.commanded.turn_rps <= math.radians(45) + 1e-9

    property_holds()
    assert sum(done) > 20  # it was not idle


no_number = st.sampled_from([math.nan, math.inf, -math.inf])
number = st.one_of(st.floats(-2.0, 2.0), no_number)
#: Yaw is never infinite here: the fake's own arithmetic has no answer to that.
no_place = st.builds(Pose, number, number, st.floats(-3, 3) | st.just(math.nan)).filter(lambda p: known(p) is None)


@given(x=number, y=number, home=st.builds(Pose, number, number, st.floats(-3, 3)))
def test_law_9_a_point_that_is_no_number_is_outside_of_every_fence(x: float, y: float, home: Pose) -> None:
    if not all(map(math.isfinite, (x, y, home.x_m, home.y_m))):
        assert Fence(FENCE, home).outside_m(x, y) == math.inf
        assert Fence(FENCE, home).refusal(Pose(x, y, 0.0), turn(10)) is not None


def test_law_9_whatever_odometry_that_is_no_number_moves_nothing(make: Make) -> None:
    guard = make()
    until(lambda: guard.state().homed)
    robot, place = fake_of(guard), fake_of(guard).pose

    @settings(max_examples=40, deadline=None, database=None)
    @given(bad=no_place, primitive=st.sampled_from([move(1.0), move(1.0, B), turn(90), Primitive(Op.HELLO)]))
    def property_holds(bad: Pose, primitive: Primitive) -> None:
        robot.carry(bad)
        assert guard.state().pose is None
        result = guard.step(primitive, go_on)
        assert (result.outcome, result.reason) == (Outcome.REFUSED, "stale_state")
        with pytest.raises(RobotError):
            guard.home("owner")
        assert robot.commanded == (0, 0, 0)

    property_holds()
    robot.carry(place)
    assert guard.step(move(0.3), go_on).ok


@pytest.mark.parametrize("guarded", [True, False])
@pytest.mark.parametrize("bad", [Pose(math.nan, 0, 0), Pose(0, math.inf, 0), Pose(0.5, 0, math.nan)])
def test_law_9_odometry_that_becomes_no_number_on_the_way_ends_the_step(make: Make, bad: Pose, guarded: bool) -> None:
    guard = make()
    until(lambda: guard.state().homed)
    robot = fake_of(guard)

    def watch(state: RobotState) -> str | None:
        if state.pose and state.pose.x_m > 0.3:
            robot.carry(bad)
        return None

    result = (guard if guarded else robot).step(move(2.0), watch)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stale_state")
    assert all(map(math.isfinite, (*result.measured.values(), *(v for point in result.path for v in point))))
    assert 0.15 < result.measured["distance_m"] < 0.6  # averaged over its last moments


def test_whatever_is_asked_the_robot_keeps_off_the_walls(make: Make) -> None:
    guard = make({"room": [-2, 2, -1.5, 1.5]})
    done = list[bool]()
    moves = st.builds(move, st.floats(0.2, 4.0), st.sampled_from(list(Direction)))

    @settings(max_examples=15, deadline=None, database=None)
    @given(yaw_rad=st.floats(-3, 3), plan=st.lists(st.one_of(steps, moves), min_size=4, max_size=12))
    def property_holds(yaw_rad: float, plan: list[Primitive]) -> None:
        fake_of(guard).carry(Pose(0.0, 0.0, yaw_rad))
        until(lambda: guard.state().homed and guard.step(turn(6), go_on).ok)
        for primitive in plan:
            result = guard.step(primitive, go_on)
            done.append(bool(result.path))
            for x, y in [point[1:3] for point in result.path]:
                assert min(2 - abs(x), 1.5 - abs(y)) > 0.17

    property_holds()
    assert sum(done) > 20


def test_law_8_old_states_are_no_readings_so_what_a_dead_robot_said_last_proves_nothing() -> None:
    ranges = Ranges()
    for n in range(20):
        ranges.see(n * 0.05, RobotState(age_s=0.0, ranges_m=(2.0 + n / 1000, 2.0, 2.0, 2.0)))
    assert ranges.known()[0] is not None
    for n in range(20, 60):  # the robot is gone; its last words are looked at again and again
        ranges.see(n * 0.05, RobotState(age_s=n * 0.05 - 0.95, ranges_m=(2.019, 2.0, 2.0, 2.0)))
    assert not ranges.enough
    assert not ranges.settled
    assert ranges.known() == (None,) * 4


def test_law_8_a_robot_that_falls_silent_leaves_no_readings_behind(make: Make) -> None:
    guard = make({"faults": {"stale": True, "after_m": 0.5}, "time_scale": 1.0})
    until(lambda: guard.state().homed and guard._ranges.enough)
    result = guard.step(move(2.0), go_on)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stale_state")
    until(lambda: not guard._ranges.enough)  # so the first word after the silence is not judged by what was before
    assert guard._ranges.known() == (None,) * 4
