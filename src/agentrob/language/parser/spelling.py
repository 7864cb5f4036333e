"""How people mistype the words that matter: letters swapped, doubled or left out. No guess at what is another word."""

from __future__ import annotations

from collections.abc import Iterator

#: What such slips would make of them, and what people may mean by them.
_WORDS = frozenset("ever mere mete ford feat riot rotes sake step steps taps trod".split())  # noqa: SIM905
_SHORTEST, _SHORTEST_WITH_GAP = 4, 5


def misspellings(word: str) -> frozenset[str]:
    """The likely slips of one word of at least four Latin letters. First letters are not left out."""
    if len(word) < _SHORTEST or not (word.isascii() and word.isalpha()):
        return frozenset()
    return frozenset(_slips(word)) - _WORDS - {word}


def _slips(word: str) -> Iterator[str]:
    for at in range(len(word) - 1):
        yield word[:at] + word[at + 1] + word[at] + word[at + 2 :]
    for at, letter in enumerate(word):
        yield word[:at] + letter + word[at:]
        if at and len(word) >= _SHORTEST_WITH_GAP:
            yield word[:at] + word[at + 1 :]
