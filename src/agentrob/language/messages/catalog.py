"""Every sentence that robots speak, by key and language; the sentences stand with each language."""

from __future__ import annotations

import unicodedata

from agentrob.language.registry import DEFAULT, locale
from agentrob.language.visible_text import OMITTED, without_invisible
from agentrob.model import Language

#: The most that is repeated of what people, or a camera, said.
QUOTE_CHARS = 100


def say(key: str, language: Language, **values: object) -> str:
    """The sentence `key` in `language` with `values` put in. An unknown key or a missing value is a KeyError.

    What a language does not say itself is said in English. Words of people go through `quote` first.
    """
    found = locale(language).sentences.get(key)
    return (locale(DEFAULT).sentences[key] if found is None else found).format_map(values)


def can_say(key: str) -> bool:
    """Whether there is such a sentence."""
    return key in locale(DEFAULT).sentences


def quote(words: str) -> str:
    """Somebody's words as inline code: one line, at most 100 characters, with mentions disarmed."""
    plain = " ".join(without_invisible(words).replace("`", "'").replace("@", "(at)").replace(OMITTED, "…").split())
    if len(plain) > QUOTE_CHARS:
        plain = plain[: QUOTE_CHARS - 1] + "…"
    nothing = all(unicodedata.category(c) in ("Cf", "Mn", "Me") for c in plain)  # that anybody sees
    return f"`{' ' if nothing else plain}`"
