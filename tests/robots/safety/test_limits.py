"""Law 10: where exactly the limits of a step are."""

from __future__ import annotations

import pytest

from agentrob.model import Capabilities, Direction, Op, Primitive
from agentrob.robots.safety.limits import beyond_limits
from tests.robots.guard_scene import move, turn

GO2 = Capabilities("go2", frozenset(Op))


@pytest.mark.parametrize(
    "primitive",
    [move(5.0), move(0.01), move(1.0, speed_mps=0.5), move(1.0, speed_mps=0.05), turn(360.0), turn(1.0)],
)
def test_law_10_a_step_at_a_limit_is_allowed(primitive: Primitive) -> None:
    assert beyond_limits(primitive, GO2) is None


@pytest.mark.parametrize(
    ("primitive", "code"),
    [
        (move(5.001), "limit_step_m"),
        (move(0.009), "invalid"),
        (move(1.0, speed_mps=0.501), "limit_speed_mps"),
        (move(1.0, speed_mps=0.049), "invalid"),
        (turn(360.1), "limit_step_deg"),
        (turn(0.9), "invalid"),
        (Primitive(Op.TURN, Direction.LEFT), "invalid"),
    ],
)
def test_law_10_a_step_slightly_beyond_a_limit_is_not(primitive: Primitive, code: str) -> None:
    assert (beyond_limits(primitive, GO2) or ("", ""))[0] == code


def test_a_direction_that_the_robot_does_not_have_is_refused_with_those_it_has() -> None:
    forward_only = Capabilities("cart", frozenset(Op), move_directions=frozenset({Direction.FORWARD}))
    assert beyond_limits(move(1.0, Direction.LEFT), forward_only) == (
        "unsupported",
        "This robot cannot move left; it can: forward.",
    )
    assert beyond_limits(move(1.0), forward_only) is None
