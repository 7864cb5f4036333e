"""Routines never leave a robot's limits, and figures close; sizes and counts that do not fit are answered."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.language.parser.grammar import parse
from agentrob.language.parser.repetition import ParseContext
from agentrob.language.routines import Routine, largest_size_m, most_times, steps_of, usual_size_m
from agentrob.model import Account, Capabilities, Decision, Direction, Intent, Limits, Op, Plan, Primitive, Role
from agentrob.screening.screen import screen

GO2 = Capabilities("go2", frozenset(Op) - {Op.CLAP, Op.SHAKE}, Limits(), simulated=True)
G1 = Capabilities("g1", frozenset({Op.MOVE, Op.TURN, Op.HELLO, Op.CLAP}), Limits(speed_mps=0.2, turn_dps=28.6))
FIGURES = (Routine.SQUARE, Routine.CIRCLE, Routine.CIRCLE_RADIUS, Routine.PATROL)
OPERATOR = Account("1", "alice", role=Role.OPERATOR)

limits = st.builds(
    Limits,
    speed_mps=st.floats(0.1, 1.0),
    turn_dps=st.floats(10, 90),
    step_m=st.floats(0.2, 6),
    step_deg=st.floats(20, 400),
    command_m=st.floats(0.5, 12),
    command_s=st.floats(5, 120),
    command_steps=st.integers(1, 30),
)
robots = st.builds(
    Capabilities, st.sampled_from(["go2", "g1", "fake"]), st.frozensets(st.sampled_from(list(Op))), limits,
    st.frozensets(st.sampled_from(list(Direction))), st.booleans(),
)  # fmt: skip


def end_of(steps: list[Primitive]) -> tuple[float, float, float]:
    """Return where a robot that does the steps exactly ends, from where it began."""
    x = y = yaw = 0.0
    for step in steps:
        if step.op is Op.MOVE and step.direction is not None:
            ahead, left = (side * (step.distance_m or 0.0) for side in step.direction.unit_vector)
            x += ahead * math.cos(yaw) - left * math.sin(yaw)
            y += ahead * math.sin(yaw) + left * math.cos(yaw)
        elif step.op is Op.TURN:
            yaw += math.radians(step.degrees or 0.0) * (1 if step.direction is Direction.LEFT else -1)
    return x, y, math.remainder(yaw, math.tau)


@given(st.sampled_from(list(Routine)), robots, st.none() | st.floats(0.05, 25), st.integers(1, 6))
def test_a_routine_is_within_the_limits_and_passes_the_screen_or_is_none(
    routine: Routine, can: Capabilities, size_m: float | None, times: int
) -> None:
    steps = steps_of(routine, can, size_m, times)
    if steps:
        verdict = screen(Plan(tuple(steps)), text="play", author=OPERATOR, capabilities=can, language="en")
        assert verdict.decision is Decision.ALLOW, verdict


@given(st.sampled_from(list(Routine)), robots, st.integers(1, 4))
def test_the_usual_size_fits_where_any_size_does(routine: Routine, can: Capabilities, times: int) -> None:
    if largest_size_m(routine, can, times):
        assert steps_of(routine, can, usual_size_m(routine, can, times), times)


@given(st.sampled_from(FIGURES), st.floats(0.1, 3.0), st.integers(1, 3))
def test_a_figure_ends_where_and_as_it_began(routine: Routine, size_m: float, times: int) -> None:
    wide = Capabilities("fake", frozenset(Op), Limits(command_m=1e3, command_s=1e4, command_steps=99, step_m=99))
    x, y, yaw = end_of(steps_of(routine, wide, size_m, times))
    assert math.hypot(x, y) < 0.01
    assert abs(yaw) < 0.001


def test_a_dance_ends_facing_as_it_began_and_has_gestures_of_this_robot() -> None:
    for can in (GO2, G1):
        steps = steps_of(Routine.DANCE, can)
        assert end_of(steps) == pytest.approx((0, 0, 0), abs=1e-9)
        assert {step.op for step in steps} > {Op.TURN}
        assert {step.op for step in steps} <= can.ops


def test_a_circle_has_as_many_sides_as_the_limits_allow() -> None:
    more = Capabilities("go2", GO2.ops, Limits(command_steps=20, command_s=120))
    assert len(steps_of(Routine.CIRCLE, GO2)) == 10
    assert len(steps_of(Routine.CIRCLE, more)) == 20


def test_the_largest_size_fits_and_a_larger_one_does_not() -> None:
    for routine in FIGURES:
        largest = largest_size_m(routine, GO2)
        assert steps_of(routine, GO2, largest)
        assert not steps_of(routine, GO2, largest + 0.15)
    assert not steps_of(Routine.PATROL, GO2, 1.0, most_times(Routine.PATROL, GO2, 1.0) + 1)


def ask(text: str, can: Capabilities = GO2) -> tuple[Intent, str, tuple[Primitive, ...]]:
    understood = parse(f"@dog {text}", ["dog"], [], can.ops, ParseContext(can=can))
    return understood.intent, understood.question, understood.plan.steps


SQUARE_1 = tuple(steps_of(Routine.SQUARE, GO2, 1.0))


@pytest.mark.parametrize(
    "text",
    [
        "walk a square with sides of 1 m", "walk a square of 1 m", "walk a 1 m square", "please walk a 1 metre square!",
        "walk in a square of 100 cm", "could you walk a square with a side of 1 m?", "走一个一米的正方形",
        "走个边长一米的正方形", "请走一个边长为1米的正方形",
    ],
)  # fmt: skip
def test_the_size_of_a_square_is_said_in_many_ways(text: str) -> None:
    assert ask(text)[2] == SQUARE_1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("walk a square with sides of 3 m", "sides of at most 2.5 m here"),
        ("walk a 9 m square", "sides of at most 2.5 m here"),
        ("walk a circle of 8 m", "at most 3.5 m across here"),
        ("walk a circle with a radius of 8 m", "a radius of at most 1.7 m here"),
        ("patrol 8 m", "at most 5 m out and back here"),
        ("patrol 9 times", "at most 2 times here"),
        ("走一个边长三米的正方形", "边长最多2.5米"),
        ("巡逻九圈", "最多2次"),
    ],
)
def test_a_size_or_count_beyond_the_limits_is_answered_with_what_would_be_valid(text: str, said: str) -> None:
    intent, question, steps = ask(text)
    assert intent is Intent.ASK_BACK
    assert said in question
    assert steps == ()


def test_a_slow_robot_says_that_a_square_does_not_fit() -> None:
    intent, question, _ = ask("walk a square", G1)
    assert intent is Intent.ASK_BACK
    assert "does not fit my abilities and limits here (10 steps, 10 m and 60 s a command)" in question


@pytest.mark.parametrize(
    "text",
    [
        "don't dance", "do not walk a square", "never dance", "why do you dance?", "do you like to dance?", "dance?",
        "when will you patrol?", "别跳舞", "不要跳舞", "你会跳舞吗", "I love to dance", "my dog can dance",
        "walk in a circle around the table", "patrol the room", "dance if I wave", "walk a square, no",
        "dance for an hour", "walk a square of 1", "绕着桌子走一圈", "dance on the table",
        "walk a square or a circle",
    ],
)  # fmt: skip
def test_what_is_no_whole_request_for_a_routine_moves_nothing(text: str) -> None:
    intent, _, steps = ask(text)
    assert intent is not Intent.COMMAND
    assert steps == ()


def test_a_routine_stands_beside_other_steps_and_takes_a_speed() -> None:
    wave = Primitive(Op.HELLO)
    assert ask("wave, walk a square of 1 m and wave")[2] == (wave, *SQUARE_1, wave)
    slow = ask("walk a square slowly")[2]
    assert {step.speed_mps for step in slow if step.op is Op.MOVE} == {0.2}


ROUTINES = (
    "dance", "dance twice", "patrol", "patrol 1 m", "walk a square",
    "walk a square of 0.4 m", "walk in a circle",
    "跳舞", "跳支舞", "巡逻", "巡逻一米", "巡逻两圈", "走一个正方形", "转圈跳舞",
)  # fmt: skip
FURTHER = {
    "en": (
        "forward 1 m", "walk forward 1 m", "back 50 cm", "left 90 degrees", "turn right", "1 m", "2 m left", "forward",
        "wave", "sit down", "walk 1 m so i can see better", "90 degrees", "go left 1 m and wave",
    ),
    "zh": (
        "前进一米", "向前走一米", "后退50厘米", "左转90度", "右转", "一米", "往左走两米", "向前", "挥手", "坐下",
        "再前进一米",
    ),
}  # fmt: skip
JOINED = {"en": (", ", " and ", ", then ", " ", ". ", "; "), "zh": ("，", "然后", "，再", "", "。", "并")}


@pytest.mark.parametrize("first", ROUTINES)
def test_law_18_what_follows_a_routine_is_done_after_it_or_nothing_is(first: str) -> None:
    """The motions after a routine are never dropped, but a length may be the size of a figure that has none yet."""
    language = "en" if first.isascii() else "zh"
    alone = ask(first)[2]
    for joint in JOINED[language]:
        for further in FURTHER[language]:
            intent, _, steps = ask(first + joint + further)
            sized = further in ("1 m", "一米") and steps in ONE_METRE
            assert sized or steps in ((*alone, *ask(further)[2]), ()), first + joint + further
            assert (intent is Intent.COMMAND) == bool(steps)


ONE_METRE = [tuple(steps_of(routine, GO2, 1.0)) for routine in FIGURES]
