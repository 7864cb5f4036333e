"""Look up what robots say, by key and language.

All sentences are in `en` and `zh`, by section: `step.` and `ask.` for the grammar, `refuse.` for limits and rights,
`agent.` for reports, `visual.` for a model that steers by camera, `minds.` for a model's reading. The key of a refusal
for harm is the name of its rule.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable

from agentrob.language.registry import DEFAULT, known
from agentrob.language.visible_text import OMITTED, without_invisible
from agentrob.model import Language

#: Longest quotation of people's or a camera's words.
QUOTE_CHARS = 100


def say(key: str, language: Language, **values: object) -> str:
    """Return the sentence `key` in `language` with `values` filled in; pass people's words through `quote` first.

    A sentence that a language lacks is said in English. Raises `KeyError` for an unknown key or a missing value.
    """
    further = known().get(language)
    found = further.sentences.get(key) if further else None
    return (known()[DEFAULT].sentences[key] if found is None else found).format_map(values)


def can_say(key: str) -> bool:
    """Return whether the catalogue has the sentence `key`."""
    return key in known()[DEFAULT].sentences


def join_sentences(sentences: Iterable[str], language: Language) -> str:
    """Join sentences to one paragraph; Chinese puts no space between them, except after bold ones, which Markdown would
    otherwise not end there."""
    if language != "zh":
        return " ".join(sentences)
    parts = list(sentences)
    spaced = [part + " " if part.endswith("**") else part for part in parts[:-1]]
    return "".join([*spaced, *parts[-1:]])


def quote(words: str) -> str:
    """Return somebody's words as inline code on one line, at most 100 characters, with mentions disarmed."""
    plain = " ".join(without_invisible(words).replace("`", "'").replace("@", "(at)").replace(OMITTED, "…").split())
    if len(plain) > QUOTE_CHARS:
        plain = plain[: QUOTE_CHARS - 1] + "…"
    nothing = all(unicodedata.category(c) in ("Cf", "Mn", "Me") for c in plain)  # that anybody sees
    return f"`{' ' if nothing else plain}`"
