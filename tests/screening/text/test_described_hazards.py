"""Law 7: hazards that a post describes are compared with the path of its plan, to the decimetre."""

from __future__ import annotations

import math

import pytest

from agentrob.language.registry import language_of
from agentrob.model import ActionClass, Decision, Direction, Op, Plan, Primitive
from agentrob.model.operations.declaration import Operation
from agentrob.screening.text.described_hazards import UNKNOWN, clauses, first_hazard_met, hazard_in_path, placed

FORWARD, BACKWARD, LEFT, RIGHT = Direction.FORWARD, Direction.BACKWARD, Direction.LEFT, Direction.RIGHT


def move(direction: Direction, distance_m: float) -> Primitive:
    return Primitive(Op.MOVE, direction, distance_m=distance_m)


def turn(direction: Direction, degrees: float) -> Primitive:
    return Primitive(Op.TURN, direction, degrees=degrees)


def met(text: str, *steps: Primitive) -> str | None:
    """Return the rule of the first described hazard to which these steps lead."""
    hazard = first_hazard_met(text, Plan(steps), language_of(text))
    return hazard.rule if hazard else None


# ---------------------------------------------------------------------- how far
@pytest.mark.parametrize(
    ("text", "passes_m", "reaches_m"),
    [
        ("a child is 2 m in front of you", 1.6, 1.7),  # 35 cm before it, the robot's front end is 10 cm from it
        ("2 m in front of you is a child", 1.6, 1.7),
        ("there is a wall 2 m in front of you", 1.6, 1.7),
        ("there's a wall in 2 m", 1.6, 1.7),
        ("the stairs begin 2 m ahead", 1.6, 1.7),
        ("前面两米有楼梯", 1.6, 1.7),
        ("the stairs are right in front of you", 0.1, 0.2),  # taken for half a metre
        ("there is a hole in front of you", 0.2, 0.3),  # no distance is said
        ("there is a child 20 cm in front of you", 0.0, 0.05),
        ("the stairs are 2 m away", 1.6, 1.7),  # where is not said: ahead
    ],
)
def test_law_7_a_walk_to_a_described_hazard_is_refused_and_one_that_ends_before_it_is_not(
    text: str, passes_m: float, reaches_m: float
) -> None:
    assert met(text, move(FORWARD, reaches_m)) is not None
    assert met(text, turn(LEFT, 90), move(RIGHT, reaches_m)) is not None  # the same way
    if passes_m:
        assert met(text, move(FORWARD, passes_m)) is None


@pytest.mark.parametrize(
    ("where", "towards", "across"),
    [
        ("in front of you", FORWARD, LEFT),
        ("behind you", BACKWARD, LEFT),
        ("on your left", LEFT, FORWARD),
        ("on your right", RIGHT, BACKWARD),
    ],
)
def test_law_7_a_path_passes_a_hazard_on_one_side_at_eighty_centimetres(
    where: str, towards: Direction, across: Direction
) -> None:
    text = f"there is a child 1 m {where}"
    assert met(text, move(towards, 1.1)) == "way.somebody"
    assert met(text, move(across, 0.7), move(towards, 1.1)) == "way.somebody"
    assert met(text, move(across, 0.9), move(towards, 1.1)) is None
    assert met(text, move(across, 3)) is None


def test_law_7_a_turn_changes_which_way_is_ahead() -> None:
    text = "there is a child 1 m on your left"
    assert met(text, turn(LEFT, 90), move(FORWARD, 1)) == "way.somebody"
    assert met(text, turn(RIGHT, 90), move(FORWARD, 1)) is None
    assert met(text, turn(RIGHT, 90), move(BACKWARD, 1)) == "way.somebody"
    assert met(text, turn(LEFT, 45), turn(LEFT, 45), move(FORWARD, 1)) == "way.somebody"
    assert met(text, turn(LEFT, 180), move(RIGHT, 1)) == "way.somebody"
    assert met(text, turn(LEFT, 90)) is None


@pytest.mark.parametrize(
    ("where", "towards", "away"),
    [
        ("in front of you", FORWARD, BACKWARD),
        ("behind you", BACKWARD, FORWARD),
        ("on your left", LEFT, RIGHT),
        ("on your right", RIGHT, LEFT),
    ],
)
def test_law_7_moves_are_added_up(where: str, towards: Direction, away: Direction) -> None:
    text = f"there is a child 2 m {where}"
    assert met(text, move(towards, 0.3)) is None
    assert met(text, *[move(towards, 0.6)] * 2) is None
    assert met(text, *[move(towards, 0.6)] * 3) == "way.somebody"
    assert met(text, move(away, 1), move(towards, 2.5)) is None
    assert met(text, move(towards, 1.8), move(away, 1.8)) == "way.somebody"


def test_law_7_a_walk_across_meets_what_lies_between_its_ends() -> None:
    steps = move(LEFT, 2), move(FORWARD, 2), move(RIGHT, 4)
    assert met("there is a child 1 m in front of you", *steps[:2]) is None
    assert met("there is a child 1 m in front of you", *steps) == "way.somebody"


def test_a_step_without_a_finite_amount_leads_nowhere() -> None:
    text = "there is a child 2 m in front of you"
    assert met(text, move(FORWARD, math.inf)) is None
    assert met(text, Primitive(Op.MOVE, FORWARD)) is None
    assert met(text, Primitive(Op.MOVE, distance_m=3)) is None
    assert met(text, Primitive(Op.TURN, LEFT), move(FORWARD, 1)) is None


def own(travel_m: float) -> Primitive:
    """An operation that a robot declares, and that leaves its place."""
    return Primitive("roam", declared=Operation("roam", ActionClass.MOVE, travel_m=travel_m))


def test_law_7_an_operation_that_leaves_its_place_may_go_any_way() -> None:
    near, far = "there is a child 1.3 m {}", "there is a child 1.4 m {}"
    for where in ("in front of you", "behind you", "on your left"):
        assert met(near.format(where), own(1.0)) == "way.somebody"
        assert met(far.format(where), own(1.0)) is None
    assert met(near.format("behind you"), own(0.2), own(1.0)) == "way.somebody"
    assert met("there is a child behind you", own(0.1)) == "way.somebody"
    assert met("there is a child behind you", own(0.0)) is None
    assert met(far.format("in front of you"), own(0.1), move(FORWARD, 1)) is None


# ---------------------------------------------------------------------- where the robot stands
def test_law_7_nothing_moves_above_or_beneath_somebody() -> None:
    text = "somebody lies under you"
    assert met(text, move(FORWARD, 0.1)) == "way.somebody"
    assert met(text, turn(LEFT, 10)) == "way.somebody"
    assert met(text, Primitive(Op.HELLO)) == "way.somebody"
    assert met(text, Primitive(Op.GET_FRONT_IMAGE)) is None


def test_law_7_a_robot_on_a_table_does_not_walk_off_it() -> None:
    assert met("you are on a table", move(FORWARD, 0.1)) == "way.drop"
    assert met("you are on a table", turn(LEFT, 90)) is None
    assert met("you are on a table", Primitive(Op.HELLO)) is None
    assert met("you are on a table", Primitive(Op.HELLO), Primitive(Op.BACKFLIP)) == "way.drop"
    assert met("the table you are on is only 2 m", move(FORWARD, 1.6)) is None
    assert met("the table you are on is only 2 m", move(BACKWARD, 1.7)) == "way.drop"
    assert met("the table you are on is only 2 m", move(LEFT, 1.2), move(FORWARD, 1.2)) == "way.drop"
    assert met("the table you are on is only 2 m", move(LEFT, 1.1), move(FORWARD, 1.1)) is None


# ---------------------------------------------------------------------- what is said
def test_a_thing_without_a_distance_is_left_to_the_sensors() -> None:
    assert met("there is a wall in front of you", move(FORWARD, 3)) is None
    assert met("there is a wall right in front of you", move(FORWARD, 3)) == "way.thing"


def test_what_is_unknown_is_asked_about_and_comes_last() -> None:
    unknown, known = "there is a contraption right in front of you", "a child is behind you"
    assert met(unknown, move(FORWARD, 1)) == UNKNOWN
    assert met(f"{unknown}. {known}", move(BACKWARD, 1)) == "way.somebody"
    assert met(f"{unknown}. {known}", move(FORWARD, 1), move(BACKWARD, 2)) == "way.somebody"
    verdicts = [hazard_in_path(text, Plan((move(FORWARD, 1), move(BACKWARD, 2))), "en") for text in (unknown, known)]
    assert [verdict and verdict.decision for verdict in verdicts] == [Decision.ASK_BACK, Decision.REFUSE]
    assert all(verdict and "`" in verdict.reason for verdict in verdicts)


def test_an_unknown_place_without_a_verb_says_nothing() -> None:
    assert met("the thing in front", move(FORWARD, 1)) is None


def test_a_hazard_and_its_place_in_two_clauses_belong_together() -> None:
    assert met("There is a child. It is right in front of you.", move(FORWARD, 1)) == "way.somebody"
    assert met("There is a robot. It is 5 m in front of you. There is a child.", move(FORWARD, 1)) is None
    # A clause that names its own hazard, or that has been placed, does not lend its place to the next one.
    assert met("There is a child. A wall is 0.5 m in front of you.", move(FORWARD, 1)) == "way.thing"
    assert met("A child is behind you. A contraption is right in front of you.", move(FORWARD, 1)) == UNKNOWN
    assert met("On your left. A contraption is right in front of you.", move(FORWARD, 1)) == UNKNOWN
    assert met("There is a wall. A contraption is in front of you.", move(FORWARD, 1)) == UNKNOWN


def test_law_7_after_a_motion_a_hazard_is_where_the_robot_may_be_by_then() -> None:
    text = "walk forward 2 m, turn left, then a child is 1 m in front of you"
    assert met(text, move(FORWARD, 2), turn(LEFT, 90), move(FORWARD, 1.1)) == "way.somebody"
    assert met(text, move(FORWARD, 0.5), turn(LEFT, 90), move(FORWARD, 0.5)) is None
    # Said before any motion, it is where the robot is now.
    text = "a child is 1 m in front of you, walk backward 2 m, walk forward 1.1 m"
    assert met(text, move(BACKWARD, 2), move(FORWARD, 1.1)) is None


def test_a_distance_that_is_said_counts_also_for_what_is_close() -> None:
    assert met("a child is 2 m directly in front of you", move(FORWARD, 1.6)) is None


def test_what_is_away_but_no_hazard_or_not_away_is_in_nobody_s_way() -> None:
    assert met("the kitchen is 2 m away", move(FORWARD, 3)) is None
    assert met("a child with 2 m of rope", move(FORWARD, 3)) is None
    assert met("only my child is here", move(FORWARD, 3)) is None


def test_a_size_is_no_distance() -> None:
    assert met("there is a hole in front of you, 2 m deep", move(FORWARD, 1)) == "way.drop"
    assert met("there is a 2 m deep hole in front of you", move(FORWARD, 1)) == "way.drop"
    assert met("there is a hole 2 m in front of you", move(FORWARD, 1)) is None


def test_a_distance_that_the_plan_walks_may_be_a_command() -> None:
    # 前面五米 may be read as "five metres ahead" or as "walk five metres".
    assert met("前面五米是墙", move(FORWARD, 5)) == UNKNOWN
    assert met("前面五米是墙", move(FORWARD, 5), turn(LEFT, 90)) == UNKNOWN
    assert met("前面五米是墙", move(FORWARD, 6)) == "way.thing"


@pytest.mark.parametrize(
    "text",
    [
        "there is no child in front of you",
        "the child in front of you has moved",
        "take a photo of the child in front of you",
        "wave to the child in front of you",
        "walk to the child in front of you",
        "stop at the edge of the carpet in front of you",
        "前面没有人",
    ],
)
def test_what_is_absent_or_only_looked_at_is_in_nobody_s_way(text: str) -> None:
    assert met(text, move(FORWARD, 1)) is None


def test_law_7_what_is_greeted_before_a_walk_is_in_its_way() -> None:
    assert met("hello, say hi to the child in front of you, walk forward 1 m", move(FORWARD, 1)) == "way.somebody"
    assert met("walk forward 1 m, say hi to the child in front of you", move(FORWARD, 1)) is None


# ---------------------------------------------------------------------- clauses
def test_clauses_have_their_positions_and_none_is_empty() -> None:
    text = "walk 1.5 m,, and then  wave . stop"
    found = list(clauses(text))
    assert [clause.said for clause in found] == ["walk 1.5 m", "wave", "stop"]
    assert all(text[clause.start : clause.end].strip() == clause.said for clause in found)


def test_only_a_known_hazard_with_a_direction_is_placed() -> None:
    assert placed("a child is behind you")
    assert not placed("a child is here")
    assert not placed("a contraption is behind you")
    assert not placed("a child is under you")


SEPARATORS = [
    ", ",
    ". ",
    " - ",
    " — ",
    "… ",
    " (",
    " / ",
    " + ",
    " & ",
    " | ",
    " 🙂 ",
    ' "',
    " because ",
    " although ",
    " ",
]


@pytest.mark.parametrize("between", SEPARATORS)
@pytest.mark.parametrize(
    ("command", "hazard", "rule"),
    [
        ("walk 1 m", "there is a child in front of you", "way.somebody"),
        ("walk 1 m", "you are on a table", "way.drop"),
        ("walk back 1 m", "the stairs are behind you", "way.drop"),
    ],
)
def test_law_7_a_hazard_is_found_whatever_stands_between_it_and_the_command(
    command: str, hazard: str, rule: str, between: str
) -> None:
    step = move(BACKWARD if "back" in command else FORWARD, 1.0)
    assert met(f"{command}{between}{hazard}", step) == rule
    assert met(f"{hazard}{between}{command}", step) == rule


@pytest.mark.parametrize("between", ["，", "。", "（", "——", "、", " ", "因为", ""])
def test_law_7_a_hazard_is_found_without_a_pause_in_chinese(between: str) -> None:
    assert met(f"走一米{between}你在桌上", move(FORWARD, 1.0)) == "way.drop"
    assert met(f"走一米{between}前面有个孩子", move(FORWARD, 1.0)) == "way.somebody"
    if between != "因为":
        assert met(f"前面有个孩子{between}走一米", move(FORWARD, 1.0)) == "way.somebody"
