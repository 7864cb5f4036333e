"""Define what a language file provides: words to parse, sentences to say, and stop words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from agentrob.language.parser.lexicon import Lexicon


@dataclass(frozen=True)
class Locale:
    """One language, which a file in `locales/` provides under the name `LOCALE`.

    `sentences` are what robots say, with the keys of `messages.en`; a missing sentence is said in English.
    `stop`, `halt` and `polite` are phrases separated by |. They only add to the built-in stop words of all
    languages (law 13); `halt` is for explicit emergency stops, which lock the robot (law 17). `together`
    lists words for all robots at once ("both of you"). `stated` is a regular expression for the beginning of
    a clause that states where something is and would otherwise be parsed as a command (前面五米是墙). `order` lists
    words that put one robot's steps after another's ("then"), `waits` words that begin a condition to wait
    for ("when").
    """

    words: Lexicon
    sentences: Mapping[str, str]
    script: Literal["latin", "han"] = "latin"
    stop: str = ""
    halt: str = ""
    polite: str = ""
    together: str = ""
    stated: str = ""
    order: str = ""
    waits: str = ""

    @property
    def code(self) -> str:
        """The ISO 639-1 code: en, zh."""
        return self.words.language
