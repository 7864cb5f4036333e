"""How rules of words are written: phrases with named groups, compiled to one regular expression per rule.

A group is a list of words separated by
        |. In a phrase `<group>` stands for any of them, `<group+>` for any of them as a
verb in all its English forms, `~` for up to thirty characters within one sentence that hold no "not", and `…` for the
same within one deed. Everything else is a regular expression over text in small letters with single spaces.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

_NOT = r"(?!\b(?:don't|dont|not|never|without|avoid|instead of|rather than)\b|不要|别|不许|避免|小心|以免)"
GAP = rf"(?:{_NOT}[^.!?;\n。！？；]){{0,30}}?"
DEED = (
    rf"(?:{_NOT}(?! (?:and|then|but) (?!then|into|over|through|against|onto|off|straight|right"
    rf"|directly)\w)[^.!?;\n。！？；]){{0,30}}?"
)
#: In Chinese phrases people write this for "anything within the clause".
_WITHIN = "[^，。！？；\\n]"
_REFERENCE = re.compile(r"<(\w+)(\+?)>")
_VOWELS = "aeiou"


def compiled(groups: Mapping[str, str], phrases: Sequence[str], *, words: bool) -> re.Pattern[str]:
    """One expression for all phrases. `words`: they begin and end at the borders of words (not so in Chinese)."""
    found = "|".join(f"(?:{_expanded(phrase, groups)})" for phrase in phrases)
    return re.compile(rf"(?<!\w)(?:{found})(?!\w)" if words else f"(?:{found})")


def _expanded(phrase: str, groups: Mapping[str, str]) -> str:
    phrase = phrase.replace(" ~ ", rf"(?: |\b{GAP}\b )").replace("~", GAP).replace("…", DEED)
    phrase = phrase.replace(_WITHIN, rf"(?:{_NOT}[^，。！？；,.!?;\n])")
    return _REFERENCE.sub(lambda m: _group(groups[m[1]], groups, m[2] == "+"), phrase)


def _group(text: str, groups: Mapping[str, str], inflected: bool) -> str:
    """A group may name others; where words are inflected, each is a verb, maybe with a particle: "back up"."""
    items = _items(re.sub(r"\n\s*", "", text))
    if inflected:
        items = [_forms(item) for item in items]
    elif not re.search(r"[()\[\]]", text):  # the longest first
        items.sort(key=len, reverse=True)
    return "(?:" + "|".join(_expanded(item, groups) for item in items if item) + ")"


def _items(text: str) -> list[str]:
    """The alternatives of a group; a | within brackets belongs to its item."""
    items, depth = [""], 0
    for char in text:
        depth += (char in "([") - (char in ")]")
        if char == "|" and depth == 0:
            items.append("")
        else:
            items[-1] += char
    return items


def _forms(verb: str) -> str:
    first, space, rest = verb.partition(" ")
    base = first[:-1] if first.endswith("e") else first
    double = first[-1] if len(first) > 2 and first[-1] in "bdgmnprt" and first[-2] in _VOWELS else ""
    endings = "es|s|ed|ing" if not first.endswith("e") else "es|e|ed|ing"
    more = f"|{double}(?:ed|ing)" if double and first[-3] not in _VOWELS else ""
    optional = "" if first.endswith("e") else "?"
    return f"{base}(?:{endings}{more}){optional}{space}{rest}"
