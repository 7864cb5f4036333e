"""What a text must hold so that a phrase can be found in it at all, read from how the phrase is written.

A regular expression with hundreds of words takes long to compile and little to rule out: where none of its words stand
in the text, it need not be compiled. What is said here is necessary, never enough: every phrase that could be found is
still searched for.
"""

from __future__ import annotations

import re
from collections.abc import Callable

#: At least one of these stands in the text.
OneOf = frozenset[str]
_TOKEN = re.compile(
    r"(?P<group><\w+\+?>)|(?P<open>\((?:\?(?:[:>=!]|<[=!]))?)|(?P<close>\))|(?P<either>\|)"
    r"|(?P<times>(?:[?*+]|\{\d*,?\d*\})[?+]?)|(?P<other>\[\^?\]?(?:\\.|[^\]\\])*\]|\\.|[.~…^$])"
    r"|(?P<text>[^<(\[\]{}?*+|\\.~…^$)]+)"
)
#: Most are so: a word, maybe with an ending.
_PLAIN = re.compile(r"([\w' -]*[\w'-]) ?(?:\w\?|\(\?:[\w|]*\)\??)?")
#: What is held so is looked at, and taken in no word.
_LOOKS = {"(?=", "(?!", "(?<=", "(?<!"}


def needs(phrase: str, group: Callable[[str], tuple[OneOf, ...]]) -> tuple[OneOf, ...]:
    """All of these must be met; nothing where nothing can be told. `group` tells the same of a reference `<name+>`."""
    if plain := _PLAIN.fullmatch(phrase):
        return _literal(plain[1])
    return _Reader(phrase, group).alternatives()


class _Reader:
    def __init__(self, phrase: str, group: Callable[[str], tuple[OneOf, ...]]) -> None:
        self._tokens = iter([(match.lastgroup, match[0]) for match in _TOKEN.finditer(phrase)])
        self._group = group

    def alternatives(self) -> tuple[OneOf, ...]:
        """Reads to the closing bracket."""
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
    """What all alternatives need together: of each what tells most."""
    if len(found) == 1:
        return tuple(found[0])
    best = [max(sequence, key=_telling, default=frozenset()) for sequence in found]
    return (frozenset().union(*best),) if all(best) else ()


def _telling(one_of: OneOf) -> int:
    """How rare it is that a text meets this by chance: the length of the shortest."""
    return min(map(len, one_of))
