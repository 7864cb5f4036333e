"""Hostile Markdown does not hold up whoever listens for a stop (law 15): what is read of it costs little, always."""

from __future__ import annotations

import time
import unicodedata
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from agentrob.language.complexity import nfkc, parsing_us
from agentrob.language.stop.at_rest import is_only_stop, stop_intent
from agentrob.language.visible_text import MAX_CHARS, mentions, readable, visible_text
from tests.language.hostile_markdown import MADE, SIZE, TEXTS

#: Of processor time; far above what is measured (20 ms), far below what a stop may take.
LIMIT_S = 0.15
DOCS = sorted((Path(__file__).parents[2] / "docs").rglob("*.md"))


def spent_s(text: str) -> float:
    """The time that an agent needs to decide whether a text is a stop: the best of two, as others use the machine."""
    costs = []
    for n in range(2):
        begun_s = time.thread_time()
        visible = visible_text(text + " " * n)  # not from the cache
        stop_intent(visible)
        mentions(visible)
        costs.append(time.thread_time() - begun_s)
    return min(costs)


def test_the_texts_are_as_large_as_posts_may_be() -> None:
    assert all(len(text.encode()) <= SIZE for text in TEXTS.values())
    assert sum(len(text.encode()) > 0.9 * SIZE for text in TEXTS.values()) > 100


@pytest.mark.parametrize("name", TEXTS)
def test_law_15_whoever_hears_a_hostile_text_hears_the_next_one_soon(name: str) -> None:
    text = TEXTS[name]
    for part in (text, text[:MAX_CHARS], text[1 - MAX_CHARS :], text[:2_000], text[:500]):
        assert spent_s(part) < LIMIT_S


@settings(max_examples=150, suppress_health_check=[HealthCheck.too_slow])
@given(MADE, st.sampled_from([300, 2_000, MAX_CHARS - 1, SIZE]))
def test_law_15_combinations_of_markup_cost_no_more(text: str, length: int) -> None:
    assert spent_s(text[:length]) < LIMIT_S


def test_what_people_write_is_read() -> None:
    command = "**@quadruped** please walk _forward_ 2 metres, then turn left [90°](https://example.org) & wave!\n\n"
    quotation = "".join(f"> {n}. what somebody else said, with `code` and *emphasis*\n" for n in range(30)) + "\n"
    items = "".join(f"- step {n}: walk {n} metres\n" for n in range(60))
    text = f"{quotation}{command}{items}"
    assert readable(text)
    assert mentions(visible_text(text)) == ("quadruped",)
    for path in DOCS:
        assert parsing_us(path.read_text()) < 1_500_000 / 4, f"{path.name} is prose with markup and far from a limit"


def test_a_text_beyond_the_limit_has_no_visible_text_and_its_length_is_not_the_reason() -> None:
    assert visible_text("stop " + "![" * 1_000) == ""
    assert visible_text("stop " + "so " * 1_000).startswith("stop so")


@given(st.text(max_size=200))
def test_nfkc_is_unicode_s_own(text: str) -> None:
    assert nfkc(text) == unicodedata.normalize("NFKC", text)


def test_of_marks_on_one_letter_those_that_a_language_may_have_are_kept() -> None:
    assert nfkc("a" + "\u0301" * 40) == unicodedata.normalize("NFKC", "a" + "\u0301" * 30)
    begun_s = time.thread_time()
    nfkc(TEXTS["marks on one letter"])
    assert time.thread_time() - begun_s < LIMIT_S


@pytest.mark.parametrize(
    "body",
    ["stop", "STOP!!!", "@quadruped stop", "please stop now", "停", "＠quadruped 停下", "Stop. Please stop.",
     "**stop**",
     "@quadruped @humanoid halt!", "stop it, please!", "🛑", "emergency stop"],
)  # fmt: skip
def test_law_15_a_body_that_is_only_a_stop_is_one(body: str) -> None:
    assert is_only_stop(body)


@pytest.mark.parametrize(
    "body",
    ["", "hello", "stop\n\n> anything", "stop\n\n# Buy this", "stop, and buy this", "stop ![x](http://a/b.png)",
     "stop [here](http://a.example)", "stop http://a.example", "stop `code`", "stop <!-- hidden -->",
     "stop\n\n[a]: http://b",     "stop\n\n| a |\n|---|", "stop &nbsp; now", "~~stop~~", "> stop", "stop " * 60,
     "don't stop", "stop @a1 @b2 @c3 @d4",
     "stop \u202eyub", "walk 1 m and stop", "stop\n\n    indented", "stop ~~" + "x" * 20 + "~~"],
)  # fmt: skip
def test_a_body_that_says_more_than_stop_is_none(body: str) -> None:
    assert not is_only_stop(body)
