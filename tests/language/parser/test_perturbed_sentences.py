"""A flood of bent sentences: nothing raises, and what is bent never moves further than what was written."""

from __future__ import annotations

import json
import random
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from markdown_it import MarkdownIt

from agentrob.language.parser.grammar import parse
from agentrob.language.parser.repetition import ParseContext
from agentrob.language.visible_text import visible_text
from agentrob.model import Direction, Intent, Op, Plan, Primitive
from tests.sizes import size

SEEDS = (
    "@rex walk forward 2 metres, then turn left 90 degrees and take a photo",
    "@rex please go back half a metre, wave, and turn around twice",
    "@rex don't turn, just walk one and a half m slowly at 0.3 m/s",
    "@rex 向前走一米五，然后左转九十度，拍张照片",
    "@rex 后退两百厘米，别转弯，再打个招呼",
    "@rex turn left, no wait, right, then walk for two seconds and do it again twice",
    "@rex trun rigth 30 degress, repeat that four times and come back; never mind",
    "@rex 前进两米，不对，后退三米，重复两次，再回来，算了",
    "stop @rex, 停, ½ m ² ４５° “walk” — 12,5 m",
)
EVERYTHING = frozenset(Op)
THREAD = ParseContext(history=(Plan((Primitive(Op.MOVE, Direction.FORWARD, distance_m=60.0),)),))
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


#: What others found to trip programs, beside what only looks like a command.
NAUGHTY = (
    "", " ", "\x00", "undefined", "NaN", "1e309 m", "0x10 m", "\u0663 m", "walk \uff11\uff12\uff13 m",
    "\u03a9\u2248\xe7", "\ufe0f\U0001f47e \U0001f647", "1\u20440 m", "<script>alert(1)</script>",
    "${jndi:ldap://x}", "'; DROP TABLE posts;--", "../../etc/passwd", "\ufdfd" * 50,
    "Z\u032e\u031e\u0320\u0359" * 9, "test\u2060test\u202b", "%s %d {0} {name}", "\ufeff walk 1 m", "\ufb01ve m",
    "walk " + "9" * 400 + " m", "walk ." + "9" * 400 + " m", "turn 1/" + "9" * 400, "一" * 300, "百" * 300,
    "one hundred " * 60, "ninety nine thousand " * 30, "don't " * 100, "and " * 200, "no wait " * 100,
    "walk 1 m, do it again twice " * 60, "wave 99 times, do this 99 times " * 40, "1/0 m", "1/3 m", "\xbd" * 3,
    "turn left " * 90, "@rex " * 100, "[quote]" * 100, "*a " * 200, "<" * 300, "`" * 301,
)  # fmt: skip
#: The limits are those of the machine of docs/safety/figures.md (median text 0.26 ms); a slower one has more in
#: proportion. Where the same code took 0.70 ms, `yardstick_s` was 3.4 ms.
YARDSTICK_S = 0.0034 * 0.26 / 0.70
TYPICAL_S, WORST_S = 0.005, 0.020


def inputs(count: int, seed: int) -> Iterator[str]:
    chance = random.Random(seed)
    rows = (Path(__file__).parents[1] / "asks_back.jsonl").read_text(encoding="utf-8").splitlines()
    sources = [*SEEDS, *(json.loads(row)["text"] for row in rows)]
    yield from NAUGHTY
    for _ in range(count):
        yield bent(chance.choice(sources if chance.random() < 0.9 else NAUGHTY), chance)


def yardstick_s() -> float:
    """Process time of a job that is none of ours: how slow this machine is now."""
    taken = []
    for _ in range(9):
        begin = time.process_time()
        MarkdownIt("commonmark").parse("Walk *forward* 1 m, then `turn` [left](/x).\n\n- and **wave**\n" * 20)
        taken.append(time.process_time() - begin)
    return sorted(taken)[4]


def spent_s(text: str) -> float:
    """Process time of reading a post, checking what came of it."""
    begin = time.process_time()
    understood = parse(visible_text(text), ("rex",), ("max",), EVERYTHING, THREAD)
    spent = time.process_time() - begin
    for step in understood.plan.steps:
        assert step.distance_m is None or 0 < step.distance_m <= 100, text
        assert step.degrees is None or 0 < step.degrees <= 3600, text
    assert len(understood.plan.steps) <= 100, text
    assert bool(understood.plan.steps) == (understood.intent is Intent.COMMAND), text
    return spent


def flood(count: int, seed: int) -> None:
    for text in SEEDS:
        spent_s(text)  # what is imported at its first use
    spent = []
    for text in inputs(count, seed):
        taken = spent_s(text)
        # A slow text is slow each time; a busy machine is not.
        spent.append(min([taken, *(spent_s(text) for _ in range(3))]) if taken > TYPICAL_S else taken)
    spent.sort()
    slowness = max(1.0, yardstick_s() / YARDSTICK_S)
    assert spent[int(len(spent) * 0.99)] <= TYPICAL_S * slowness
    assert spent[-1] <= WORST_S * slowness


def test_thousands_of_bent_sentences_never_raise_and_are_read_quickly() -> None:
    flood(2_000, seed=5)


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_tens_of_thousands_of_bent_sentences_never_raise_and_are_read_quickly() -> None:
    flood(size(30_000, 100_000), seed=4)


@pytest.mark.parametrize(
    "unit", [text + " " for text in (*SEEDS, "百", "一百零", "no wait ", "again ", "nin degree ", "'", "1/3 ")]
)
def test_time_grows_no_faster_than_the_text(unit: str) -> None:
    def taken(chars: int) -> float:
        text = (f"{unit} " * chars)[:chars]
        return min(spent_s(text) for _ in range(5))

    taken(200)
    assert taken(1900) <= 19 * max(taken(190), 0.0002)
