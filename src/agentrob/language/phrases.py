"""Every sentence that robots speak, by key and language."""

from __future__ import annotations

from agentrob.model import Language


def say(key: str, language: Language, **values: object) -> str:
    """The sentence `key` in `language` with `values` put in. An unknown key or a missing value is a KeyError."""
    raise KeyError(key)
