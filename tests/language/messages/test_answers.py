"""The answer to an impossible request says why, quotes all of its words, and says what would work."""

from __future__ import annotations

import pytest

from agentrob.language.parser.grammar import parse
from agentrob.model import Intent, Op
from tests.language.saying import read

EYES = {
    "往前走到门口": "往前走到门口",
    "前进到沙发旁边": "前进到沙发旁边",
    "往窗户那边走一米": "往窗户那边",
    "go over to the door": "go over to the door",
    "walk 2 m to the door": "walk 2 m to the door",
    "follow me": "follow me",
    "walk 2 m towards the wall": "walk 2 m towards the wall",
    "move out of the way": "move out of the way",
    "walk 2 m towards me": "walk 2 m towards me",
}
HANDS = {"把报纸拿来": "把报纸拿来", "唱首歌": "唱首歌", "fetch me a beer": "fetch me a beer", "bow to us": "bow to us"}
PATHS = {
    "walk in a triangle": "walk in a triangle",
    "zig zag forward": "zig zag forward",
    "往东走两米": "往东",
    "斜着走一米": "斜着",
}
WAITS = {
    "等五秒再挥手": ("等五秒", "打个招呼"),
    "挥手，等三秒，再坐下": ("等三秒", "打个招呼，然后坐下"),
    "休息十秒然后坐下": ("休息十秒", "坐下"),
    "wave, wait 3 seconds, sit down": ("wait 3 seconds", "wave, then sit down"),
    "rest for ten seconds, then wave": ("rest for ten seconds", "wave"),
    "take a photo in 5 seconds": ("5 seconds", "take a photo"),
}


def question(text: str) -> str:
    understood = read(text)
    assert understood.intent is Intent.ASK_BACK
    return understood.question


@pytest.mark.parametrize(("text", "words"), EYES.items())
def test_places_and_things_need_eyes(text: str, words: str) -> None:
    assert f"`{words}`" in question(text)
    assert "vision model" in question(text) or "视觉模型" in question(text)


@pytest.mark.parametrize(("text", "words"), HANDS.items())
def test_what_needs_hands_or_a_voice_is_answered_with_what_the_robot_can_do(text: str, words: str) -> None:
    assert question(text).startswith((f"`{words}`: I cannot do that. I can: ", f"`{words}`：这我做不了。我会："))
    only = parse(text, ["quadruped"], [], frozenset({Op.MOVE, Op.SIT})).question
    assert "I can: walk, sit down." in only or "我会：走、坐下。" in only


@pytest.mark.parametrize(("text", "words"), PATHS.items())
def test_curves_and_the_compass_are_no_ways(text: str, words: str) -> None:
    assert question(text).startswith((f"`{words}`: I cannot follow curves", f"`{words}`：我不会走弯路"))


@pytest.mark.parametrize("text", WAITS)
def test_who_cannot_wait_says_so_and_offers_the_rest(text: str) -> None:
    words, rest = WAITS[text]
    asked = question(text)
    assert asked.startswith((f"`{words}`: I cannot wait", f"`{words}`：我不会等待"))
    assert f"For example: `{rest}`" in asked or f"可以这样说：`{rest}`" in asked


@pytest.mark.parametrize(
    ("text", "words"),
    [("5秒后前进一米", "5秒后"), ("等五秒后前进一米", "等五秒后"), ("一会儿前进一米", "一会儿")],
)
def test_a_time_to_begin_at_is_answered_as_waiting(text: str, words: str) -> None:
    assert question(text).startswith(f"`{words}`：我不会等待")


@pytest.mark.parametrize(
    ("text", "examples"),
    [
        ("twenty to your left", "`turn left 20 degrees` · `walk left 0.2 m`"),
        ("walk 20 to the left", "`walk left 0.2 m`"),
        ("walk forward 3", "`walk forward 3 m`"),
        ("往前走三", "`向前走3米`"),
        ("left", "`turn left 90 degrees` · `walk left 1 m`"),
        ("90", "`turn left 90 degrees` · `walk forward 0.9 m`"),
    ],
)
def test_a_number_without_a_unit_is_offered_with_likely_ones(text: str, examples: str) -> None:
    assert f"For example: {examples}" in question(text) or f"可以这样说：{examples}" in question(text)


@pytest.mark.parametrize(
    ("text", "words"), [("往前走两三步", "往前走两三步"), ("the same but slower", "the same but slower")]
)
def test_the_whole_of_what_is_unclear_is_quoted(text: str, words: str) -> None:
    assert f"`{words}`" in question(text)
