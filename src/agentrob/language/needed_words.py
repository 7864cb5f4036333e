"""Derive from a regular expression which literal words a text must contain to match it.

To look for a word in a text takes a fraction of the time of a search for a pattern, and most texts contain no word of
most patterns.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

#: A text must contain at least one of these strings.
OneOf = frozenset[str]
_ANYTHING: OneOf = frozenset([""])
_TOKEN = re.compile(
    r"(?P<group><\w+\+?>)|(?P<open>\((?:\?(?:[:>=!]|<[=!]|P<\w+>))?)|(?P<close>\))|(?P<either>\|)"
    r"|(?P<times>(?:[?*+]|\{\d*,?\d*\})[?+]?)|(?P<other>\[\^?\]?(?:\\.|[^\]\\])*\]|\\.|[.~…^$])"
    r"|(?P<text>[^<(\[\]{}?*+|\\.~…^$)]+)"
)
#: Most phrases: a word, possibly with an ending.
_PLAIN = re.compile(r"([\w' -]*[\w'-]) ?(?:\w\?|\(\?:[\w|]*\)\??)?")
#: Lookarounds, whose content is not part of the match.
_LOOKS = {"(?=", "(?!", "(?<=", "(?<!"}


def needs(phrase: str, group: Callable[[str], tuple[OneOf, ...]] = lambda _: ()) -> tuple[OneOf, ...]:
    """Return sets of strings, of each of which a text must contain one to match the phrase; empty if nothing is
    certain.

    `group` returns the same for a reference `<name+>`. The result is necessary, never sufficient: a phrase that can
    match is still searched for.
    """
    if plain := _PLAIN.fullmatch(phrase):
        return _literal(plain[1])
    return _Reader(phrase, group).alternatives()


def one_needed(phrase: str) -> OneOf:
    """Return strings of which a text in lower case must contain one to match the phrase; an empty one is in any."""
    return max(needs(phrase), key=_distinctiveness, default=_ANYTHING)


class Prefiltered:
    """A regular expression without regard to case, searched for only in texts that contain a word which it needs."""

    def __init__(self, pattern: str) -> None:
        self._pattern = re.compile(pattern, re.IGNORECASE)
        self._one_of = tuple(one_needed(pattern))

    def finditer(self, text: str) -> Iterator[re.Match[str]]:
        return self._pattern.finditer(text) if self._possible(text) else iter(())

    def sub(self, replacement: Callable[[re.Match[str]], str], text: str) -> str:
        return self._pattern.sub(replacement, text) if self._possible(text) else text

    def _possible(self, text: str) -> bool:
        said = text.lower()
        return any(word in said for word in self._one_of)


class _Reader:
    def __init__(self, phrase: str, group: Callable[[str], tuple[OneOf, ...]]) -> None:
        self._tokens = iter([(match.lastgroup, match[0]) for match in _TOKEN.finditer(phrase)])
        self._group = group

    def alternatives(self) -> tuple[OneOf, ...]:
        """Read up to the closing bracket."""
        found: list[list[OneOf]] = [[]]
        last, rest = tuple[OneOf, ...](), tuple[OneOf, ...]()  # of the newest part, and of it when a `?` follows
        for kind, said in self._tokens:
            if kind == "times":
                last = rest if said[0] in "?*" or said.startswith(("{0", "{,")) else last
                continue
            found[-1] += last
            last = rest = ()
            if kind == "close":
                break
            if kind == "either":
                found.append([])
            elif kind == "open":
                within = self.alternatives()
                last = () if said in _LOOKS else within
            elif kind == "group":
                last = self._group(said)
            elif kind == "text":  # a `?` takes away its last letter only
                last, rest = _literal(said), _literal(said[:-1])
        found[-1] += last
        return either(found)


def _literal(said: str) -> tuple[OneOf, ...]:
    return (frozenset([said.strip()]),) if said.strip() else ()


def either(found: list[list[OneOf]]) -> tuple[OneOf, ...]:
    """Return what all alternatives require together: the most selective requirement of each."""
    if len(found) == 1:
        return tuple(found[0])
    best = [max(sequence, key=_distinctiveness, default=frozenset()) for sequence in found]
    return (frozenset().union(*best),) if all(best) else ()


def _distinctiveness(one_of: OneOf) -> int:
    """Return how unlikely a chance match is: the length of the shortest string."""
    return min(map(len, one_of))
