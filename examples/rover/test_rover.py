"""The rover keeps the contract that every robot keeps."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from agentrob_rover import Rover

from agentrob import Direction, Op, Outcome, Primitive, Robot, RobotConfig, RobotContract, go_on

SETTINGS = RobotConfig(model="rover", simulated=True)


class TestRover(RobotContract):
    @pytest.fixture
    def robot(self) -> Iterator[Robot]:
        rover = Rover(SETTINGS)
        yield rover
        rover.close()


def test_it_cannot_go_sideways_and_says_so() -> None:
    assert Direction.LEFT not in Rover.describe(SETTINGS).move_directions
    result = Rover(SETTINGS).step(Primitive(Op.MOVE, Direction.LEFT, distance_m=0.5), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "unsupported")
    assert result.message == "A rover cannot move left."
