"""Values that cross the driver's socket are decoded as they were encoded."""

from __future__ import annotations

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.errors import RobotError
from agentrob.model import (
    ActionResult,
    Capabilities,
    Direction,
    Limits,
    Op,
    Outcome,
    Pose,
    Primitive,
    RobotState,
    StopResult,
)
from agentrob.robots import codec

numbers = st.floats(allow_nan=False, allow_infinity=False)
primitives = st.builds(
    Primitive,
    st.sampled_from(list(Op)),
    st.none() | st.sampled_from(list(Direction)),
    st.none() | numbers,
    st.none() | numbers,
    st.none() | numbers,
)
results = st.builds(
    ActionResult,
    primitives,
    st.sampled_from(list(Outcome)),
    st.dictionaries(st.text(), numbers),
    st.text(),
    st.text(),
    numbers,
    numbers,
    st.lists(st.tuples(numbers, numbers, numbers, numbers)).map(tuple),
    st.none() | st.binary(),
    st.booleans(),
    st.lists(st.tuples(numbers, numbers, numbers, numbers)).map(tuple),
)


@given(primitives)
def test_a_primitive_survives(primitive: Primitive) -> None:
    assert codec.decode_primitive(json.loads(json.dumps(codec.encode(primitive)))) == primitive


@given(results)
def test_a_result_survives_with_its_picture(result: ActionResult) -> None:
    assert codec.decode_result(json.loads(json.dumps(codec.encode(result)))) == result


def test_a_state_that_never_came_is_infinitely_old() -> None:
    encoded = json.dumps(codec.encode(RobotState(age_s=math.inf)), allow_nan=False)
    assert codec.decode_state(json.loads(encoded)) == RobotState(age_s=math.inf)


def test_state_capabilities_and_stop_survive() -> None:
    state = RobotState(0.1, Pose(1, 2, 3), (0.1, 0.2), 0.3, "idle", 50, (1, None, 2, None), True, True, False, 100)
    assert codec.decode_state(json.loads(json.dumps(codec.encode(state)))) == state
    capabilities = Capabilities("x", frozenset(Op), Limits(speed_mps=0.2), frozenset({Direction.FORWARD}), True)
    assert codec.decode_capabilities(json.loads(json.dumps(codec.encode(capabilities)))) == capabilities
    stop = StopResult(1.5, False, True, None, "no")
    assert codec.decode_stop(json.loads(json.dumps(codec.encode(stop)))) == stop


@pytest.mark.parametrize("data", [None, 3, {}, {"op": "Fly!"}, {"op": 3}, {"op": "move", "distance_m": "far"}])
def test_nonsense_is_an_error_that_says_what_was_found(data: object) -> None:
    with pytest.raises(RobotError, match="found"):
        codec.decode_primitive(data)
