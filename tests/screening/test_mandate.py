"""Law 7: a screened command is a mandate, and nothing beyond it is carried out."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.model import ActionResult, Capabilities, Direction, Limits, Mandate, Op, Outcome, Plan, Primitive
from agentrob.model.estimate import seconds_of
from agentrob.screening.mandate import mandate_of, mandate_violation

GO2 = Capabilities("go2", frozenset(Op))
WALK = Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0)
TURN = Primitive(Op.TURN, Direction.LEFT, degrees=90.0)
WAVE = Primitive(Op.HELLO)
STEPS = st.sampled_from([WALK, TURN, WAVE, Primitive(Op.MOVE, Direction.BACKWARD, distance_m=0.1)])


def done(step: Primitive, seconds: float = 1.0, outcome: Outcome = Outcome.DONE) -> ActionResult:
    return ActionResult(step, outcome, started_s=10.0, ended_s=10.0 + seconds)


@given(st.lists(STEPS, max_size=12))
def test_a_plan_is_within_its_own_mandate_and_no_step_more(steps: list[Primitive]) -> None:
    mandate = mandate_of(Plan(tuple(steps)), GO2)
    used: list[ActionResult] = []
    for step in steps:
        assert mandate_violation(mandate, used, step) is None
        used.append(done(step))
    assert mandate_violation(mandate, used, WAVE) is not None


def test_another_operation_is_refused() -> None:
    assert "hello 0 times" in (mandate_violation(mandate_of(Plan((WALK, WALK)), GO2), [done(WALK)], WAVE) or "")


def test_a_longer_walk_is_refused() -> None:
    mandate = mandate_of(Plan((WALK, WALK)), GO2)
    longer = Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.5)
    assert "2.50 m" in (mandate_violation(mandate, [done(WALK)], longer) or "")
    assert "180°" in (
        mandate_violation(mandate_of(Plan((TURN,)), GO2), [], Primitive(Op.TURN, Direction.LEFT, degrees=180.0)) or ""
    )


def test_an_amount_that_is_no_number_is_refused() -> None:
    step = Primitive(Op.MOVE, Direction.FORWARD, distance_m=float("nan"))
    assert mandate_violation(mandate_of(Plan((WALK,)), GO2), [], step) is not None


def test_time_used_up_is_refused() -> None:
    assert "60 s" in (mandate_violation(mandate_of(Plan((WALK, WALK)), GO2), [done(WALK, seconds=60)], WALK) or "")
    assert mandate_violation(mandate_of(Plan((WALK, WALK)), GO2), [done(WALK, seconds=59.9)], WALK) is None


def test_a_failed_attempt_counts_and_a_skipped_one_does_not() -> None:
    mandate = mandate_of(Plan((WALK,)), GO2)
    assert mandate_violation(mandate, [done(WALK, outcome=Outcome.FAILED)], WALK) is not None
    assert mandate_violation(mandate, [done(WALK, outcome=Outcome.SKIPPED)], WALK) is None


@pytest.mark.parametrize(
    ("step", "allowed"),
    [
        (Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.00009), True),
        (Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.00015), False),
        (Primitive(Op.TURN, Direction.LEFT, degrees=90.00009), True),
        (Primitive(Op.TURN, Direction.LEFT, degrees=90.00015), False),
    ],
)
def test_law_7_only_a_rounding_error_is_beyond_a_sum(step: Primitive, allowed: bool) -> None:
    assert (mandate_violation(mandate_of(Plan((WALK, TURN)), GO2), [], step) is None) is allowed


def test_law_7_a_mandate_has_no_amounts_that_its_plan_does_not_name() -> None:
    assert mandate_of(Plan((WALK, WAVE)), GO2) == Mandate(
        {Op.MOVE: 1, Op.HELLO: 1}, distance_m=1.0, degrees=0.0, seconds=60.0, steps=2
    )


@pytest.mark.parametrize(
    ("step", "why"),
    [
        (Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.5, speed_mps=0.3), None),
        (Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.5, speed_mps=0.31), "0.3 m/s at most"),
        (Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.5), "0.3 m/s at most"),
        (TURN, None),
    ],
)
def test_law_7_each_walk_of_a_mandate_with_a_speed_states_one_within_it(step: Primitive, why: str | None) -> None:
    mandate = Mandate({Op.MOVE: 1, Op.TURN: 1}, distance_m=1.0, degrees=90.0, steps=2, speed_mps=0.3)
    violation = mandate_violation(mandate, [], step)
    assert violation is None if why is None else why in (violation or "")


def test_law_7_motions_are_counted_and_pictures_are_none() -> None:
    picture = Primitive(Op.GET_FRONT_IMAGE)
    mandate = Mandate(dict.fromkeys(Op, 9), distance_m=9.0, degrees=900.0, steps=9, motions=2)
    assert mandate_violation(mandate, [done(WALK), done(picture)], TURN) is None
    assert "2 motions" in (mandate_violation(mandate, [done(WALK), done(TURN)], WALK) or "")
    assert mandate_violation(mandate, [done(WALK), done(TURN)], picture) is None


@pytest.mark.parametrize(
    "step",
    [
        Primitive(Op.MOVE, Direction.FORWARD),
        Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.0),
        Primitive(Op.MOVE, Direction.FORWARD, distance_m=-1.0),
        Primitive(Op.TURN, Direction.LEFT),
        Primitive(Op.MOVE, None, distance_m=0.5),
        Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.5, degrees=9.0),
        Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.5, speed_mps=float("inf")),
        Primitive(Op.TURN, Direction.FORWARD, degrees=9.0),
        Primitive(Op.TURN, Direction.LEFT, degrees=9.0, distance_m=0.5),
        Primitive(Op.HELLO, degrees=9.0),
    ],
)
def test_law_7_a_step_that_is_no_step_is_within_no_mandate(step: Primitive) -> None:
    mandate = Mandate(dict.fromkeys(Op, 9), distance_m=9.0, degrees=900.0, steps=9)
    assert "is not a valid step" in (mandate_violation(mandate, [], step) or "")


def test_an_empty_mandate_allows_nothing() -> None:
    assert mandate_violation(Mandate(), [], WAVE) is not None


@given(st.lists(STEPS, max_size=6), STEPS)
def test_more_steps_never_take_less_time(steps: list[Primitive], more: Primitive) -> None:
    assert seconds_of(Plan((*steps, more)), GO2) > seconds_of(Plan(tuple(steps)), GO2)


def test_a_slower_walk_takes_longer() -> None:
    slow = Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0, speed_mps=0.1)
    assert seconds_of(Plan((slow,)), GO2) > 10
    assert seconds_of(Plan((WALK,)), Capabilities("g1", frozenset(Op), Limits(speed_mps=0.1))) > 10


@pytest.mark.parametrize(
    ("step", "measured_s"),
    [
        (Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.25), 9.3),
        (Primitive(Op.MOVE, Direction.FORWARD, distance_m=2.0), 14.1),
        (Primitive(Op.TURN, Direction.LEFT, degrees=15.0), 8.4),
        (Primitive(Op.TURN, Direction.LEFT, degrees=360.0), 18.4),
    ],
)
def test_a_step_of_the_g1_is_not_thought_to_take_much_less_than_it_does(step: Primitive, measured_s: float) -> None:
    """The times are means of `benchmarks/accuracy.py --robot g1`, at the speeds that the driver allows."""
    g1 = Capabilities("g1", frozenset(Op), Limits(speed_mps=0.2, turn_dps=28.6))
    assert 0.95 * measured_s < seconds_of(Plan((step,)), g1) < 1.6 * measured_s
