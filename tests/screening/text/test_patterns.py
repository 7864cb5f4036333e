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
from agentrob.screening.text.patterns import Phrases, Vocabulary, compiled

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
            yield from (phrases for _, phrases, _ in harm.phrases_of(rule, prefix))
    for said in described_hazards._patterns().values():
        yield from said._phrases
    yield from side_remarks._phrases().every


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
            for _, phrases, _ in harm.phrases_of(rule, prefix):
                assert Phrases(phrases._vocabulary, phrases._phrases)._pattern("walk forward 2 m") is None


# ---------------------------------------------------------------------- the notation
GROUPS = {
    "verb": "chase|run|hit|eat|help|go|id|back up|put|fix|attempt",
    "thing": "stair|staircase|ball",
    "ordered": "ab|a(?:bc)?",
    "nested": "<thing>|wall",
}


def found(phrase: str, text: str, *, words: bool = True) -> list[str]:
    """Return what a phrase matches, which is the same before and after it is prepared."""
    phrases = Phrases(Vocabulary(GROUPS, words=words), [phrase])
    assert not phrases.prepared
    first = [match[0] for match in phrases.finditer(text)]
    phrases.prepare()
    assert phrases.prepared
    assert [match[0] for match in phrases.finditer(text)] == first
    return first


@pytest.mark.parametrize(
    "text",
    [
        "chase chases chased chasing",
        "run runs running",
        "hit hits hitting",
        "put putting",
        "eat eats eating",
        "help helps helped helping",
        "go goes going",
        "id ids",
    ],
)
def test_a_verb_is_found_in_its_english_forms(text: str) -> None:
    assert found("<verb+>", text) == text.split()


def test_a_particle_stays_behind_the_form() -> None:
    assert found("<verb+>", "back up, backs up, backed up, backing up") == [
        "back up",
        "backs up",
        "backed up",
        "backing up",
    ]


@pytest.mark.parametrize(
    "text", ["eatting", "helpping", "fixxing", "attemptting", "goging", "rerun", "chaser", "backuping", "idding"]
)
def test_what_is_no_form_of_a_verb_is_not_found(text: str) -> None:
    assert found("<verb+>", text) == []


def test_a_group_without_a_plus_has_its_words_only() -> None:
    assert found("<thing>", "a ball, balls, a stair") == ["ball", "stair"]
    assert found("<nested>", "a wall and a ball") == ["wall", "ball"]


def test_the_longest_word_of_a_group_comes_first_unless_it_has_expressions() -> None:
    assert found("<thing>", "staircase", words=False) == ["staircase"]
    assert found("<ordered>", "abc", words=False) == ["ab"]


def test_a_bar_within_brackets_does_not_separate_alternatives() -> None:
    phrases = Phrases(Vocabulary(GROUPS, words=True), ["a (?:b|c)|d[|]e|f", "g|h"])
    assert phrases.alternatives == ("a (?:b|c)", "d[|]e", "f", "g", "h")
    assert [match[0] for match in phrases.finditer("a c, d|e, f, h")] == ["a c", "d|e", "f", "h"]


def test_a_gap_stays_within_its_sentence_and_ends_at_a_negation() -> None:
    assert found("<verb+>~ <thing>", "run to the stair") == ["run to the stair"]
    assert found("<verb+>~ <thing>", "run. a stair") == []
    assert found("<verb+>~ <thing>", "run but never to the stair") == []
    assert found("<verb+>… <thing>", "run a bit and then see the stair") == []
    assert found("<verb+>… <thing>", "run straight to the stair") == ["run straight to the stair"]


def test_phrases_are_replaced_where_they_are_found() -> None:
    phrases = Phrases(Vocabulary(GROUPS, words=True), ["<thing>"])
    assert phrases.sub("#", "a ball and a wall") == "a # and a wall"
    assert phrases.search("a wall") is None
    assert phrases.sub("#", "a wall") == "a wall"
