"""The guard holds a robot to what it declares: arguments, space, time, place and measured values, whatever it says."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from agentrob.config.robots import RobotConfig
from agentrob.model import (
    BUILT_IN,
    ActionClass,
    ActionResult,
    Capabilities,
    Direction,
    Number,
    Op,
    Operation,
    Outcome,
    Pose,
    Primitive,
    Quantity,
    RobotState,
    Unit,
)
from agentrob.robots.control.controller import Velocity
from agentrob.robots.control.timed import run_for
from agentrob.robots.fake import FakeRobot
from agentrob.robots.protocol import Watch
from agentrob.robots.safety.declared import left_its_place
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt

PUFF = Operation(
    "puff", ActionClass.GESTURE, {"en": "puff"}, (Number("seconds", Unit.SECONDS, 1, 10, 3),),
    measured=(Quantity("seconds", Unit.SECONDS, 0.5),), time_limit_s=2.0,
)  # fmt: skip
STEP = Primitive("puff", arguments=(("seconds", 3.0),))
Make = Callable[..., Guard]
#: What a test may change of a `PuffingRobot`.
OVERRIDES = ("creep_mps", "seconds", "told", "deaf", "drifts_mps")


class PuffingRobot(FakeRobot):
    """Puffs for some seconds; while it does, it walks at `creep_mps`, which a gesture must not."""

    operation = PUFF
    creep_mps = 0.0
    seconds: float | None = None  # instead of those that were asked for
    told: dict[str, float] | None = None  # instead of what was measured
    deaf = False  # whether it ignores the watch
    drifts_mps = 0.0  # how fast it walks when nobody watches it any more

    @classmethod
    def describe(cls, settings: RobotConfig) -> Capabilities:
        return replace(super().describe(settings), declared=(cls.operation,))

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        if primitive.op != "puff":
            return super().step(primitive, watch)
        seconds = primitive.value("seconds") if self.seconds is None else self.seconds

        def creeping(state: Any) -> str | None:
            if self.creep_mps:
                self.command(Velocity(self.creep_mps))
            reason = watch(state)
            return None if self.deaf else reason

        result = run_for(self, primitive, creeping, seconds, lambda: None, self.rest)
        for _ in range(50 if self.drifts_mps else 0):
            self.command(Velocity(self.drifts_mps))
            self.wait_until(self.now_s() + 0.05)
        self.rest()
        return result if self.told is None else replace(result, measured=self.told)


@pytest.fixture
def make(tmp_path: Path) -> Iterator[Make]:
    made: list[Guard] = []

    def make(operation: Operation = PUFF, options: dict[str, Any] | None = None, **given: Any) -> Guard:
        doing = {name: given.pop(name) for name in OVERRIDES if name in given}
        kind = type("Robot", (PuffingRobot,), {"operation": operation, **doing})
        facts = {"model": "fake", "simulated": True, "home_on_start": True, **given}
        config = RobotConfig(options={"time_scale": math.inf, **(options or {})}, **facts)
        made.append(Guard(kind(config), config, Halt(tmp_path / "fake.halt")))
        return made[-1]

    yield make
    for guard in made:
        guard.close()


def go_on(_: object) -> None:
    return None


def test_law_18_what_was_asked_is_held_against_what_was_measured(make: Make) -> None:
    done = make().step(STEP, go_on)
    assert (done.outcome, round(done.measured["seconds"])) == (Outcome.DONE, 3)
    short = make(seconds=1.0).step(STEP, go_on)
    assert (short.outcome, short.reason) == (Outcome.FAILED, "inaccurate")
    assert short.message == "seconds: asked 3 s, measured 1 s."


@pytest.mark.parametrize("told", [{}, {"seconds": math.nan}])
def test_law_18_what_was_not_measured_is_not_called_done(make: Make, told: dict[str, float]) -> None:
    result = make(told=told).step(STEP, go_on)
    assert (result.outcome, result.reason) == (Outcome.UNKNOWN, "not_measured")


@pytest.mark.parametrize("deaf", [False, True])
def test_law_8_a_gesture_that_travels_is_caught_by_the_odometry_and_told(make: Make, *, deaf: bool) -> None:
    guard = make(creep_mps=0.4, deaf=deaf, operation=replace(PUFF, time_limit_s=20.0))
    result = guard.step(STEP, go_on)
    assert result.reason == "travelled"
    assert not result.ok
    assert result.message.count("puff is declared as gesture that takes the robot at most 0.3 m from its place") == 1
    pose = guard.state().pose
    assert pose is not None
    if not deaf:
        assert math.hypot(pose.x_m, pose.y_m) < 0.6, "it was ended, not only told"


def test_law_8_a_look_that_travels_is_caught_too(make: Make) -> None:
    sight = replace(PUFF, action_class=ActionClass.LOOK)
    assert make(operation=sight).step(STEP, go_on).ok
    guard = make(operation=sight, creep_mps=0.4)
    result = guard.step(STEP, go_on)
    assert (result.outcome, result.reason) == (Outcome.FAILED, "travelled")
    assert result.message.count("puff is declared as look that takes the robot at most 0.1 m from its place") == 1
    pose = guard.state().pose
    assert pose is not None
    assert math.hypot(pose.x_m, pose.y_m) < 0.4, "it was ended, not only told"


def test_law_8_a_look_that_travels_is_caught_after_a_jump_of_the_odometry_too(make: Make) -> None:
    guard = make(operation=replace(PUFF, action_class=ActionClass.LOOK), creep_mps=0.4)
    robot = guard._robot
    assert isinstance(robot, PuffingRobot)
    guard.observe()
    robot.carry(Pose(5.0, 0.0, 0.0))
    guard.observe()
    assert guard._broken
    assert guard.step(STEP, go_on).reason == "travelled"


def test_law_8_a_gesture_that_comes_back_has_left_its_place(make: Make) -> None:
    """It walks 0.6 m away and back to its place, where a gesture may take it 0.3 m."""
    guard = make(creep_mps=0.4, deaf=True, operation=replace(PUFF, time_limit_s=20.0), seconds=3.0)
    robot = guard._robot
    assert isinstance(robot, PuffingRobot)

    def turn_back(state: RobotState) -> None:
        if state.pose is not None and state.pose.x_m > 0.6:
            robot.creep_mps = -0.4
        elif robot.creep_mps < 0 and state.pose is not None and state.pose.x_m < 0.1:
            robot.creep_mps = 0.0

    result = guard.step(replace(STEP, arguments=(("seconds", 6.0),)), turn_back)
    pose = guard.state().pose
    assert pose is not None
    assert math.hypot(pose.x_m, pose.y_m) < 0.3
    assert (result.outcome, result.reason) == (Outcome.FAILED, "travelled")


def test_law_18_a_gesture_that_leaves_its_place_after_the_last_look_has_failed(make: Make) -> None:
    # 0.2 m, which is no jump of the odometry for a guard that looks in the middle of it.
    result = make(replace(PUFF, travel_m=0.1), drifts_mps=0.08).step(STEP, go_on)
    assert (result.outcome, result.reason) == (Outcome.FAILED, "travelled")


def test_law_14_a_look_is_ended_by_whoever_watches_it(make: Make) -> None:
    guard = make(operation=replace(PUFF, action_class=ActionClass.LOOK))
    result = guard.step(STEP, lambda _: "lease_lapsed")
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "lease_lapsed")


def test_a_look_needs_no_home_and_a_gesture_does(make: Make) -> None:
    assert make(operation=replace(PUFF, action_class=ActionClass.LOOK), home_on_start=False).step(STEP, go_on).ok
    assert make(home_on_start=False).step(STEP, go_on).reason == "not_homed"


def test_a_move_of_its_own_may_travel_as_far_as_declared_and_not_out_of_the_fence(make: Make) -> None:
    stroll = replace(PUFF, action_class=ActionClass.MOVE, travel_m=1.0, time_limit_s=20.0)
    assert make(operation=stroll, creep_mps=0.2).step(STEP, go_on).ok
    far = make(operation=stroll, creep_mps=0.4).step(Primitive("puff", arguments=(("seconds", 9.0),)), go_on)
    assert far.reason == "travelled"
    narrow = {"x_min_m": -0.5, "x_max_m": 0.5, "y_min_m": -0.5, "y_max_m": 0.5}
    assert make(operation=stroll, creep_mps=0.3, fence=narrow).step(STEP, go_on).reason == "fence"
    fast = make(operation=stroll, creep_mps=0.5, limits={"speed_mps": 0.2}).step(STEP, go_on)
    assert fast.reason == "limit_speed_mps"


def test_law_8_a_move_of_its_own_that_nears_the_fence_ends_so_that_the_robot_rests_inside(make: Make) -> None:
    stroll = replace(PUFF, action_class=ActionClass.MOVE, travel_m=3.0, time_limit_s=20.0)
    fence = {"x_min_m": -0.5, "x_max_m": 0.5, "y_min_m": -0.5, "y_max_m": 0.5}
    guard = make(operation=stroll, creep_mps=0.4, fence=fence)
    assert guard.step(STEP, go_on).reason == "fence"
    pose = guard.state().pose
    assert pose is not None
    assert 0.3 < pose.x_m <= 0.5


@pytest.mark.parametrize(("creep_mps", "reason"), [(0.25, ""), (0.35, "limit_speed_mps")])
def test_law_10_a_move_of_its_own_may_be_measured_a_little_faster_than_the_limit(
    make: Make, creep_mps: float, reason: str
) -> None:
    stroll = replace(PUFF, action_class=ActionClass.MOVE, travel_m=3.0, time_limit_s=20.0)
    assert make(operation=stroll, creep_mps=creep_mps, limits={"speed_mps": 0.2}).step(STEP, go_on).reason == reason


@pytest.mark.parametrize("action_class", [ActionClass.MOVE, ActionClass.GESTURE])
def test_a_robot_that_does_not_tell_its_speed_is_not_taken_for_a_fast_one(
    make: Make, monkeypatch: pytest.MonkeyPatch, action_class: ActionClass
) -> None:
    travel_m = 1.0 if action_class is ActionClass.MOVE else 0.0
    operation = replace(PUFF, action_class=action_class, travel_m=travel_m, time_limit_s=20.0)
    guard = make(operation=operation, limits={"speed_mps": 0.2})
    robot = guard._robot
    assert isinstance(robot, PuffingRobot)
    seen = robot._seen
    monkeypatch.setattr(robot, "_seen", lambda: replace(seen(), velocity_mps=None))
    result = guard.step(STEP, go_on)
    assert result.ok, result.message


def test_a_gesture_on_its_place_is_not_ended_because_the_body_sways(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    guard = make(operation=replace(PUFF, travel_m=0.0), limits={"speed_mps": 0.2})
    robot = guard._robot
    assert isinstance(robot, PuffingRobot)
    seen = robot._seen

    def swaying(state: RobotState) -> None:
        monkeypatch.setattr(robot, "_seen", lambda: replace(seen(), velocity_mps=(0.5, 0.0)))

    result = guard.step(STEP, swaying)
    assert result.ok, result.message


@pytest.mark.parametrize(("options", "reason"), [({}, ""), ({"obstacles": [[0.7, 0.0, 0.2]]}, "obstacle")])
def test_law_8_the_free_space_that_it_declares_is_checked(make: Make, options: dict[str, Any], reason: str) -> None:
    roomy = replace(PUFF, free_space_m=0.8)
    assert make(operation=roomy, options=options).step(STEP, go_on).reason == reason
    assert make(options=options).step(STEP, go_on).ok, "without free space nothing is checked"


def test_law_8_its_time_limit_ends_it(make: Make) -> None:
    result = make(operation=replace(PUFF, time_limit_s=1.0), seconds=90.0, options={"time_scale": 20}).step(STEP, go_on)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "deadline")


@pytest.mark.parametrize(("left_s", "done"), [(2.9, False), (3.1, True)])
def test_a_step_that_asks_for_more_seconds_than_are_left_is_not_begun(make: Make, left_s: float, done: bool) -> None:
    result = make().step(STEP, go_on, left_s)
    assert result.ok is done, result.message
    if not done:
        assert (result.outcome, result.reason) == (Outcome.REFUSED, "deadline")
        assert result.message == "This step needs at least 3.0 s, and only 2.9 s are left."


@pytest.mark.parametrize(
    ("arguments", "reason", "said"),
    [
        ((("seconds", 11.0),), "limit_argument", "seconds of puff is 11.0; allowed: 1 to 10 s."),
        ((("seconds", math.nan),), "limit_argument", "allowed: 1 to 10 s"),
        ((("seconds", "long"),), "invalid", "allowed: 1 to 10 s"),
        ((("size", 1.0),), "invalid", "puff has no argument 'size'; its arguments: seconds."),
    ],
)
def test_law_10_arguments_beyond_the_declaration_are_refused_with_the_bounds(
    make: Make, arguments: tuple[tuple[str, Any], ...], reason: str, said: str
) -> None:
    result = make().step(Primitive("puff", arguments=arguments), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, reason)
    assert said in result.message


def test_the_robots_own_declaration_counts_and_not_the_clients(make: Make) -> None:
    wide = replace(PUFF, arguments=(Number("seconds", Unit.SECONDS, 1, 1000, 3),))
    lie = Primitive("puff", arguments=(("seconds", 500.0),), declared=wide)
    assert make().step(lie, go_on).reason == "limit_argument"


def test_a_risky_operation_needs_its_owners_consent_on_a_real_robot(make: Make) -> None:
    risky = replace(PUFF, action_class=ActionClass.RISKY)
    refused = make(operation=risky, simulated=False, home_on_start=False).step(STEP, go_on)
    assert (refused.reason, refused.message) == (
        "consent",
        """puff needs the owner's consent (allow_risky = ["puff"]).""",
    )
    willing = make(operation=risky, simulated=False, home_on_start=False, allow_risky=["puff"]).step(STEP, go_on)
    assert willing.reason == "not_homed"
    assert make(operation=risky).step(STEP, go_on).ok, "a simulated one needs none"


def test_a_stop_of_the_guard_ends_it(make: Make) -> None:
    guard = make(operation=replace(PUFF, time_limit_s=20.0))

    def stop_it(_: object) -> str | None:
        guard.stop()
        return None

    assert guard.step(STEP, stop_it).reason == "stop"
    assert Op.MOVE in guard.capabilities.ops


def test_law_8_a_robot_whose_foot_stays_by_its_declaration_is_ended_where_a_turn_takes_it_away() -> None:
    stays = replace(BUILT_IN[Op.TURN], travel_m=0.0)
    here, gone = Pose(0.0, 0.0, 0.0), Pose(0.3, 0.0, 0.5)
    turning = Primitive(Op.TURN, Direction.LEFT, degrees=30)
    assert "turn is declared as move that takes the robot at most 0 m from its place, and took it 0.30 m" in (
        left_its_place(replace(turning, declared=stays), here, gone) or ""
    )
    assert left_its_place(replace(turning, declared=stays), here, replace(gone, x_m=0.02)) is None
    assert left_its_place(turning, here, gone) is None, "a walk or turn of others is measured by itself"
