"""A flood of bent sentences: nothing raises, and what is bent never moves further than what was written."""

from __future__ import annotations

import random

import pytest

from agentrob.language.grammar import parse
from agentrob.language.visible import visible_text
from agentrob.model import Op

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]

SEEDS = (
    "@rex walk forward 2 metres, then turn left 90 degrees and take a photo",
    "@rex please go back half a metre, wave, and turn around twice",
    "@rex don't turn, just walk one and a half m slowly at 0.3 m/s",
    "@rex 向前走一米五，然后左转九十度，拍张照片",
    "@rex 后退两百厘米，别转弯，再打个招呼",
    "stop @rex, 停, ½ m ² ４５° “walk” — 12,5 m",
)
ODD = "\u200b\u202e@#*_`~>[]()<&;:,.、，。！?½²０９一半両兩百零-—\n\t'\"\\/%°m"


def bent(sentence: str, chance: random.Random) -> str:
    letters = list(sentence)
    for _ in range(chance.randint(1, 8)):
        at = chance.randrange(len(letters) + 1)
        match chance.randrange(4):
            case 0:
                letters.insert(at, chance.choice(ODD))
            case 1:
                letters[at:at] = chance.choice(SEEDS)[chance.randrange(20) :][: chance.randrange(30)]
            case 2:
                del letters[at : at + chance.randrange(6)]
            case _:
                other = chance.randrange(len(letters) + 1)
                letters[at:at], letters[other:other] = letters[other : other + 4], letters[at : at + 4]
    return "".join(letters)


def test_a_hundred_thousand_bent_sentences_never_raise_and_stay_within_bounds() -> None:
    chance = random.Random(4)
    everything = frozenset(Op)
    for _ in range(100_000):
        text = bent(chance.choice(SEEDS), chance)
        plan = parse(visible_text(text), ("rex",), ("max",), everything).plan
        for step in plan.steps:
            assert step.distance_m is None or 0 < step.distance_m <= 100, text
            assert step.degrees is None or 0 < step.degrees <= 3600, text
        assert len(plan.steps) <= 100, text
