"""A test double of the embedding model: words for the same thing have the same vector, in two languages."""

from __future__ import annotations

import re
import threading
import zlib
from collections.abc import Sequence

from agentrob.semantic.encoder import SIZE, EncoderError

THINGS = (
    ("dog", "dogs", "puppy", "hound", "狗"),
    ("walk", "stroll", "hike", "散步"),
    ("car", "automobile", "vehicle", "汽车"),
    ("battery", "charge", "power", "电池"),
    ("tired", "exhausted", "weary", "累"),
)
_KNOWN = {word: place for place, words in enumerate(THINGS) for word in words}
_WORD = re.compile("|".join(sorted((w for w in _KNOWN if not w.isascii()), key=len, reverse=True)) + r"|[a-z0-9]+")


class Concepts:
    """Encodes the words in `THINGS`; every other word has a vector of its own. While `out` is set, encoding fails."""

    def __init__(self) -> None:
        self.asked: list[str] = []
        self.out = threading.Event()
        self.closed = False

    def encode(self, texts: Sequence[str]) -> list[bytes]:
        if self.out.is_set() or self.closed:
            raise EncoderError("the model is out")
        self.asked += texts
        return [_vector(text) for text in texts]

    def close(self) -> None:
        self.closed = True


def _vector(text: str) -> bytes:
    places = [0] * SIZE
    for word in _WORD.findall(text.lower()):
        at = _KNOWN.get(word, len(THINGS) + zlib.crc32(word.encode()) % (SIZE - len(THINGS)))
        places[at] = min(127, places[at] + 20)
    return bytes(places)
