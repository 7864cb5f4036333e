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
    assert "60 s" in (mandate_violation(mandate_of(Plan((WALK, WALK)), GO2), [done(WALK, seconds=61)], WALK) or "")


def test_a_failed_attempt_counts_and_a_skipped_one_does_not() -> None:
    mandate = mandate_of(Plan((WALK,)), GO2)
    assert mandate_violation(mandate, [done(WALK, outcome=Outcome.FAILED)], WALK) is not None
    assert mandate_violation(mandate, [done(WALK, outcome=Outcome.SKIPPED)], WALK) is None


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
