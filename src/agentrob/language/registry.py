"""Find the available languages, and detect the language of a text."""

from __future__ import annotations

import importlib
import pkgutil
import re
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import cast

from agentrob.language import locales
from agentrob.language.locale import Locale
from agentrob.language.parser.lexicon import pieces_of
from agentrob.model import Language

DEFAULT: Language = "en"
_HAN = re.compile(r"[\u3400-\u9fff]")
_LATIN_WORD = re.compile(r"[^\W\d_\u3400-\u9fff]{2,}")


@cache
def known() -> Mapping[str, Locale]:
    """Return every language by its code, English first: the files of the folder `locales`, but not their parts
    (`zh_phrases`).
    """
    files = (m.name for m in pkgutil.iter_modules(locales.__path__))
    names = sorted((name for name in files if "_" not in name), key=lambda n: (n != DEFAULT, n))
    found = [cast(Locale, importlib.import_module(f"{locales.__name__}.{name}").LOCALE) for name in names]
    return MappingProxyType({locale.code: locale for locale in found})


def locale(language: Language) -> Locale:
    """Return a language by its code. Raises `KeyError`, which lists the valid codes."""
    try:
        return known()[language]
    except KeyError:
        raise KeyError(f"Unknown language {language!r}; valid: {', '.join(known())}") from None


def language_of(text: str) -> Language:
    """Return the language of a text.

    It is Chinese if the text has at least as many Chinese characters as other words, otherwise the language whose
    vocabulary matches most words, or English if none matches.
    """
    han = len(_HAN.findall(text))
    script = "han" if han and han >= len(_LATIN_WORD.findall(text)) else "latin"
    candidates = [code for code, t in known().items() if t.script == script]
    if len(candidates) < 2:
        return candidates[0] if candidates else DEFAULT
    said = [piece.text for piece in pieces_of(text)]
    scores = {code: sum(word in known()[code].words.vocabulary for word in said) for code in candidates}
    return max(candidates, key=lambda code: scores[code])
