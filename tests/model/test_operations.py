"""Declarations of operations: what is possible, how they travel, and what follows for a step."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.model import (
    BUILT_IN,
    ActionClass,
    BaseMotion,
    Capabilities,
    Choice,
    Number,
    Op,
    Operation,
    Option,
    Primitive,
    Quantity,
    Unit,
)
from agentrob.model.estimate import step_seconds
from agentrob.model.operations.data import as_data, operation_of

SECONDS = Number("seconds", Unit.SECONDS, 1.0, 10.0, default=3.0)
COLOUR = Choice("colour", (Option("red", {"en": "red", "zh": "红色"}), Option("blue", {"en": "blue", "zh": "蓝色"})))
GLOW = Operation(
    "glow", ActionClass.GESTURE, {"en": "glow {colour}|light up", "zh": "发{colour}光"}, (SECONDS, COLOUR),
    measured=(Quantity("seconds", Unit.SECONDS, 0.5),), takes_s=1.0,
)  # fmt: skip

_names = st.from_regex(r"[a-z][a-z0-9_]{1,20}", fullmatch=True)
_amounts = st.floats(0, 1000, allow_nan=False)
_words = st.text(st.characters(categories=["Ll", "Lo"]), min_size=1, max_size=12)


@st.composite
def operations(draw: st.DrawFn) -> Operation:
    names = draw(st.lists(_names, min_size=1, max_size=4, unique=True))
    arguments: list[Number | Choice] = []
    for name in names:
        if draw(st.booleans()):
            least, most = sorted((draw(_amounts), draw(_amounts)))
            arguments.append(
                Number(name, draw(st.sampled_from(Unit)), least, most, draw(st.sampled_from([None, least])))
            )
        else:
            found = draw(st.lists(_names, min_size=1, max_size=4, unique=True))
            options = tuple(Option(one, {"en": draw(_words), "zh": draw(_words)}) for one in found)
            arguments.append(Choice(name, options, draw(st.sampled_from([None, found[0]]))))
    return Operation(
        draw(_names), draw(st.sampled_from([ActionClass.MOVE, ActionClass.RISKY])), {"en": draw(_words)},
        tuple(arguments), {"en": draw(_words)}, draw(_amounts), draw(_amounts), draw(_amounts), 1.0 + draw(_amounts),
        tuple(Quantity(name, Unit.COUNT, draw(_amounts)) for name in names), draw(st.booleans()),
    )  # fmt: skip


@given(operations())
def test_a_declaration_survives_the_way_over_json(operation: Operation) -> None:
    assert operation_of(json.loads(json.dumps(as_data(operation), allow_nan=False))) == operation


_KEYS = st.sampled_from(["name", "class", "words", "arguments", "options", "unit", "least", "most", "en"])


@given(st.recursive(st.none() | st.text() | st.floats(), lambda inner: st.lists(inner) | st.dictionaries(_KEYS, inner)))
def test_a_malformed_declaration_is_a_value_error(data: Any) -> None:
    with pytest.raises(ValueError, match=r"\w"):
        operation_of(data)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"name": "Blow Bubbles!"}, "'Blow Bubbles!' is not a valid name"),
        ({"words": {"zh": "发光"}}, "needs words in English"),
        ({"words": {"en": "glow||shine"}}, "needs 1 to 60 printable phrases"),
        ({"words": {"en": "glow {brightness}"}}, "has no argument 'brightness'"),
        ({"travel_m": 2.0}, "which stays within 0.3 m, and travels 2 m: declare it as move or risky"),
        ({"free_space_m": float("nan")}, "free_space_m of the operation 'glow' must be a number of at least 0"),
        ({"arguments": (SECONDS, SECONDS)}, "4 arguments of different names"),
    ],
)  # fmt: skip
def test_an_impossible_declaration_says_what_is_wrong(change: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=re.escape(said)):
        replace(GLOW, **change)


def test_bounds_and_defaults_are_checked() -> None:
    with pytest.raises(ValueError, match="must be from 1 to 10 s"):
        Number("seconds", Unit.SECONDS, 1, 10, default=30)
    with pytest.raises(ValueError, match="must be one of red"):
        Choice("colour", COLOUR.options[:1], default="green")


def test_a_robot_has_built_in_operations_and_its_own() -> None:
    can = Capabilities("lamp", frozenset({Op.TURN, Op.HELLO}), declared=(GLOW,))
    assert [one.name for one in can.operations] == ["turn", "hello", "glow"]
    assert (can.operation("glow"), can.operation("hello")) == (GLOW, BUILT_IN["hello"])
    assert can.operation("move") is None


def test_an_operation_that_nobody_declares_is_refused() -> None:
    with pytest.raises(ValueError, match="'fly' is not built in: declare it"):
        Capabilities("drone", frozenset({"fly"}))


@pytest.mark.parametrize(
    ("operation", "said"),
    [
        (replace(BUILT_IN["hello"], action_class=ActionClass.RISKY), "'hello' is built in, as gesture"),
        (replace(GLOW, arguments=(Number("degrees", Unit.DEGREES, 0, 9),), words={"en": "glow"}), "glow_degrees"),
        (replace(GLOW, words={}), "needs words that ask for it"),
        (replace(BUILT_IN["move"], base_motion=BaseMotion.ROTATION), "the same class, arguments and base motion"),
        (replace(GLOW, base_motion=BaseMotion.TRANSLATION), r"only the built-in walk and turn have.*\(travel_m\)"),
    ],
)
def test_a_declaration_that_does_not_fit_the_house_is_refused(operation: Operation, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        Capabilities("lamp", frozenset(), declared=(operation,))


def test_a_built_in_operation_may_be_done_in_a_way_of_its_own() -> None:
    quick = replace(BUILT_IN["hello"], takes_s=2.0)
    can = Capabilities("lamp", frozenset(), declared=(quick,))
    assert can.ops == {"hello"}
    assert step_seconds(Primitive("hello"), can) == 2.0


def test_a_step_knows_its_operation_and_is_compared_without_it() -> None:
    step = Primitive("glow", arguments=GLOW.complete({"colour": "red"}))
    can = Capabilities("lamp", frozenset(), declared=(GLOW,))
    bound = can.bound(step)
    assert bound == step
    assert bound.operation is GLOW
    assert bound.asked() == {"seconds": 3.0, "colour": "red"}
    assert step_seconds(bound, can) == 4.0
    assert step.operation.action_class is ActionClass.RISKY, "where the declaration is not known, the worst is assumed"
    assert Primitive("move").op is Op.MOVE, "also a step that was read from data"


@pytest.mark.parametrize(
    ("values", "wrong"),
    [
        ({"colour": "red"}, None),
        ({}, (COLOUR, None)),
        ({"colour": "green"}, (COLOUR, "green")),
        ({"colour": "red", "seconds": 11.0}, (SECONDS, 11.0)),
        ({"colour": "red", "seconds": float("nan")}, (SECONDS, pytest.approx(float("nan"), nan_ok=True))),
        ({"colour": "red", "size": 1.0}, (None, "size")),
    ],
)
def test_arguments_are_held_against_the_declaration(values: dict[str, Any], wrong: object) -> None:
    assert GLOW.objection(values.items()) == wrong
