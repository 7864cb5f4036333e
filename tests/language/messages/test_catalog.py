"""Robots speak every language equally, repeat people's words harmlessly, and their help tells the truth."""

from __future__ import annotations

import re
from string import Formatter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.eyes.colours import ColourDetector
from agentrob.language.messages.catalog import QUOTE_CHARS, quote, say
from agentrob.language.messages.help import examples, help_text, thread_examples
from agentrob.language.parser.grammar import parse
from agentrob.language.parser.repetition import ParseContext
from agentrob.language.registry import known
from agentrob.language.visible_text import OMITTED, mentions, visible_text
from agentrob.minds.protocol import Addressee
from agentrob.minds.visual_loop.goal import goal_of
from agentrob.minds.visual_loop.pursuit import without_model
from agentrob.model import Capabilities, Direction, Intent, Language, Limits, Op, Plan, Primitive

LANGUAGES: list[Language] = ["en", "zh"]
BOOKS = {language: known()[language].sentences for language in LANGUAGES}


def _placeholders(text: str) -> set[str]:
    return {name for _, name, _, _ in Formatter().parse(text) if name is not None}


def test_both_languages_have_the_same_sentences() -> None:
    assert BOOKS["en"].keys() == BOOKS["zh"].keys()


@pytest.mark.parametrize("key", BOOKS["en"])
def test_both_languages_fill_in_the_same_values(key: str) -> None:
    assert _placeholders(BOOKS["en"][key]) == _placeholders(BOOKS["zh"][key])


def test_an_unknown_sentence_or_a_missing_value_is_an_error() -> None:
    with pytest.raises(KeyError):
        say("no.such", "en")
    with pytest.raises(KeyError):
        say("ask.words", "en")


@given(st.text())
def test_quoted_words_command_and_mention_nobody(words: str) -> None:
    quoted = quote(words)
    assert len(quoted) <= QUOTE_CHARS + 2
    assert quoted.count("`") == 2
    assert "\n" not in quoted
    assert mentions(quoted) == ()
    assert visible_text(f"I said {quoted} now") == f"I said {OMITTED} now"


ROBOTS = [
    Capabilities("go2", frozenset(Op)),
    Capabilities("fake", frozenset({Op.MOVE, Op.GET_FRONT_IMAGE}), Limits(step_m=0.5)),
    Capabilities("g1", frozenset({Op.TURN, Op.HELLO}), move_directions=frozenset({Direction.FORWARD})),
    Capabilities("still", frozenset({Op.HEART})),
]


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("robot", ROBOTS, ids=lambda r: r.model)
def test_every_example_of_the_help_is_understood_as_what_it_stands_for(robot: Capabilities, language: Language) -> None:
    text = help_text(robot, "quadruped", language, sees=True)
    said = re.findall(r"^- `(.*)`$", text, re.MULTILINE)
    wanted = examples(robot)
    assert len(said) >= len(wanted)
    for sentence, step in zip(said, wanted, strict=False):
        understood = parse(sentence, ["quadruped"], [], robot.ops)
        assert understood.plan.steps == (step,)
        assert understood.language == language
    walked = ParseContext(history=[Plan((Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.5),))])
    for more in said[len(wanted) :]:
        understood = parse(more, ["quadruped"], [], robot.ops, walked)
        goal = goal_of(more, Addressee(("quadruped",), (), robot), language)
        assert understood.intent is Intent.COMMAND or (goal and without_model(goal, robot, ColourDetector({}))), more
        assert understood.language == language
    in_a_thread = [f"@quadruped {words}" for words in thread_examples(language)]
    assert set(in_a_thread) <= set(said) or Op.MOVE not in robot.ops
    assert {step.op for step in wanted} == robot.ops


def test_the_help_itself_commands_nobody() -> None:
    for language in LANGUAGES:
        visible = visible_text(help_text(ROBOTS[0], "quadruped", language))
        assert parse(visible, ["quadruped"], [], frozenset(Op)).intent is not Intent.COMMAND
        assert "0.5" in visible
