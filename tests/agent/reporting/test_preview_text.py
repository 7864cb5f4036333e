"""The reply to a preview names things, walls and robots, in both languages."""

from __future__ import annotations

import pytest

from agentrob.agent.reporting.preview_text import preview_text
from agentrob.model import Direction, Language, Op, Outcome, Plan, Pose, Primitive
from agentrob.rehearsal.preview import Basis, Preview, RehearsedStep, Run

WALK = Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0)


@pytest.mark.parametrize(
    ("language", "told"),
    [
        ("en", "red ball 0.50 m, a wall 0.60 m, `humanoid` 0.70 m, coffee machine 0.80 m"),
        ("zh", "红色球 0.50 m，墙 0.60 m，`humanoid` 0.70 m，coffee machine 0.80 m"),
    ],
)
def test_things_are_named_in_the_readers_language_where_it_is_known(language: Language, told: str) -> None:
    near = {"red ball": 0.5, "wall": 0.6, "@humanoid": 0.7, "coffee machine": 0.8}
    run = Run(((0, 0), (1, 0)), 2.0, (RehearsedStep(WALK, Outcome.DONE),), near)
    preview = Preview("rex", Basis.SIMULATION, Plan((WALK,)), Pose(0, 0, 0), ((0, 0), (1, 0)), (run,))
    assert told in preview_text(preview, language)
