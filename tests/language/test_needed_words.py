"""The words that a text must contain to match a pattern: no match is ever missed because of them."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from agentrob.language.needed_words import Prefiltered, needs
from agentrob.language.parser.order import Idioms
from agentrob.language.registry import known

ROWS = [
    json.loads(line)["text"]
    for file in sorted(Path(__file__).parent.rglob("*.jsonl"))
    for line in file.read_text(encoding="utf-8").splitlines()
]
#: Posts in which idioms follow each other, or only one makes another possible.
RESTATED = [
    "Give my grandma a big wave, then turn 30deg r.",
    "Could the robot l90, and followed by a wave?",
    "hello robot, how are you? let's have a backflip please",
    "would it kill you to face three o'clock x2",
    "麻烦请它向前行进俩米，行不？",
    "①前行完毕之后再来一张，over。",
]


@pytest.mark.parametrize("language", sorted(known()))
def test_idioms_are_restated_as_if_each_were_searched_for(language: str) -> None:
    locale = known()[language]
    for text in ROWS + RESTATED:
        plain, _ = Idioms(()).in_plain_words(text)
        for pattern, words in locale.idioms:
            plain = re.sub(pattern, words, plain, flags=re.IGNORECASE)
        assert locale.restated_idioms.in_plain_words(text)[0] == plain


@pytest.mark.parametrize("language", sorted(known()))
def test_a_prefiltered_pattern_finds_what_the_pattern_finds(language: str) -> None:
    locale = known()[language]
    for pattern in (locale.put_first, locale.called or "(?!)"):
        prefiltered = Prefiltered(pattern)
        for text in ROWS + RESTATED:
            wanted = [found.span() for found in re.finditer(pattern, text, re.IGNORECASE)]
            assert [found.span() for found in prefiltered.finditer(text)] == wanted


@pytest.mark.parametrize(
    ("phrase", "needed"),
    [
        ("walls?", [{"wall"}]),
        ("<go+>… into (?:a|the) wall", [{"run", "driv"}, {"into"}, {"a", "the"}, {"wall"}]),
        (r"(?:please )?run(?! away)\b", [{"run"}]),
        ("in ~ front{0,2}|behind", [{"fron", "behind"}]),
        (r"(?:right|\w+) now", [{"now"}]),
        (r"\w+ing?|<thing>", []),
        ("[abc] (?>x(?:yz|wall)*)(?<=q)", [{"x"}]),
    ],
)
def test_what_a_phrase_needs(phrase: str, needed: list[set[str]]) -> None:
    groups = {"<go+>": (frozenset(["run", "driv"]),)}
    assert [set(one_of) for one_of in needs(phrase, lambda reference: groups.get(reference, ()))] == needed
