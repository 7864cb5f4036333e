"""Law 7: the mandate of a goal; no step beyond it is allowed, whatever a model requests."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from agentrob.language.goal import Aim, Goal, Subgoal
from agentrob.model import ActionResult, Capabilities, Direction, Limits, Mandate, Op, Outcome, Primitive
from agentrob.screening.mandate import ROUNDING, goal_mandate, mandate_violation

GO2 = Capabilities("go2", frozenset(Op))
MOST = Mandate({Op.GET_FRONT_IMAGE: 8}, distance_m=5.0, degrees=720.0, seconds=120.0, steps=12, speed_mps=0.3)
BALL = Subgoal(Aim.APPROACH, "ball", "red")
AMOUNTS = st.none() | st.floats() | st.floats(-10, 20)
STEPS = st.builds(
    Primitive, st.sampled_from(Op), st.none() | st.sampled_from(Direction), distance_m=AMOUNTS, degrees=AMOUNTS,
    speed_mps=AMOUNTS,
)  # fmt: skip
SENSIBLE = st.one_of(
    st.builds(lambda m, d: Primitive(Op.MOVE, d, m, speed_mps=0.2), st.floats(0.01, 3), st.sampled_from(Direction)),
    st.builds(lambda deg: Primitive(Op.TURN, Direction.LEFT, degrees=deg), st.floats(1, 360)),
    st.sampled_from([Primitive(Op.HELLO), Primitive(Op.GET_FRONT_IMAGE)]),
)
MANDATES = st.builds(
    Mandate,
    st.dictionaries(st.sampled_from(Op), st.integers(0, 6)),
    distance_m=st.floats(0, 10),
    degrees=st.floats(0, 720),
    seconds=st.floats(0, 60),
    steps=st.integers(0, 12),
    speed_mps=st.none() | st.floats(0.05, 1),
    motions=st.none() | st.integers(0, 8),
)


def test_law_7_walking_to_a_thing_allows_walks_turns_and_pictures_and_nothing_else() -> None:
    mandate = goal_mandate(Goal((BALL, Subgoal(Aim.LOOK, "ball", "red", "beside"))), MOST, GO2)
    assert set(mandate.calls) == {Op.MOVE, Op.TURN, Op.GET_FRONT_IMAGE}
    assert (mandate.distance_m, mandate.degrees, mandate.speed_mps) == (5.0, 720.0, 0.3)


def test_law_7_who_has_only_to_look_does_not_walk() -> None:
    assert set(goal_mandate(Goal((Subgoal(Aim.LOOK),)), MOST, GO2).calls) == {Op.GET_FRONT_IMAGE}
    around = goal_mandate(Goal((Subgoal(Aim.LOOK, where="around"), Subgoal(Aim.FACE, "door"))), MOST, GO2)
    assert set(around.calls) == {Op.TURN, Op.GET_FRONT_IMAGE}
    assert around.distance_m == 0.0


def test_named_steps_are_in_the_mandate_as_often_as_they_are_named() -> None:
    walk = Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0)
    goal = Goal((Subgoal(Aim.STEP, step=walk), Subgoal(Aim.LOOK), Subgoal(Aim.STEP, step=Primitive(Op.HELLO))))
    mandate = goal_mandate(goal, MOST, GO2)
    assert mandate.calls == {Op.MOVE: 1, Op.HELLO: 1, Op.GET_FRONT_IMAGE: 8}
    assert mandate.distance_m == 1.0


def test_law_7_turns_and_pictures_of_a_goal_are_those_that_it_names_and_the_owner_allows() -> None:
    turn = Primitive(Op.TURN, Direction.LEFT, degrees=90.0)
    named = Goal((Subgoal(Aim.STEP, step=turn), Subgoal(Aim.LOOK)))
    assert goal_mandate(named, MOST, GO2).degrees == 90.0
    assert goal_mandate(Goal((Subgoal(Aim.LOOK),)), MOST, GO2).degrees == 0.0
    hello = Goal((Subgoal(Aim.STEP, step=Primitive(Op.HELLO)),))
    assert goal_mandate(hello, MOST, GO2).degrees == 0.0
    assert goal_mandate(hello, Mandate(distance_m=5.0, steps=12), GO2).calls == {Op.HELLO: 1}, "no picture is allowed"


def test_law_7_who_is_to_stand_beside_a_thing_walks() -> None:
    goal = Goal((Subgoal(Aim.APPROACH, "ball", "red", "beside"),))
    assert set(goal_mandate(goal, MOST, GO2).calls) == {Op.MOVE, Op.TURN, Op.GET_FRONT_IMAGE}


def test_law_10_without_a_speed_of_the_owner_the_robot_s_limit_holds() -> None:
    assert goal_mandate(Goal((BALL,)), Mandate(distance_m=5.0, steps=12), GO2).speed_mps == 0.5


def test_law_10_a_mandate_stays_within_the_limits_of_a_command() -> None:
    small = Capabilities("go2", frozenset(Op), Limits(command_m=2.0, command_s=30.0, speed_mps=0.1, command_steps=4))
    mandate = goal_mandate(Goal((BALL,)), MOST, small)
    assert (mandate.distance_m, mandate.seconds, mandate.speed_mps, mandate.motions) == (2.0, 30.0, 0.1, 4)


@given(MANDATES, st.lists(STEPS | SENSIBLE, max_size=20))
def test_law_7_what_is_carried_out_is_inside_of_any_mandate(mandate: Mandate, asked: list[Primitive]) -> None:
    used: list[ActionResult] = []
    for step in asked:
        if mandate_violation(mandate, used, step) is None:
            used.append(ActionResult(step, Outcome.DONE, started_s=1.0, ended_s=2.0))
    done = [r.primitive for r in used]
    assert len(done) <= mandate.steps
    assert sum(s.moves for s in done) <= (math.inf if mandate.motions is None else mandate.motions)
    assert all(sum(s.op is op for s in done) <= mandate.calls.get(op, 0) for op in Op)
    slack = ROUNDING * (1 + len(done))
    assert sum(s.distance_m or 0.0 for s in done) <= mandate.distance_m + slack
    assert sum(s.degrees or 0.0 for s in done) <= mandate.degrees + slack
    for step in done:
        if step.op is Op.MOVE:
            assert step.distance_m is not None
            assert 0 < step.distance_m <= mandate.distance_m + slack
            assert mandate.speed_mps is None or (step.speed_mps is not None and step.speed_mps <= mandate.speed_mps)


@given(MANDATES, st.floats(max_value=0))
def test_law_7_walking_backwards_by_a_negative_amount_wins_no_room(mandate: Mandate, amount: float) -> None:
    assert (
        mandate_violation(mandate, [], Primitive(Op.MOVE, Direction.FORWARD, distance_m=amount, speed_mps=0.1))
        is not None
    )
    assert mandate_violation(mandate, [], Primitive(Op.TURN, Direction.LEFT, degrees=amount)) is not None
