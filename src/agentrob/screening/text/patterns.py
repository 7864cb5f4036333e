"""Compile rules of words: phrases with named groups become one regular expression per rule.

A group is a list of words separated by |. In a phrase `<group>` stands for any of them, `<group+>` for any of them as a
verb in all its English forms, `~` for up to thirty characters within one sentence without a negation, and `…` for the
same within one clause. Everything else is a regular expression over lower-case text with single spaces.

Compiling all of them takes most of a second. A process that serves compiles them when it starts (`Phrases.prepare`). A
process that reads a single text compiles only the phrases that can match it (`language.needed_words`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property, lru_cache

from agentrob.language.needed_words import OneOf, either, needs

_NOT = r"(?!\b(?:don't|dont|not|never|without|avoid|instead of|rather than)\b|不要|别|不许|避免|小心|以免)"
GAP = rf"(?:{_NOT}[^.!?;\n。！？；]){{0,30}}?"
CLAUSE_GAP = (
    rf"(?:{_NOT}(?! (?:and|then|but) (?!then|into|over|through|against|onto|off|straight|right"
    rf"|directly)\w)[^.!?;\n。！？；]){{0,30}}?"
)
#: How Chinese phrases write "anything within the clause".
_WITHIN = "[^，。！？；\\n]"
_REFERENCE = re.compile(r"<(\w+)(\+?)>")
_VOWELS = "aeiou"


class Vocabulary:
    """Groups of words, and what a text must contain to match one of a group.

    `words`: phrases begin and end at word boundaries (not in Chinese). `letters`: a match contains at least one of
    them.
    """

    def __init__(self, groups: Mapping[str, str], *, words: bool, letters: str = "") -> None:
        self.groups = groups
        self.words = words
        self.letters = re.compile(letters)
        self._needs: dict[str, tuple[OneOf, ...]] = {}

    def needs(self, reference: str) -> tuple[OneOf, ...]:
        """Return what a text must contain to match a group, which is named as in a phrase: `<go+>`."""
        if reference not in self._needs:
            name, inflected = reference.strip("<+>"), "+" in reference
            found = [[*needs(item, self.needs)] for item in _group_items(self.groups[name], inflected)]
            self._needs[reference] = either(found)
        return self._needs[reference]


class Phrases:
    """Phrases that are searched for as one expression; earlier phrases take precedence."""

    def __init__(self, vocabulary: Vocabulary, phrases: Iterable[str]) -> None:
        self._vocabulary = vocabulary
        self._phrases = tuple(phrases)
        self._whole: re.Pattern[str] | None = None
        self._part = lru_cache(maxsize=32)(self._compiled)

    def prepare(self) -> None:
        """Compile all phrases in advance."""
        self._whole = self._whole or self._compiled(self.alternatives)

    @property
    def prepared(self) -> bool:
        return self._whole is not None

    @cached_property
    def alternatives(self) -> tuple[str, ...]:
        return tuple(item for phrase in self._phrases for item in _items(phrase))

    @cached_property
    def needed(self) -> tuple[tuple[OneOf, ...], ...]:
        """The words that a text must contain for each of the alternatives."""
        return tuple(needs(phrase, self._vocabulary.needs) for phrase in self.alternatives)

    def finditer(self, text: str) -> Iterator[re.Match[str]]:
        pattern = self._pattern(text)
        return pattern.finditer(text) if pattern else iter(())

    def search(self, text: str) -> re.Match[str] | None:
        return next(self.finditer(text), None)

    def sub(self, replacement: str, text: str) -> str:
        pattern = self._pattern(text)
        return pattern.sub(replacement, text) if pattern else text

    def _pattern(self, text: str) -> re.Pattern[str] | None:
        """Return a pattern that finds the same in this text as all phrases together, or None if none can match."""
        if self._whole:
            return self._whole
        if not self._vocabulary.letters.search(text):
            return None
        both = zip(self.alternatives, self.needed, strict=True)
        possible = tuple(phrase for phrase, needed in both if all(_holds(text, one_of) for one_of in needed))
        return self._part(possible) if possible else None

    def _compiled(self, phrases: tuple[str, ...]) -> re.Pattern[str]:
        return compiled(self._vocabulary.groups, phrases, words=self._vocabulary.words)


@lru_cache(maxsize=4096)
def _holds(text: str, one_of: OneOf) -> bool:
    return any(said in text for said in one_of)


def compiled(groups: Mapping[str, str], phrases: Sequence[str], *, words: bool) -> re.Pattern[str]:
    """Compile all phrases into one expression. `words`: they begin and end at word boundaries (not in Chinese)."""
    found = "|".join(f"(?:{_expanded(phrase, groups)})" for phrase in phrases)
    return re.compile(rf"(?<!\w)(?:{found})(?!\w)" if words else f"(?:{found})")


def _expanded(phrase: str, groups: Mapping[str, str]) -> str:
    phrase = phrase.replace(" ~ ", rf"(?: |\b{GAP}\b )").replace("~", GAP).replace("…", CLAUSE_GAP)
    phrase = phrase.replace(_WITHIN, rf"(?:{_NOT}[^，。！？；,.!?;\n])")
    return _REFERENCE.sub(lambda m: _group(groups[m[1]], groups, m[2] == "+"), phrase)


def _group(text: str, groups: Mapping[str, str], inflected: bool) -> str:
    return "(?:" + "|".join(_expanded(item, groups) for item in _group_items(text, inflected)) + ")"


def _group_items(text: str, inflected: bool) -> list[str]:
    """Split a group, which may name others; inflected groups are verbs, possibly with a particle: "back up"."""
    items = _items(re.sub(r"\n\s*", "", text))
    if inflected:
        items = [_forms(item) for item in items]
    elif not re.search(r"[()\[\]]", text):  # the longest first
        items.sort(key=len, reverse=True)
    return [item for item in items if item]


def _items(text: str) -> list[str]:
    """Split a group or phrase into alternatives; a | within brackets does not separate."""
    if not {"(", "["} & set(text):
        return text.split("|")
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
