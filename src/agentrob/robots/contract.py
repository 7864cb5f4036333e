"""The contract test of every robot, built in or third party: subclass it and provide a `robot` fixture.

    class TestMyRobot(RobotContract):
        @pytest.fixture
        def robot(self):
            robot = MyRobot(RobotConfig(model="mine", simulated=True))
            yield robot
            robot.close()

The robot must stand upright with two metres free around it. Operations that it does not offer are
skipped; one that cannot walk is watched and stopped during its longest gesture instead. Its package must be installed,
since a test looks up the entry point of its model.
"""

from __future__ import annotations

import itertools
import math
import threading
import time
from functools import partial
from importlib.metadata import entry_points

from agentrob.config.robots import RobotConfig
from agentrob.language.messages.plan_text import example_of
from agentrob.language.operations.clashes import clashes
from agentrob.model import ActionClass, ActionResult, Direction, Op, Operation, Outcome, Primitive, RobotState
from agentrob.robots.control.controller import wrap
from agentrob.robots.protocol import HasCamera, Robot
from agentrob.robots.safety.declared import SLACK_M, as_declared

FORWARD = Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.4)
FAR = Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.5)
LEFT = Primitive(Op.TURN, Direction.LEFT, degrees=30)
RIGHT = Primitive(Op.TURN, Direction.RIGHT, degrees=30)
#: Timeout of a step that hangs, long enough for a busy machine.
LIMIT_S = 60.0


def go_on(_: RobotState) -> str | None:
    """A watch that never stops the step."""
    return None


def complete(result: ActionResult, primitive: Primitive) -> None:
    """Check what must hold for every result, however the step ended."""
    assert result.primitive == primitive
    assert 0 < result.started_s <= result.ended_s <= time.monotonic()
    assert (result.outcome is Outcome.DONE) or (result.reason and result.message)
    assert all(math.isfinite(value) for value in result.measured.values())
    seconds = [point[0] for point in result.path]
    assert seconds == sorted(seconds)
    assert all(math.isfinite(value) for point in result.path for value in point)


class RobotContract:
    """Each test checks one promise of `agentrob.robots.protocol.Robot`; see the module docstring."""

    def test_it_says_what_it_can_do(self, robot: Robot) -> None:
        capabilities = robot.capabilities
        assert capabilities.model
        assert capabilities.ops
        assert Op.MOVE not in capabilities.ops or capabilities.move_directions
        assert min(capabilities.limits.speed_mps, capabilities.limits.turn_dps, capabilities.limits.step_m) > 0

    def test_it_is_found_by_its_model_and_says_what_it_can_do_before_it_is_connected(self, robot: Robot) -> None:
        capabilities = robot.capabilities
        found = {e.name: e for e in entry_points(group="agentrob.robots")}
        assert capabilities.model in found, "its model is the name of its entry point in the group agentrob.robots"
        settings = RobotConfig(model=capabilities.model, simulated=capabilities.simulated)
        described = found[capabilities.model].load().describe(settings)
        assert described.model == capabilities.model
        assert (described.ops, described.declared) == (capabilities.ops, capabilities.declared)

    def test_its_state_is_fresh_and_asking_never_blocks(self, robot: Robot) -> None:
        state = fresh(robot)
        assert state.pose is not None
        assert state.upright is True
        began_s = time.monotonic()
        for _ in range(20):
            robot.state()
        assert time.monotonic() - began_s < 1.0

    def test_a_move_is_done_and_measured(self, robot: Robot) -> None:
        if not can(robot, FORWARD):
            return
        fresh(robot)
        result = robot.step(FORWARD, go_on)
        complete(result, FORWARD)
        assert result.outcome is Outcome.DONE, result.message
        assert abs(result.measured["distance_m"] - 0.4) <= 0.06
        assert {"sideways_m", "heading_deg"} <= set(result.measured)
        (first_s, x, y, _), (last_s, x_end, y_end, _) = result.path[0], result.path[-1]
        assert first_s == 0.0
        assert len(result.path) >= 8 * (last_s - first_s)
        assert abs(math.hypot(x_end - x, y_end - y) - 0.4) < 0.1

    def test_a_turn_is_done_and_measured_either_way(self, robot: Robot) -> None:
        fresh(robot)
        for primitive in filter(partial(can, robot), (LEFT, RIGHT)):
            result = robot.step(primitive, go_on)
            complete(result, primitive)
            assert result.outcome is Outcome.DONE, result.message
            assert abs(result.measured["degrees"] - 30) <= 4.5
            assert "drift_m" in result.measured

    def test_the_watch_is_asked_before_anything_moves(self, robot: Robot) -> None:
        before = fresh(robot)
        for primitive in filter(partial(can, robot), (FORWARD, LEFT, motion_of(robot))):
            result = robot.step(primitive, lambda _: "not_now")
            complete(result, primitive)
            assert (result.outcome, result.reason) == (Outcome.STOPPED, "not_now")
        assert apart_m(before, fresh(robot)) < 0.03

    def test_the_watch_is_asked_all_the_time_and_ends_the_step(self, robot: Robot) -> None:
        start, asked, motion = fresh(robot), list[float](), motion_of(robot)

        def half_way(state: RobotState) -> str | None:
            asked.append(time.monotonic())
            return "enough" if under_way(motion, start, state, asked[0], 0.4) else None

        result = robot.step(motion, half_way)
        complete(result, motion)
        assert (result.outcome, result.reason) == (Outcome.STOPPED, "enough")
        assert motion is not FAR or 0.35 < result.measured["distance_m"] < 0.9
        assert max(b - a for a, b in itertools.pairwise(asked)) < 0.25

    def test_a_stop_from_another_thread_ends_the_step(self, robot: Robot) -> None:
        start, moving, results = fresh(robot), threading.Event(), list[ActionResult]()
        began_s, motion = time.monotonic(), motion_of(robot)

        def notice(state: RobotState) -> str | None:
            if under_way(motion, start, state, began_s, 0.15):
                moving.set()
            return None

        step = threading.Thread(target=lambda: results.append(robot.step(motion, notice)))
        step.start()
        assert moving.wait(LIMIT_S)
        stopped = robot.stop()
        step.join(LIMIT_S)
        (result,) = results
        complete(result, motion)
        assert (result.outcome, result.reason) == (Outcome.STOPPED, "stop")
        assert motion is not FAR or result.measured["distance_m"] < 1.2
        assert stopped.latency_ms < 200
        assert stopped.was_moving
        assert stopped.confirmed, stopped.message
        assert stopped.coasted_m is not None
        assert stopped.coasted_m < 0.5

    def test_a_stop_of_a_turn_says_that_it_was_moving(self, robot: Robot) -> None:
        if not can(robot, LEFT):
            return
        start, turning, results = fresh(robot), threading.Event(), list[ActionResult]()

        def notice(state: RobotState) -> str | None:
            if start.pose and state.pose and abs(wrap(state.pose.yaw_rad - start.pose.yaw_rad)) > 0.3:
                turning.set()
            return None

        around = Primitive(Op.TURN, Direction.LEFT, degrees=min(300.0, robot.capabilities.limits.step_deg))
        step = threading.Thread(target=lambda: results.append(robot.step(around, notice)))
        step.start()
        assert turning.wait(LIMIT_S)
        stopped = robot.stop()
        step.join(LIMIT_S)
        assert results[0].outcome is Outcome.STOPPED
        assert stopped.was_moving

    def test_a_stop_at_rest_is_confirmed_and_harmless(self, robot: Robot) -> None:
        fresh(robot)
        stopped = robot.stop()
        assert stopped.confirmed, stopped.message
        assert not stopped.was_moving
        again = FORWARD if can(robot, FORWARD) else motion_of(robot)
        assert robot.step(again, go_on).outcome is Outcome.DONE

    def test_a_gesture_ends_and_says_how(self, robot: Robot) -> None:
        fresh(robot)
        if Op.HELLO in robot.capabilities.ops:
            primitive = Primitive(Op.HELLO)
            result = robot.step(primitive, go_on)
            complete(result, primitive)
            assert result.outcome is Outcome.DONE, result.message

    def test_its_own_operations_are_understood_and_take_no_words_that_mean_something_else(self, robot: Robot) -> None:
        assert list(clashes(robot.capabilities)) == []

    def test_each_of_its_own_operations_is_done_and_measured_as_declared(self, robot: Robot) -> None:
        for operation in own_operations(robot):
            start, primitive = fresh(robot), example_of(operation)
            result = robot.step(primitive, go_on)
            complete(result, primitive)
            assert result.outcome is Outcome.DONE, result.message
            assert as_declared(result).outcome is Outcome.DONE, as_declared(result).message
            assert {quantity.name for quantity in operation.measured} <= set(result.measured)
            assert apart_m(start, fresh(robot)) <= operation.most_travel_m + SLACK_M, "it stays within its travel_m"
            assert not operation.picture or (result.image or b"").startswith(b"\xff\xd8")

    def test_the_watch_is_asked_before_each_of_its_own_operations_begins(self, robot: Robot) -> None:
        for operation in own_operations(robot):
            start, primitive = fresh(robot), example_of(operation)
            result = robot.step(primitive, lambda _: "not_now")
            complete(result, primitive)
            assert (result.outcome, result.reason) == (Outcome.STOPPED, "not_now")
            assert apart_m(start, fresh(robot)) < 0.03

    def test_a_picture_is_a_jpeg(self, robot: Robot) -> None:
        if Op.GET_FRONT_IMAGE in robot.capabilities.ops:
            primitive = Primitive(Op.GET_FRONT_IMAGE)
            result = robot.step(primitive, go_on)
            complete(result, primitive)
            assert result.outcome is Outcome.DONE, result.message
            assert result.image is not None
            assert result.image.startswith(b"\xff\xd8")

    def test_a_look_while_it_moves_is_a_jpeg_and_leaves_the_step_alone(self, robot: Robot) -> None:
        if not isinstance(robot, HasCamera) or Op.GET_FRONT_IMAGE not in robot.capabilities.ops:
            return
        results: list[ActionResult] = []
        turn = Primitive(Op.TURN, Direction.LEFT, degrees=60.0)
        motion = turn if can(robot, turn) else motion_of(robot)
        turning = threading.Thread(target=lambda: results.append(robot.step(motion, go_on)))
        turning.start()
        pictures = [robot.look() for _ in range(3)]
        turning.join()
        assert all(picture.startswith(b"\xff\xd8") for picture in pictures)
        assert results[0].outcome is Outcome.DONE, results[0].message


def can(robot: Robot, primitive: Primitive) -> bool:
    return primitive.op in robot.capabilities.ops


def motion_of(robot: Robot) -> Primitive:
    """Return a step that takes the robot some seconds: a walk, or its longest gesture if it cannot walk."""
    if can(robot, FAR):
        return FAR
    gestures = [one for one in robot.capabilities.operations if one.action_class is ActionClass.GESTURE]
    assert gestures, "a robot that cannot walk has a gesture"
    return example_of(max(gestures, key=lambda one: one.takes_s))


def under_way(motion: Primitive, start: RobotState, now: RobotState, began_s: float, metres: float) -> bool:
    """Return whether a motion has come so far: a walk so many metres, a gesture into its second half second."""
    return apart_m(start, now) > metres if motion is FAR else time.monotonic() - began_s > 0.5


def own_operations(robot: Robot) -> list[Operation]:
    """Return the operations that the robot declares, without those that need its owner's consent."""
    return [operation for operation in robot.capabilities.declared if not operation.needed_consent]


def fresh(robot: Robot) -> RobotState:
    """Return a recent state; wait for the first one if needed."""
    end_s = time.monotonic() + LIMIT_S
    while (state := robot.state()).age_s > 0.5:
        assert time.monotonic() < end_s, f"no state came within {LIMIT_S:.0f} s"
        time.sleep(0.02)
    return state


def apart_m(a: RobotState, b: RobotState) -> float:
    """Distance between two states in metres; 0 if either has no position."""
    return math.hypot(a.pose.x_m - b.pose.x_m, a.pose.y_m - b.pose.y_m) if a.pose and b.pose else 0.0
