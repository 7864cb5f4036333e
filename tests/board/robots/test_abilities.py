"""The chips of a robot's page: what this robot can do within its limits, each with a post that asks for it."""

from __future__ import annotations

from agentrob.board.robots.abilities import abilities_of
from agentrob.model import Capabilities, Direction, Limits, Op

DOG = Capabilities("go2", frozenset(Op), Limits())
SLOW = Capabilities("g1", frozenset({Op.MOVE, Op.TURN, Op.CLAP}), Limits(speed_mps=0.2, turn_dps=28.6))
ARM = Capabilities("arm", frozenset({Op.HELLO}))


def chips(can: Capabilities, *, sees: bool = False) -> list[str]:
    return [words for words, _ in abilities_of("rex", can, sees=sees)]


def test_a_robot_that_can_walk_and_turn_offers_routines_and_the_way_home() -> None:
    assert chips(DOG)[-5:] == ["dance", "walk a square", "walk in a circle", "patrol", "come home"]
    assert ("walk a square", "@rex walk a square") in abilities_of("rex", DOG)


def test_what_does_not_fit_the_limits_is_not_offered() -> None:
    assert chips(SLOW) == ["walk", "turn", "clap", "dance", "patrol", "come home"]
    assert chips(ARM) == ["wave"]


def test_only_a_robot_with_a_camera_and_a_detector_offers_to_find_things() -> None:
    eyes = ["turn to the red ball", "what colours do you see"]
    assert chips(DOG, sees=True)[-2:] == eyes
    assert ("what colours do you see", "@rex what colours do you see?") in abilities_of("rex", DOG, sees=True)
    assert not set(eyes) & set(chips(DOG))
    assert not set(eyes) & set(chips(SLOW, sees=True))


def test_a_robot_that_cannot_walk_ahead_does_not_offer_to_come_home() -> None:
    sideways = Capabilities("crab", frozenset({Op.MOVE, Op.TURN}), move_directions=frozenset({Direction.LEFT}))
    assert "come home" not in chips(sideways)
    assert "patrol" not in chips(sideways)
