"""Goals without a model on the fake robot: the way home, and eyes; never beyond the mandate and the limits."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.agent.execution.execute import Execution
from agentrob.agent.execution.local_goal import matching, run_local_task
from agentrob.agent.execution.way_home import way_home
from agentrob.agent.understanding.visual_goal import local_task_of
from agentrob.config.robots import RobotConfig
from agentrob.eyes.colours import ColourDetector
from agentrob.eyes.protocol import Detection, Detector, Picture
from agentrob.eyes.sight import Seen
from agentrob.language.goal import Aim, Goal, Subgoal
from agentrob.model import Capabilities, CommandState, Direction, Limits, Op, Outcome, Pose, Primitive
from agentrob.robots.fake import FakeRobot
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt
from tests.agent.execution.visual_scene import COMMAND, LocalDriver, hooks

HOME = Goal((Subgoal(Aim.HOME),))
RED = Goal((Subgoal(Aim.FACE, "ball", "red"),))
BLUE = Goal((Subgoal(Aim.FACE, "ball", "blue"),))
AWAY = (
    Primitive(Op.TURN, Direction.LEFT, degrees=70.0),
    Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.5),
    Primitive(Op.TURN, Direction.RIGHT, degrees=150.0),
)
CAN = Capabilities("fake", frozenset(Op), simulated=True)


MakeRobot = Callable[..., LocalDriver]


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[MakeRobot]:
    """Make a fake robot behind a guard, at home, with a red ball ahead on the left and a green one behind it."""
    made: list[Guard] = []

    def make(*, homed: bool = True, limits: dict[str, Any] | None = None, **options: Any) -> LocalDriver:
        fake = {"time_scale": math.inf, "things": [[2, 1, 0.3, "red"], [-3, 0.2, 0.4, "green"]], **options}
        settings = RobotConfig.model_validate(
            {"model": "fake", "simulated": True, "home_on_start": homed, "options": fake, "limits": limits or {}}
        )
        made.append(Guard(FakeRobot(settings), settings, Halt(tmp_path / f"halt{len(made)}")))
        return LocalDriver(made[-1])

    yield make
    for guard in made:
        guard.close()


async def pursue(driver: LocalDriver, goal: Goal, detector: Detector | None = None) -> Execution:
    capabilities = driver.guard.capabilities
    task = local_task_of(goal, detector or ColourDetector({}), capabilities, None)
    allowed = hooks()
    return await run_local_task(driver, COMMAND, task, allowed)  # type: ignore[arg-type]


def goal_of_steps(*steps: Primitive, then: Aim = Aim.HOME) -> Goal:
    return Goal((*(Subgoal(Aim.STEP, step=step) for step in steps), Subgoal(then)))


# ---------------------------------------------------------------- home
@given(
    st.floats(-4, 4), st.floats(-4, 4), st.floats(-math.pi, math.pi),
    st.builds(Limits, step_m=st.floats(0.3, 5)),
)  # fmt: skip
def test_the_way_home_leads_home_in_steps_within_the_limit(x_m: float, y_m: float, yaw: float, limits: Limits) -> None:
    steps = way_home(Pose(x_m, y_m, yaw), Capabilities("fake", frozenset(Op), limits))
    for step in steps:
        if step.op is Op.MOVE:
            x_m, y_m = x_m + (step.distance_m or 0) * math.cos(yaw), y_m + (step.distance_m or 0) * math.sin(yaw)
        else:
            yaw += math.radians(step.degrees or 0) * (1 if step.direction is Direction.LEFT else -1)
    assert math.hypot(x_m, y_m) < 0.5
    assert abs(math.degrees(math.remainder(yaw, math.tau))) < 5
    assert all((step.distance_m or 0) <= limits.step_m + 0.001 for step in steps)


def test_at_home_nothing_is_to_be_done() -> None:
    assert way_home(Pose(0.02, 0.03, 0.01), CAN) == []


async def test_it_goes_away_and_comes_home_and_says_how_near(robot: MakeRobot) -> None:
    driver = robot()
    done = await pursue(driver, goal_of_steps(*AWAY))
    assert done.status is CommandState.DONE
    pose = driver.guard.posture().pose
    assert pose is not None
    assert math.hypot(pose.x_m, pose.y_m) < 0.15
    assert [result.primitive for result in done.results[:3]] == list(AWAY)
    assert done.findings == (
        f"I am {math.hypot(pose.x_m, pose.y_m):.2f} m from home by my odometry, turned "
        f"{abs(math.degrees(pose.yaw_rad)):.0f}° from its direction.",
    )


async def test_without_a_home_it_does_not_move_and_says_why(robot: MakeRobot) -> None:
    driver = robot(homed=False)
    ended = await pursue(driver, HOME)
    assert ended.status is CommandState.REFUSED
    assert ended.verdict is not None
    assert ended.verdict.rule == "guard.not_homed"
    assert "My home is not set" in ended.verdict.reason
    assert driver.steps == []


async def test_an_obstacle_on_the_way_ends_it_as_a_failure(robot: MakeRobot) -> None:
    driver = robot(obstacles=[[0.75, 0.0, 0.2]])
    ways = (Primitive(Op.MOVE, Direction.LEFT, distance_m=1.5), Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.5))
    back = Primitive(Op.MOVE, Direction.RIGHT, distance_m=1.5)
    ended = await pursue(driver, goal_of_steps(*ways, back))
    assert ended.status is CommandState.FAILED
    assert ended.results[-1].outcome is not Outcome.DONE
    assert ended.findings == ()


async def test_the_whole_command_stays_within_the_distance_of_its_mandate(robot: MakeRobot) -> None:
    driver = robot(limits={"command_m": 3.0})
    ended = await pursue(driver, goal_of_steps(Primitive(Op.MOVE, Direction.FORWARD, distance_m=2.0)))
    assert ended.status is CommandState.FAILED
    assert sum(step.distance_m or 0 for step in driver.steps) <= 3.0
    assert "The command allows 3.00 m in all" in ended.results[-1].message


# ---------------------------------------------------------------- eyes
async def test_it_turns_to_the_red_ball_and_marks_it(robot: MakeRobot) -> None:
    driver = robot()
    done = await pursue(driver, RED)
    pose = driver.guard.posture().pose
    assert done.status is CommandState.DONE
    assert pose is not None
    assert math.degrees(pose.yaw_rad) == pytest.approx(math.degrees(math.atan2(1, 2)), abs=5)
    assert done.findings[0].startswith("I turned to a red ball: measured ")
    pictures = [result.image for result in done.results if result.image]
    assert len(pictures) == 1  # the last one, marked
    assert {step.op for step in driver.steps} == {Op.TURN, Op.GET_FRONT_IMAGE}


async def test_it_looks_around_for_what_is_behind_it(robot: MakeRobot) -> None:
    driver = robot()
    done = await pursue(driver, Goal((Subgoal(Aim.FIND, "ball", "green"),)))
    assert done.status is CommandState.DONE
    pose = driver.guard.posture().pose
    assert pose is not None
    assert abs(math.degrees(pose.yaw_rad)) > 150


async def test_what_is_nowhere_is_not_reached_after_one_look_around(robot: MakeRobot) -> None:
    driver = robot()
    ended = await pursue(driver, BLUE)
    assert ended.status is CommandState.FAILED
    assert ended.findings == ("I looked around and do not see a blue ball.",)
    turned = sum(step.degrees or 0 for step in driver.steps)
    assert 300 <= turned <= 360
    assert sum(step.moves for step in driver.steps) <= CAN.limits.command_steps


@pytest.mark.parametrize("limits", [{"command_s": 15.0}, {"command_steps": 4}])
async def test_it_asks_instead_of_looking_around_beyond_its_limits(robot: MakeRobot, limits: dict[str, Any]) -> None:
    driver = robot(limits=limits)
    ended = await pursue(driver, BLUE)
    assert ended.status is CommandState.FAILED
    assert "beyond my limits for one command. Shall I turn to a side first?" in ended.findings[0]
    assert all(step.op is Op.GET_FRONT_IMAGE for step in driver.steps)


async def test_seeing_and_naming_colours_moves_nothing(robot: MakeRobot) -> None:
    driver = robot()
    done = await pursue(driver, Goal((Subgoal(Aim.SEE, "ball", "red"), Subgoal(Aim.COLOURS))))
    assert done.findings == (
        "I see a red ball about 27° to the left.", "I see a red ball about 27° to the left.",
    )  # fmt: skip
    assert not any(step.moves for step in driver.steps)


class Chairs:
    """A detector of an owner's: it sees a chair until the robot has turned, or fails."""

    things, colours = ("chair",), ()

    def __init__(self, error: Exception | None = None, *, always: bool = False) -> None:
        self.looked = 0
        self.error = error
        self.always = always

    def detect(self, picture: Picture) -> Sequence[Detection]:
        self.looked += 1
        if self.error:
            raise self.error
        return [Detection("chair", "", (0, 100, 60, 200), 0.9)] if self.always or self.looked == 1 else []


async def test_an_owner_s_detector_decides_what_is_seen_and_what_is_lost(robot: MakeRobot) -> None:
    driver, eyes = robot(), Chairs()
    ended = await pursue(driver, Goal((Subgoal(Aim.FACE, "chair"),)), eyes)
    assert ended.status is CommandState.FAILED
    assert ended.findings == ("I turned towards a chair and do not see it any more.",)
    assert eyes.looked == 2


async def test_a_detector_that_always_sees_something_aside_turns_the_robot_a_few_times_only(robot: MakeRobot) -> None:
    driver, eyes = robot(), Chairs(always=True)
    ended = await pursue(driver, Goal((Subgoal(Aim.FACE, "chair"),)), eyes)
    assert ended.status is CommandState.FAILED
    assert ended.findings[0].startswith("I turned several times and still see a chair about ")
    assert sum(step.moves for step in driver.steps) == 4


async def test_a_detector_that_fails_is_told_and_moves_nothing(robot: MakeRobot) -> None:
    driver = robot()
    ended = await pursue(driver, Goal((Subgoal(Aim.FACE, "chair"),)), Chairs(RuntimeError("no weights")))
    assert ended.status is CommandState.FAILED
    assert ended.findings == ("My detector could not read the picture (RuntimeError).",)
    assert not any(step.moves for step in driver.steps)


def test_a_thing_of_another_shape_or_colour_is_not_what_was_meant() -> None:
    def seen(thing: str, colour: str) -> Seen:
        return Seen(thing, colour, 0.0, (0, 0, 9, 9), 0.5)

    ball = Subgoal(Aim.SEE, "ball", "red")
    assert matching(ball, [seen("box", "red"), seen("ball", "blue")]) is None
    assert matching(ball, [seen("", "red"), seen("ball", "red")]) == seen("ball", "red")
    assert matching(ball, [seen("", "red")]) == seen("", "red")
    assert matching(Subgoal(Aim.SEE, "ball"), [seen("", "red")]) is None
