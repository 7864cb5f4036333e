"""A question offers at most two sentences; each is made from the post, and is understood wholly when it is posted."""

from __future__ import annotations

import re

import pytest

from agentrob.language.parser.grammar import parse
from agentrob.language.parser.repetition import ParseContext
from agentrob.model import Capabilities, Intent, Limits, Op, Understanding
from tests.language.parser import generated_posts
from tests.language.saying import OPS, read, short
from tests.sizes import size

_BEGIN = {"en": "For example:", "zh": "可以这样说："}
#: What is offered where nothing can be made from a post.
GENERAL = {"en": "walk forward 1 m, then turn left 90 degrees", "zh": "向前走1米，然后向左转90度"}

#: What is offered for a motion whose amount is not understood.
USUAL = {"F1", "B1", "L1", "R1", "l90", "r90"}


def offers(understood: Understanding) -> list[str]:
    return re.findall("`([^`]*)`", understood.question.rpartition(_BEGIN[understood.language])[2])


OFFERED = {
    "every day at 9 wave": ["wave"],
    "每天九点挥手": ["打个招呼"],
    "lead the visitors to room 12": [GENERAL["en"]],
    "at 5 pm walk forward": [GENERAL["en"]],
    "go to the red ball": [GENERAL["en"]],
    "take the second right": [GENERAL["en"]],
    "walk forward 3, then wave": ["walk forward 3 m, then wave"],
    "wave, then walk forward": ["wave, then walk forward 1 m"],
    "forward 2 m, then find the door": ["walk forward 2 m"],
    "walk 1 m and tell me the temperature": ["walk forward 1 m"],
    "sit and stand 2 times": [
        "sit down, then stand up 2 times",
        "sit down, then stand up, then sit down, then stand up",
    ],
    "walk 1 m, but wave first": ["wave, then walk forward 1 m"],
    "wave, wait 3 seconds, sit down": ["wave, then sit down"],
    "twenty to your left": ["turn left 20 degrees", "walk left 0.2 m"],
    "前进两米，把那个箱子打开": ["向前走2米"],
}


@pytest.mark.parametrize(("text", "said"), OFFERED.items())
def test_what_is_offered_is_made_from_the_post(text: str, said: list[str]) -> None:
    understood = read(text)
    assert understood.intent is Intent.ASK_BACK
    assert offers(understood) == said


def test_an_offered_sentence_is_understood_wholly_and_does_nothing_that_the_post_does_not_name() -> None:
    for post in generated_posts.posts(size(1_200, 10_000), seed=5):
        understood = read(post.text)
        if understood.intent is not Intent.ASK_BACK:
            continue
        found = offers(understood)
        assert 1 <= len(found) <= 2, understood.question
        for sentence in found:
            again = read(sentence)
            assert again.intent is Intent.COMMAND, (post.text, sentence)
            if not post.plans or {"remark", "purpose", "denial"} & set(post.constructs):
                continue  # these may be taken for actions that are not understood
            named = {step for plan in post.plans for step in plan}
            invented = set(short(again.plan).split()) - named - USUAL
            assert not invented or sentence == GENERAL[understood.language], (post.text, sentence)


def test_what_is_offered_is_within_the_limits_of_the_robot() -> None:
    small = Capabilities("x", frozenset(Op), Limits(step_m=0.5, command_m=1.0, command_steps=2))
    for text in ("walk forward 3 m, then find the door", "wave, clap, sit, and open the door", "walk forward"):
        understood = parse(text, ["quadruped"], [], OPS, ParseContext(can=small))
        for sentence in offers(understood):
            steps = parse(sentence, ["quadruped"], [], OPS).plan.steps
            assert len(steps) <= 2
            assert all((step.distance_m or 0) <= 0.5 for step in steps)
