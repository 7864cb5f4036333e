"""The loop of a model that steers by camera pictures: law 7, budgets, ends, and the check of its claims."""

from __future__ import annotations

import asyncio
import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from agentrob.agent.execution.execute import Execution
from agentrob.agent.execution.visual import run_visual_task
from agentrob.config.robots import RobotConfig
from agentrob.errors import LeaseLost
from agentrob.language.goal import Aim, Goal, Subgoal
from agentrob.language.messages.catalog import say
from agentrob.minds.llm.chat import ToolResult, UserMessage
from agentrob.minds.llm.errors import ModelError
from agentrob.minds.protocol import Addressee
from agentrob.minds.visual_loop.goal import goal_of
from agentrob.model import Capabilities, Decision, Direction, EndReason, Mandate, Op, Outcome, Plan, Primitive, Verdict
from agentrob.robots.fake import FakeRobot
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt
from agentrob.screening.mandate import ROUNDING
from tests.agent.execution.visual_scene import BALL, COMMAND, MOST, Call, LocalDriver, Script, hooks, visual_task
from tests.tolerances import about_deg, about_m

DONE: Call = ("finish", {"outcome": "done", "saw": ["a blue box"], "did": "I walked to the ball."})
WALK: Call = ("act_move", {"direction": "forward", "distance_m": 1.0, "look": True})
TURN: Call = ("act_turn", {"direction": "left", "degrees": 20})
PICTURE: Call = ("get_front_image", {})
WIDE = {"x_min_m": -50.0, "x_max_m": 50.0, "y_min_m": -50.0, "y_max_m": 50.0}


def guarded(folder: Path, **options: Any) -> Guard:
    given = {"time_scale": math.inf, "room": [-60, 60, -60, 60], **options}
    config = RobotConfig(model="fake", simulated=True, home_on_start=True, options=given, fence=WIDE)
    return Guard(FakeRobot(config), config, Halt(folder / "halt"))


@pytest.fixture(scope="module")
def guard(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Guard]:
    made = guarded(tmp_path_factory.mktemp("guard"))
    yield made
    made.close()


async def run(guard: Guard, *turns: Any, **more: Any) -> tuple[Execution, LocalDriver, Script]:
    held = more.pop("hooks", None) or hooks()
    model, driver = Script(list(turns)), LocalDriver(guard)
    async with asyncio.timeout(60):
        execution = await run_visual_task(driver, COMMAND, visual_task(model, **more), held)  # type: ignore[arg-type]
    return execution, driver, model


def tool_results(model: Script, turn: int) -> list[dict[str, Any]]:
    """Return what the model was told about its calls before that turn."""
    return [json.loads(m.content) for m in model.asked[turn] if isinstance(m, ToolResult)]


async def test_it_looks_walks_and_says_what_it_saw(guard: Guard) -> None:
    execution, driver, model = await run(guard, [TURN], [WALK], [DONE])
    assert execution.status == "done"
    assert [s.op for s in driver.steps] == [Op.GET_FRONT_IMAGE, Op.TURN, Op.MOVE, Op.GET_FRONT_IMAGE]
    assert driver.steps[2].speed_mps == 0.3
    first = model.asked[0][0]
    assert isinstance(first, UserMessage)
    assert "go to the red ball, then say what is beside the red ball" in first.text
    assert first.images
    turned, walked = tool_results(model, 2)
    assert turned["measured"]["degrees"] == about_deg(20)
    assert walked["measured"]["distance_m"] == about_m(1.0)
    assert walked["left"]["metres"] == pytest.approx(4.0)
    assert execution.looked is not None
    assert execution.looked.end.saw == ("a blue box",)
    assert [t.tool for t in execution.looked.turns] == ["act_turn", "act_move", "finish"]


NUMBERS = st.one_of(
    st.floats(), st.floats(0, 6), st.integers(-5, 400), st.sampled_from(["1e9", "5", "1 m", None, [], {}])
)
ARGUMENTS = st.fixed_dictionaries(
    {},
    optional={
        "direction": st.sampled_from(["forward", "backward", "left", "right", "up", "", 7]),
        "distance_m": NUMBERS,
        "degrees": NUMBERS,
        "speed_mps": NUMBERS,
        "look": st.sampled_from([True, False, "yes"]),
        "force": st.just(True),
    },
)
NAMES = st.sampled_from(
    ["act_move", "act_turn", "act_hello", "act_backflip", "get_front_image", "act_damp", "shell", "release", ""]
)
FITTING = st.one_of(
    st.builds(
        lambda d, m, look: ("act_move", {"direction": d, "distance_m": m, "look": look}),
        st.sampled_from(["forward", "backward"]), st.floats(0.02, 4), st.booleans(),
    ),
    st.builds(lambda d: ("act_turn", {"direction": "left", "degrees": d}), st.floats(1, 360)),
    st.sampled_from([("act_hello", {}), ("get_front_image", {})]),
)  # fmt: skip
WILD = st.tuples(NAMES, ARGUMENTS | st.just("{not json") | st.none() | st.integers())
ASKED = st.lists(FITTING, min_size=1, max_size=3) | st.lists(FITTING | WILD, min_size=1, max_size=4)
GOALS = st.sampled_from(
    [
        BALL,
        Goal((*BALL.tasks, Subgoal(Aim.STEP, step=Primitive(Op.HELLO)))),
        Goal((Subgoal(Aim.FACE, "door"), Subgoal(Aim.LOOK, where="around"))),
        Goal((Subgoal(Aim.LOOK, "poster"), Subgoal(Aim.STEP, step=Primitive(Op.MOVE, Direction.FORWARD, 1.0)))),
    ]
)
MOSTS = st.builds(
    lambda m, deg, n, photos, mps: Mandate({Op.GET_FRONT_IMAGE: photos}, m, deg, 120.0, n, mps),
    st.sampled_from([0.5, 2.0, 5.0, 30.0]), st.sampled_from([20.0, 360.0, 720.0]), st.integers(2, 22),
    st.integers(1, 10), st.sampled_from([0.05, 0.3, 3.0]),
)  # fmt: skip


@settings(
    max_examples=40, phases=[Phase.explicit, Phase.reuse, Phase.generate],
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)  # fmt: skip
@given(st.lists(ASKED, min_size=6, max_size=14), GOALS, MOSTS)
def test_law_7_what_reaches_the_robot_is_inside_the_mandate_whatever_a_model_calls(
    guard: Guard, script: list[list[Call]], goal: Goal, most: Mandate
) -> None:
    execution, driver, model = asyncio.run(run(guard, *script, goal=goal, most=most, idle=99))
    mandate = visual_task(model, goal, most).mandate
    limits = guard.capabilities.limits
    slack = ROUNDING * 20
    assert execution.status in ("done", "failed")
    assert len(driver.steps) <= mandate.steps
    for op in Op:
        assert sum(s.op is op for s in driver.steps) <= mandate.calls.get(op, 0)
    assert sum(s.distance_m or 0.0 for s in driver.steps) <= min(mandate.distance_m, limits.command_m) + slack
    assert sum(s.degrees or 0.0 for s in driver.steps) <= mandate.degrees + slack
    for step in driver.steps:
        if step.op is Op.MOVE:
            assert step.distance_m is not None
            assert step.speed_mps is not None
            assert 0 < step.distance_m <= limits.step_m
            assert 0 < step.speed_mps <= min(most.speed_mps or 0.0, limits.speed_mps)
        if step.op is Op.TURN:
            assert step.degrees is not None
            assert 0 < step.degrees <= limits.step_deg


# ---------------------------------------------------------------------- every loop ends
async def test_an_endless_loop_ends_by_its_calls(guard: Guard) -> None:
    execution, driver, model = await run(guard, [TURN], most=MOST, calls=6)
    assert execution.status == "failed"
    assert execution.looked is not None
    assert execution.looked.end.why == "calls"
    assert len(driver.steps) == 7
    assert model.offered[-1] == ["finish"]


async def test_a_loop_that_gets_nowhere_ends(guard: Guard) -> None:
    execution, driver, model = await run(guard, [PICTURE])
    assert execution.looked is not None
    assert execution.looked.end.why == "no_progress"
    assert len(driver.steps) == 1
    assert len(model.asked) == 3


@pytest.mark.parametrize(
    ("call", "problem"),
    [
        (("act_fly", {}), "There is no tool act_fly"),
        (("act_move", {"direction": "forward", "distance_m": 10}), "less than or equal to 5"),
        (("act_move", {"direction": "forward", "distance_m": -1}), "greater than or equal to"),
        (("act_move", {"direction": "up", "distance_m": 1}), "Input should be"),
        (("act_backflip", {}), "There is no tool act_backflip"),
        (("act_hello", "{"), "There is no tool act_hello"),
    ],
)
async def test_law_7_a_call_that_is_not_allowed_is_reported_and_not_done(
    guard: Guard, call: Call, problem: str
) -> None:
    execution, driver, model = await run(guard, [call])
    assert [s.op for s in driver.steps] == [Op.GET_FRONT_IMAGE]
    assert execution.status == "failed"
    assert execution.looked is not None
    assert execution.looked.end.why == "no_progress"
    assert all(problem in t.problem for t in execution.looked.turns)
    assert problem in tool_results(model, 1)[0]["problem"]


async def test_law_7_the_way_in_all_is_bounded(guard: Guard) -> None:
    far = ("act_move", {"direction": "backward", "distance_m": 2.0})
    _execution, driver, model = await run(guard, [far], [WALK], [far], [DONE])
    assert sum(s.distance_m or 0.0 for s in driver.steps) == pytest.approx(5.0)
    _execution, driver, model = await run(guard, [far], [far], [far], [DONE])
    assert sum(s.distance_m or 0.0 for s in driver.steps) == pytest.approx(4.0)
    assert "5.00 m in all" in tool_results(model, 3)[-1]["problem"]


async def test_it_ends_when_its_time_is_up_also_in_mid_thought(guard: Guard) -> None:
    execution, _, _model = await run(guard, asyncio.Event(), seconds=0.5)
    assert execution.looked is not None
    assert (execution.status, execution.looked.end.why) == ("failed", "time")


@pytest.mark.parametrize(("kind", "why"), [("budget", "tokens"), ("timeout", "model"), ("server", "model")])
async def test_a_model_that_fails_ends_the_loop(guard: Guard, kind: Any, why: str) -> None:
    execution, _driver, _ = await run(guard, [WALK], ModelError(kind, "it failed"))
    assert execution.looked is not None
    assert (execution.status, execution.looked.end.why, execution.looked.end.fault) == ("failed", why, kind)
    assert execution.looked.turns[0].outcome == "done"


# ---------------------------------------------------------------------- stops and laws between the steps
async def test_law_14_a_stop_in_mid_thought_ends_the_thought_at_once(guard: Guard) -> None:
    never, ended = asyncio.Event(), []
    model, driver = Script([[WALK], never]), LocalDriver(guard)
    looking = asyncio.create_task(
        run_visual_task(driver, COMMAND, visual_task(model), hooks(ended=lambda: ended[0] if ended else None))  # type: ignore[arg-type]
    )
    await asyncio.wait_for(model.thinking.wait(), 60)
    ended.append(EndReason.STOP)
    async with asyncio.timeout(1):
        execution = await looking
    assert execution.status == "stopped"
    assert execution.looked is not None
    assert execution.looked.end.why == "cut"
    assert [t.tool for t in execution.looked.turns] == ["act_move"]


async def test_law_18_a_stop_that_comes_as_the_loop_ends_by_itself_is_told_as_the_stop(guard: Guard) -> None:
    model, driver = Script([[WALK], ModelError("timeout", "it failed")]), LocalDriver(guard)
    held = hooks(ended=lambda: EndReason.STOP if len(model.asked) == 2 else None)
    async with asyncio.timeout(60):
        execution = await run_visual_task(driver, COMMAND, visual_task(model), held)  # type: ignore[arg-type]
    assert execution.status == "stopped"
    assert execution.looked is not None
    assert execution.looked.end.why == "model"


class StopMeetsRenewal(LocalDriver):
    """While the lease is checked, a stop of the same agent ends its renewals."""

    def __init__(self, guard: Guard, stopped: list[EndReason]) -> None:
        super().__init__(guard)
        self.stopped = stopped

    async def lost(self, lease: str) -> LeaseLost | None:
        self.stopped.append(EndReason.STOP)
        return LeaseLost("this client released the lease when it requested a stop")


async def test_law_18_a_stop_that_comes_while_the_lease_is_checked_is_told_as_the_stop(guard: Guard) -> None:
    stopped: list[EndReason] = []
    held = hooks(ended=lambda: stopped[0] if stopped else None)
    task = visual_task(Script([[WALK], asyncio.Event()]))
    async with asyncio.timeout(60):
        execution = await run_visual_task(StopMeetsRenewal(guard, stopped), COMMAND, task, held)  # type: ignore[arg-type]
    assert (execution.status, execution.message) == ("stopped", "")


async def test_law_18_a_lease_that_lapses_in_mid_thought_interrupts_the_command(guard: Guard) -> None:
    model, driver = Script([[WALK], asyncio.Event()]), LocalDriver(guard)
    looking = asyncio.create_task(run_visual_task(driver, COMMAND, visual_task(model), hooks()))  # type: ignore[arg-type]
    await asyncio.wait_for(model.thinking.wait(), 60)
    driver.ended = LeaseLost("the lease lapsed")
    async with asyncio.timeout(2):
        execution = await looking
    assert (execution.status, execution.message) == ("interrupted", "the lease lapsed")


async def test_law_13_a_stop_past_the_forum_ends_the_thought_too(guard: Guard) -> None:
    model, driver = Script([[WALK], asyncio.Event()]), LocalDriver(guard)
    looking = asyncio.create_task(run_visual_task(driver, COMMAND, visual_task(model), hooks()))  # type: ignore[arg-type]
    await asyncio.wait_for(model.thinking.wait(), 60)
    driver.ended = LeaseLost("stopped", "stop", "root at the shell")
    async with asyncio.timeout(2):
        execution = await looking
    assert (execution.status, execution.stopped_by) == ("stopped", "root at the shell")


@pytest.mark.parametrize(
    ("rule", "status"),
    [("command.edited", "cancelled"), ("command.suspended", "cancelled"), ("rights.operator", "refused")],
)
async def test_law_4_rights_and_post_are_asked_for_before_each_step(guard: Guard, rule: str, status: str) -> None:
    asked = 0

    async def permit(_: Plan) -> tuple[Verdict, Capabilities | None]:
        nonlocal asked
        asked += 1
        allowed = Verdict(Decision.ALLOW, "test") if asked < 3 else Verdict(Decision.REFUSE, rule)
        return allowed, guard.capabilities

    execution, driver, _ = await run(guard, [TURN], hooks=hooks(permit=permit))
    assert (execution.status, len(driver.steps)) == (status, 2)
    assert execution.verdict is not None
    assert execution.verdict.rule == rule


async def test_law_16_without_a_stop_channel_nothing_moves(guard: Guard) -> None:
    async def dead() -> bool:
        return False

    execution, driver, _ = await run(guard, [WALK], hooks=hooks(alive=dead))
    assert execution.status == "interrupted"
    assert [s.op for s in driver.steps] == [Op.GET_FRONT_IMAGE]


async def test_a_halted_robot_ends_the_loop(tmp_path: Path) -> None:
    guard = guarded(tmp_path)
    guard.halt("the owner")
    execution, _, _ = await run(guard, [WALK])
    assert execution.status in ("failed", "refused")
    assert [r.outcome for r in execution.results if r.primitive.moves] == [Outcome.REFUSED]
    guard.close()


# ---------------------------------------------------------------------- claims
async def test_law_18_a_claim_of_success_without_moving_is_a_failure(guard: Guard) -> None:
    execution, _, _ = await run(guard, [DONE])
    assert execution.status == "failed"
    assert execution.looked is not None
    assert "0.00 m" in execution.looked.contradicted


async def test_law_18_a_claimed_distance_is_held_against_what_was_measured(guard: Guard) -> None:
    boast = ("finish", {"outcome": "done", "saw": [], "did": "Walked 8 metres to the ball."})
    execution, _, _ = await run(guard, [WALK], [boast])
    assert execution.status == "failed"
    assert execution.looked is not None
    assert "claims 8 m" in execution.looked.contradicted
    honest = ("finish", {"outcome": "done", "saw": [], "did": "Walked 1 m, turned 20° left."})
    execution, _, _ = await run(guard, [TURN], [WALK], [honest])
    assert execution.status == "done"


async def test_law_18_a_named_step_must_have_been_done(guard: Guard) -> None:
    goal = Goal((*BALL.tasks, Subgoal(Aim.STEP, step=Primitive(Op.HELLO))))
    execution, _, _ = await run(guard, [WALK], [DONE], goal=goal)
    assert execution.status == "failed"
    execution, driver, _ = await run(guard, [WALK], [("act_hello", {})], [DONE], goal=goal)
    assert execution.status == "done"
    assert driver.steps[-1].op is Op.HELLO


async def test_words_without_a_call_are_taken_as_unsure_when_they_are_repeated(guard: Guard) -> None:
    execution, _, _model = await run(guard, "I see a ball.", "Really, a ball.")
    assert execution.looked is not None
    assert (execution.looked.end.claim, execution.looked.end.saw) == ("unsure", ("Really, a ball.",))
    assert execution.status == "failed"


async def test_an_obstacle_is_reported_and_another_way_may_be_tried(tmp_path: Path) -> None:
    guard = guarded(tmp_path, obstacles=[[1.2, 0.0, 0.3]])
    execution, _driver, model = await run(
        guard, [WALK], [("act_turn", {"direction": "left", "degrees": 90})], [WALK], [DONE]
    )
    assert tool_results(model, 1)[0]["reason"] == "obstacle"
    assert execution.status == "done"
    guard.close()


async def test_only_the_newest_pictures_are_sent_again(guard: Guard) -> None:
    _, _, model = await run(guard, [WALK], [WALK], [WALK], [DONE])
    pictures = [[bool(m.images) for m in asked if isinstance(m, UserMessage | ToolResult)] for asked in model.asked]
    assert pictures == [[True], [True, True], [False, True, True], [False, False, True, True]]


@pytest.mark.parametrize("language", ["en", "zh"])
def test_the_example_that_it_gives_is_one_that_it_understands(language: str) -> None:
    (example,) = re.findall(r"`([^`]+)`", say("visual.ask", language))
    addressee = Addressee(("quadruped",), (), Capabilities("go2", frozenset(Op)))
    assert goal_of(f"@quadruped {example}", addressee, language) == BALL
