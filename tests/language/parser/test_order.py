"""Clauses that are said out of the order of doing, restarts, and other ways to say a plain command."""

from __future__ import annotations

import pytest

from agentrob.language.parser.repetition import ParseContext
from agentrob.model import Direction, Intent, Plan
from tests.language.saying import read, short, walk

DONE = {
    "take a picture after you have moved 2 m forward": "F2 photo",
    "wave but only after you've turned around": "l180 hello",
    "prior to sitting, turn left 90 degrees": "l90 sit",
    "take a photo before turning left 90 degrees": "photo l90",
    "as soon as you finish walking forward 5 feet, take a photo": "F1.524 photo",
    "take a photo then again take a photo after turning right 20": "photo r20 photo",
    "would you mind turning left 90 degrees and taking a picture?": "l90 photo",
    "it would be great if you turned left 90 degrees and took a picture": "l90 photo",
    "I'd love it if you walked 1 m": "F1",
    "how about you took a photo": "photo",
    "it's time you turned around": "l180",
    "step 1: turn right 90. step 2: 2 m forward. step 3: picture.": "r90 F2 photo",
    "turn left ninety degrees and when you're done turning take a picture": "l90 photo",
    "take a picture without moving": "photo",
    "no walking please, only wave": "hello",
    "instead of sitting down, wave": "hello",
    "don't move, just take a photo": "photo",
    "stay where you are and take a picture": "photo",
    "give the kids a wave": "hello",
    "turn left, never mind, just take a picture": "photo",
    "Dance! No, on second thought, stretch.": "stretch",
    "go forward 3 feet... actually make it 5": "F1.524",
    "forward maybe two feet": "F0.6096",
    "left 45, forward 1.5 m, left 45": "l45 F1.5 l45",
    "do a 180 then another 180": "l180 l180",
    "go 1m50 forward": "F1.5",
    "a dozen inches back please": "B0.3048",
    "Rover, sit. Good boy!": "sit",
    "Benny!! Benny turn around!!": "l180",
    "turn left at an angle of ninety degrees": "l90",
}
ASKED = """
sit and stand 2 times|walk 1 m and after turning left 90, wave|walk 1 m, after turning left 90 wave
when you turn left, take a photo|walk forward 2 m once the light turns green|after the door opens, walk 1 m
turn around and go back 2 m|stay where you are and walk 1 m|walk 2 m to rover|juggle, walk 1 m
walk 1 m while singing|walk 2 m, no, 3|left 45
"""


@pytest.mark.parametrize(("text", "plan"), DONE.items())
def test_a_command_in_other_words_becomes_the_plan_that_is_meant(text: str, plan: str) -> None:
    understood = read(text)
    assert understood.intent is Intent.COMMAND, understood.question
    assert short(understood.plan) == plan


@pytest.mark.parametrize("text", [text for line in ASKED.strip().splitlines() for text in line.split("|")])
def test_law_18_an_order_that_is_not_certain_is_asked_about(text: str) -> None:
    assert read(text).intent is Intent.ASK_BACK


def test_what_never_mind_leaves_out_is_told() -> None:
    assert "Left out as a remark: `turn left, never mind`." in read("turn left, never mind, just wave").plan.notes


def test_one_more_foot_goes_where_the_last_walk_went() -> None:
    assert short(read("one more foot").plan) == "F0.3048"
    back = ParseContext(history=(Plan((walk(Direction.BACKWARD, 1.0),)),))
    assert short(read("one more foot", back).plan) == "B0.3048"
