"""Every sentence that robots speak, by key and language; the sentences stand in `phrases_en` and `phrases_zh`."""

from __future__ import annotations

from collections.abc import Mapping

from agentrob.language import phrases_en, phrases_zh
from agentrob.language.visible import OMITTED
from agentrob.model import Language

BOOKS: Mapping[Language, Mapping[str, str]] = {"en": phrases_en.PHRASES, "zh": phrases_zh.PHRASES}

#: The most that is repeated of what people, or a camera, said.
QUOTE_CHARS = 100


def say(key: str, language: Language, **values: object) -> str:
    """The sentence `key` in `language` with `values` put in. An unknown key or a missing value is a KeyError.

    Words of people go through `quote` first.
    """
    return BOOKS[language][key].format_map(values)


def quote(words: str) -> str:
    """Somebody's words as inline code: one line, at most 100 characters, with mentions disarmed."""
    plain = " ".join(words.replace("`", "'").replace("@", "(at)").replace(OMITTED, "…").split())
    if len(plain) > QUOTE_CHARS:
        plain = plain[: QUOTE_CHARS - 1] + "…"
    return f"`{plain or ' '}`"
