"""Laws 8 and 9: invariants that hold whatever is requested and whatever the robot reports."""

from __future__ import annotations

import math
import re
import threading
from dataclasses import replace

import pytest
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st

from agentrob.config.robots import FenceConfig
from agentrob.errors import RobotError
from agentrob.model import ActionResult, Direction, Op, Outcome, Pose, Primitive, RobotState
from agentrob.robots.contract import go_on
from agentrob.robots.control.controller import known, wrap
from agentrob.robots.protocol import Watch
from agentrob.robots.safety.fence import Fence
from agentrob.robots.safety.ranges import RangeMonitor, sides
from tests.robots.guard_scene import B, L, Make, R, fake_of, move, turn
from tests.waiting import wait_for

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
    wait_for(lambda: guard.state().homed)
    robot, done = fake_of(guard), list[bool]()

    @settings(max_examples=60, database=None)
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
#: Yaw is never infinite here, because the fake's own arithmetic cannot handle that.
no_place = st.builds(Pose, number, number, st.floats(-3, 3) | st.just(math.nan)).filter(lambda p: known(p) is None)


@given(x=number, y=number, home=st.builds(Pose, number, number, st.floats(-3, 3)))
def test_law_9_a_point_that_is_no_number_is_outside_of_every_fence(x: float, y: float, home: Pose) -> None:
    if not all(map(math.isfinite, (x, y, home.x_m, home.y_m))):
        assert Fence(FENCE, home).outside_m(x, y) == math.inf
        assert Fence(FENCE, home).refusal(Pose(x, y, 0.0), turn(10)) is not None


def test_law_9_whatever_odometry_that_is_no_number_moves_nothing(make: Make) -> None:
    guard = make()
    wait_for(lambda: guard.state().homed)
    robot, place = fake_of(guard), fake_of(guard).pose

    @settings(max_examples=40, database=None)
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
    wait_for(lambda: guard.state().homed)
    robot = fake_of(guard)

    def watch(state: RobotState) -> str | None:
        if state.pose and state.pose.x_m > 0.3:
            robot.carry(bad)
        return None

    result = (guard if guarded else robot).step(move(2.0), watch)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stale_state")
    assert all(map(math.isfinite, (v for point in result.path for v in point)))
    assert (result.measured, result.unmeasured) == ({}, "odometry_lost"), "it went on, and nobody saw how far"
    assert "measured unknown: its odometry was lost" in result.message
    assert 0.25 < result.path[-1][1] < 0.6


def test_whatever_is_asked_the_robot_keeps_off_the_walls(make: Make) -> None:
    guard = make({"room": [-2, 2, -1.5, 1.5]})
    done = list[bool]()
    moves = st.builds(move, st.floats(0.2, 4.0), st.sampled_from(list(Direction)))

    @settings(max_examples=15, database=None)
    @given(yaw_rad=st.floats(-3, 3), plan=st.lists(st.one_of(steps, moves), min_size=4, max_size=12))
    def property_holds(yaw_rad: float, plan: list[Primitive]) -> None:
        fake_of(guard).carry(Pose(0.0, 0.0, yaw_rad))
        wait_for(lambda: guard.state().homed and guard.step(turn(6), go_on).ok)
        for primitive in plan:
            result = guard.step(primitive, go_on)
            done.append(bool(result.path))
            for x, y in [point[1:3] for point in result.path]:
                assert min(2 - abs(x), 1.5 - abs(y)) > 0.17

    property_holds()
    assert sum(done) > 20


def test_law_8_old_states_are_no_readings_so_what_a_dead_robot_said_last_proves_nothing() -> None:
    ranges = RangeMonitor()
    for n in range(20):
        ranges.update(n * 0.05, RobotState(age_s=0.0, ranges_m=(2.0 + n / 1000, 2.0, 2.0, 2.0)))
    assert ranges.known()[0] is not None
    for n in range(20, 60):  # the robot is gone; its last state is read again and again
        ranges.update(n * 0.05, RobotState(age_s=n * 0.05 - 0.95, ranges_m=(2.019, 2.0, 2.0, 2.0)))
    assert not ranges.enough
    assert not ranges.settled
    assert ranges.known() == (None,) * 4


def test_law_8_a_robot_that_falls_silent_leaves_no_readings_behind(make: Make) -> None:
    guard = make({"faults": {"stale": True, "after_m": 0.5}, "time_scale": 1.0})
    wait_for(lambda: guard.state().homed and guard._ranges.enough)
    result = guard.step(move(2.0), go_on)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stale_state")
    wait_for(
        lambda: not guard._ranges.enough
    )  # so that the first state after the silence is not judged by earlier ones
    assert guard._ranges.known() == (None,) * 4


#: How a reading is lost at once; one that merely stays the same is believed for another second.
LOSSES = {"missing": None, "zero": 0.0, "not a number": math.nan}
#: The largest fraction of the requested motion between the loss and rest.
COASTED_SHARE = 0.4


@pytest.mark.parametrize("consent", [False, True])
def test_law_8_readings_lost_on_the_way_end_a_step_at_any_speed_unless_the_owner_consents(
    make: Make, monkeypatch: pytest.MonkeyPatch, consent: bool
) -> None:
    wide = FenceConfig(x_min_m=-999, x_max_m=999, y_min_m=-999, y_max_m=999)
    guard = make({"room": [-999, 999, -999, 999]}, fence=wide, allow_unknown_ranges=consent)
    wait_for(lambda: guard.state().homed)
    robot, lost, blind, slow_ones_ended = fake_of(guard), dict[str, float | None](), set[int](), list[bool]()
    seen = robot._ranges
    monkeypatch.setattr(robot, "_ranges", lambda: tuple(lost["as"] if k in blind else r for k, r in enumerate(seen())))

    @settings(max_examples=25, database=None, phases=(Phase.explicit, Phase.generate))
    @example(kind="zero", sectors={0, 1, 2, 3}, share=0.3, speed_mps=0.15, way=Direction.FORWARD)
    @example(kind="zero", sectors={0, 1, 2, 3}, share=0.3, speed_mps=None, way=Direction.FORWARD)
    @given(
        kind=st.sampled_from(sorted(LOSSES)),
        sectors=st.sets(st.integers(0, 3), min_size=1),
        share=st.floats(0.1, 0.6),
        speed_mps=st.one_of(st.none(), st.floats(0.1, 0.2), st.floats(0.2, 0.5), st.just(0.2)),
        way=st.one_of(st.sampled_from(list(Direction)), st.sampled_from([turn(90, L), turn(90, R)])),
    )
    def property_holds(
        kind: str, sectors: set[int], share: float, speed_mps: float | None, way: Direction | Primitive
    ) -> None:
        blind.clear()
        lost["as"] = LOSSES[kind]
        primitive, start = move(0.5, way, speed_mps) if isinstance(way, Direction) else way, robot.pose

        def done(pose: Pose) -> float:
            turned = abs(wrap(pose.yaw_rad - start.yaw_rad)) / math.radians(90)
            return turned if primitive.op is Op.TURN else math.hypot(pose.x_m - start.x_m, pose.y_m - start.y_m) / 0.5

        def lose(state: RobotState) -> None:
            if state.pose is not None and done(state.pose) >= share:
                blind.update(sectors)

        result = guard.step(primitive, lose)
        slow = primitive.op is Op.MOVE and (speed_mps or 0.5) <= 0.2
        if not sectors & set(sides(primitive)):
            assert result.ok, result.message
        elif consent and slow:
            assert result.ok, result.message
            assert "range readings" in result.message
        else:
            assert (result.outcome, result.reason) == (Outcome.STOPPED, "ranges_unknown"), result.message
            assert share <= done(robot.pose) < share + COASTED_SHARE
            slow_ones_ended.append(slow)

    property_holds()
    assert slow_ones_ended
    assert any(slow_ones_ended) is not consent


def test_law_8_readings_that_freeze_on_the_way_end_a_slow_step_within_a_second(make: Make) -> None:
    guard = make({"faults": {"ranges": "constant", "after_m": 0.3}, "time_scale": 1})
    wait_for(lambda: guard.state().homed)
    result = guard.step(move(1.0, speed_mps=0.2), go_on)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "ranges_unknown"), result.message
    assert 0.3 < fake_of(guard).pose.x_m < 0.65


@pytest.mark.parametrize("primitive", [move(0.5, speed_mps=0.2), move(0.5, speed_mps=0.1), move(0.5), turn(30)])
def test_law_8_a_blind_step_says_so_however_slowly_it_was_asked_for(make: Make, primitive: Primitive) -> None:
    guard = make({"faults": {"ranges": "missing"}}, allow_unknown_ranges=True)
    result = guard.step(primitive, go_on)
    assert result.ok, result.message
    assert "range readings are unknown" in result.message


@pytest.mark.parametrize("guarded", [True, False])
@pytest.mark.parametrize("ends", ["by itself", "by a stop"])
@pytest.mark.parametrize(
    ("breaks", "why"), [("lost", "odometry_lost"), ("silent", "odometry_lost"), ("jump", "odometry_jump")]
)
@pytest.mark.parametrize("primitive", [move(1.5), move(1.5, L), turn(170)])
def test_law_18_no_number_spans_a_jump_or_a_silence_of_the_odometry(
    make: Make, monkeypatch: pytest.MonkeyPatch, primitive: Primitive, breaks: str, why: str, ends: str, guarded: bool
) -> None:
    """The reading fails in motion and recovers at once, so at rest everything looks fine."""
    guard = make()
    wait_for(lambda: guard.state().homed)
    robot, looks = fake_of(guard), list[RobotState]()
    seen, start = robot._seen, robot.pose

    def faulty_state() -> RobotState:
        state = seen()
        if threading.current_thread() is not threading.main_thread() or len(looks) not in (20, 21, 22):
            return state
        if breaks == "lost":
            return replace(state, pose=Pose(math.nan, 0.0, 0.0))
        return replace(state, age_s=0.8) if breaks == "silent" else state

    def watch(state: RobotState) -> str | None:
        looks.append(state)
        if breaks == "jump" and len(looks) == 20:
            robot.carry(Pose(robot.pose.x_m + 1.0, robot.pose.y_m, robot.pose.yaw_rad))
        return "stop" if ends == "by a stop" and len(looks) >= 21 else None

    monkeypatch.setattr(robot, "_seen", faulty_state)
    result = (guard if guarded else robot).step(primitive, watch)
    assert result.outcome is Outcome.STOPPED, result.message
    assert (result.measured, result.unmeasured) == ({}, why), result.message
    assert f"measured unknown: its {why.replace('_lost', ' was lost').replace('_jump', ' jumped')}" in result.message
    assert not re.search(r"measured -?\d", result.message)
    assert all(math.hypot(x - start.x_m, y - start.y_m) < 0.8 for _, x, y, _ in result.path), "where it was seen only"


def test_law_18_a_robot_of_somebody_else_that_measures_across_a_jump_is_not_believed(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    guard = make()
    wait_for(lambda: guard.state().homed)
    robot = fake_of(guard)

    def step(primitive: Primitive, watch: Watch) -> ActionResult:
        watch(robot.state())
        robot.carry(Pose(1.0, 0.0, 0.0))
        watch(robot.state())
        return ActionResult(primitive, Outcome.DONE, {"distance_m": 1.0}, "", "Asked 1 m, measured 1.00 m.", 1.0, 2.0)

    monkeypatch.setattr(robot, "step", step)
    result = guard.step(move(1.0), go_on)
    assert (result.outcome, result.reason, result.measured) == (Outcome.UNKNOWN, "odometry_jump", {})
    assert "measured unknown: its odometry jumped" in result.message
    assert "1.00 m." not in result.message.split("Home is void")[0]
