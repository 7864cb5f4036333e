"""People put right what they say: corrections, mistyped words, "never mind". What is unclear then moves nothing."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.language.parser.lexicon import misspellings
from agentrob.model import Intent, Plan
from tests.language.saying import read, short

CORRECTED = [
    ("turn left, no wait, right", "r90"),
    ("turn left 90 degrees, no wait, right", "r90"),
    ("turn left no right ninety degrees", "r90"),
    ("Turn left 90 degrees. No, turn right.", "r90"),
    ("turn left 45 degrees, I mean 60 degrees", "l60"),
    ("walk forward 2 m, no, 3 m", "F3"),
    ("Go ahead 4 feet. Oh wait, make that 3 feet.", "F0.9144"),
    ("turn right, wait, no, left", "l90"),
    ("turn right. No! Left!", "l90"),
    ("walk forward 2 - no, 3 metres", "F3"),
    ("walk forward two, er, three metres", "F3"),
    ("go left, I mean right, 1 metre", "R1"),
    ("前进两米，啊不对，一米五", "F1.5"),
    ("往左，不是，往右转", "r90"),
    ("walk forward 2 meters, sorry, I meant backwards", "B2"),
    ("walk back 2 m, no, walk 3 m", "B3"),
    ("walk 1 m, turn left 90 degrees, no, turn right", "F1 r90"),
    ("walk 1 m, no wait, turn left 90 degrees", "l90"),
    ("wave, no wait, sit", "sit"),
    ("walk 1 m and turn left, no, turn right and wave", "F1 r90 hello"),
    ("no, turn left 90 degrees", "l90"),
    ("actually turn left 90 degrees", "l90"),
    ("左转，不对，是右边", "r90"),
    ("左转九十度，不对，右转", "r90"),
    ("向左转90度，不是左边，是右边", "r90"),
    ("前进两米，不，三米", "F3"),
    ("前进两米，不对，后退两米", "B2"),
    ("向前走一米，哦不，一米五", "F1.5"),
]


@pytest.mark.parametrize(("text", "plan"), CORRECTED)
def test_a_correction_takes_the_place_of_what_it_corrects(text: str, plan: str) -> None:
    assert short(read(text).plan) == plan


UNCLEAR = """
turn left 90 degrees, no wait|walk 1 m and turn left 90 degrees, no wait, 2 m
turn left and walk 1 m, no wait, turn right and walk 1 m|walk 2 m, no, 45 degrees|walk 1 m, no wait, wave|no turn left
no turning|turn left 90 degrees, scratch that|Turn left 90 degrees. Never mind.|turn left 90 degrees, never mind
walk 1 m, actually take a photo|walk forward two, three metres|turn right. No!|walk 2 m, no, 3
turn left no further|左转90度，不对|左转90度，算了|左转。算了吧
"""


@pytest.mark.parametrize("text", [t for line in UNCLEAR.strip().splitlines() for t in line.split("|")])
def test_an_unclear_correction_moves_nothing_and_asks(text: str) -> None:
    understood = read(text)
    assert understood.intent is Intent.ASK_BACK
    assert understood.plan == Plan()


def test_a_bare_turn_that_was_corrected_is_told_with_its_correction() -> None:
    assert read("turn left, no wait, right").plan.notes == ("`turn left, no wait, right` had no angle: taken as 90°.",)


@pytest.mark.parametrize(
    ("text", "plan", "wrong"),
    [
        ("walk foward 2 m", "F2", "foward"),
        ("trun left 30 degrees", "l30", "trun"),
        ("turn rigth 30 degrees", "r30", "rigth"),
        ("walk backwrad 1 m", "B1", "backwrad"),
        ("take a pciture", "photo", "pciture"),
    ],
)
def test_slips_of_typing_are_read_and_told(text: str, plan: str, wrong: str) -> None:
    understood = read(text)
    assert short(understood.plan) == plan
    assert any(f"`{wrong}` was read as" in note for note in understood.plan.notes)


@pytest.mark.parametrize(
    "text", ["talk forward 2 m", "turn light 30 degrees", "walk 2 maters", "dnot walk 1 m", "tern left"]
)
def test_other_words_are_no_slips(text: str) -> None:
    assert read(text).intent is Intent.ASK_BACK


@given(st.sampled_from(["forward", "right", "left", "turn", "walk", "metres", "degrees", "photo"]))
def test_a_slip_keeps_first_letters_and_differs(word: str) -> None:
    slips = misspellings(word)
    assert slips
    assert word not in slips
    assert all(set(slip) <= set(word) and abs(len(slip) - len(word)) <= 1 for slip in slips)
