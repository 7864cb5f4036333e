"""Law 7: only patterns that cannot match a text are left uncompiled for it."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.screening.text import described_hazards, harm, side_remarks
from agentrob.screening.text.patterns import Phrases, compiled

TEXTS = [
    harm.plain_words(json.loads(line)["text"])
    for line in (Path(__file__).parents[1] / "dangerous.jsonl").read_text(encoding="utf-8").splitlines()
]
HAN = re.compile("[\u3400-\u9fff]")


@cache
def every() -> tuple[Phrases, ...]:
    return tuple(_every())


def _every() -> Iterator[Phrases]:
    for rule in harm.RULES:
        for prefix in harm.PREFIXES:
            yield from (phrases for phrases, _ in harm.phrases_of(rule, prefix))
    for said in described_hazards._patterns().values():
        yield from said._phrases
    yield from side_remarks._phrases()


@cache
def whole(phrases: Phrases) -> re.Pattern[str]:
    """Return all alternatives as one expression."""
    known = phrases._vocabulary
    return compiled(known.groups, phrases._phrases, words=known.words)


@cache
def numbered(phrases: Phrases) -> re.Pattern[str]:
    """Return all alternatives as one expression, each in its own group, so that a match identifies it."""
    known = phrases._vocabulary
    assert not re.search(r"(?<!\\)\((?!\?)", "".join(phrases._phrases) + "".join(known.groups.values()))
    return compiled(known.groups, [f"({phrase})" for phrase in phrases.alternatives], words=known.words)


def assert_all_would_be_found(plain: str) -> None:
    for phrases in every():
        for match in numbered(phrases).finditer(plain):
            assert match.lastindex is not None
            for one_of in phrases.needed[match.lastindex - 1]:
                assert any(said in plain for said in one_of), (match[0], phrases.alternatives[match.lastindex - 1])
            assert phrases._vocabulary.letters.search(plain)


def test_law_7_every_match_in_our_own_dangerous_commands_and_their_twins_is_among_the_possible() -> None:
    for text in TEXTS:
        assert_all_would_be_found(text)


@given(st.sampled_from(TEXTS), st.sampled_from(TEXTS), st.data())
def test_law_7_the_same_holds_for_texts_that_were_cut_and_put_together(
    one: str, other: str, data: st.DataObject
) -> None:
    at = data.draw(st.integers(0, len(one)))
    since = data.draw(st.integers(0, len(other)))
    assert_all_would_be_found(one[:at] + data.draw(st.sampled_from(["", " ", "s ", "ing "])) + other[since:])


@pytest.mark.parametrize("text", [*TEXTS[::60], "走两米", "walk forward 2 m", ""])
def test_law_7_what_was_not_prepared_finds_the_same_words(text: str) -> None:
    for phrases in every():
        fresh = Phrases(phrases._vocabulary, phrases._phrases)
        fresh.__dict__.update(alternatives=phrases.alternatives, needed=phrases.needed)  # reported once
        assert [m[0] for m in fresh.finditer(text)] == [m[0] for m in whole(phrases).finditer(text)]
        assert fresh.sub("#", text) == whole(phrases).sub("#", text)


def test_every_chinese_phrase_finds_only_what_holds_a_chinese_character() -> None:
    """So none of them is needed for a text without Chinese characters."""
    for phrases in every():
        if phrases._vocabulary is harm.CHINESE:
            for phrase, needed in zip(phrases.alternatives, phrases.needed, strict=True):
                assert any(all(HAN.search(said) for said in one_of) for one_of in needed), phrase


def test_a_plain_command_compiles_nothing_of_harm() -> None:
    for rule in harm.RULES:
        for prefix in harm.PREFIXES:
            for phrases, _ in harm.phrases_of(rule, prefix):
                assert Phrases(phrases._vocabulary, phrases._phrases)._pattern("walk forward 2 m") is None
