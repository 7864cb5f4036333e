"""What one language consists of: what people say in it, what robots answer, and its stop words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from agentrob.language.parser.lexicon import Lexicon


@dataclass(frozen=True)
class Locale:
    """One language, as a file in `locales/` gives it under the name `LOCALE`.

    `sentences` are what robots say, by the keys of `phrases_en`; a sentence that is missing is said in English. `stop`,
    `halt` and `polite` are phrases separated by |; they only add to the stop words of all languages (law 13), which
    stand in `stop`; `halt` is for explicit emergency stops, which lock the robot
    (law 17). `together` are the words for all robots at once ("both of you"). `stated` is a regular expression of what
    says at the beginning of a clause what is where, and would else be read as a command (前面五米是墙). `order` are the
    words that set one robot's deeds after another's ("then"), `waits` those that begin what it is to wait for ("when").
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
