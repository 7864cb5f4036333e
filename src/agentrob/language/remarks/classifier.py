"""Estimate from its words whether a clause is a statement, and whether it has nothing to do with a command beside it.

Two linear classifiers on the same hashed features: words, runs of words and letters, their places at the beginning and
the end, and whether a verb stands where that of an order does; a Han character counts as a word. They are opinions:
`parser.remarks` combines them with the form of a clause and with lists of words that may change what a command means
or how dangerous it is. The more of those a clause holds, the surer the second classifier must be.
`scripts/train_statement_classifier.py` trains it on sentences that were written for this project; a file of weights
that was changed is not loaded.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from functools import cache, lru_cache
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple
from zlib import crc32

from agentrob.errors import ConfigError
from agentrob.language.remarks.verbs import BEFORE_VERB, HAN_VERBS, VERBS

WEIGHTS = Path(__file__).with_name("statement_weights.json")
#: The checksum of `WEIGHTS`; the training script prints it.
SHA256 = "46d6a411747d7a37db39e1fcc8b7f5b44e3b8cd75c6ac8081790a7dc09495095"
#: Features are hashed to this many weights.
SIZE = 16384
#: Words that are read; longer clauses are judged by their beginning and their end.
_MOST_WORDS = 24
_WORD = re.compile(r"[a-z']+|[0-9]+|[\u3400-\u9fff]|[!~^]")
#: A Chinese verb at the beginning is that of an order, unless it is reported as done.
_HAN_ORDER = re.compile(rf"(?:{HAN_VERBS})(?![^，。]{{0,9}}[了过](?!来|去))(?!.{{1,12}}的$)(?![着得到完])")
_HAN_JOINT = re.compile(
    "后(?![天悔面边台院排座代辈])|其次|完(?![成全毕美整善工蛋]|$)|再(?!说|见)|还要|然后|接着|并且|并(?![不没非排])|随后|而后|同时|顺便|顺带|紧接"
    rf"|和(?=[把坐站转走拍挥握鼓伸跳找拿数打告比往向前后左右退数]|{HAN_VERBS})"
)
_FIRST = 3
#: A clause of talk beside a statement may score this much less than a statement.
_DOUBT = 80
#: Shorter clauses, in words and in Han characters, say too little to be judged.
_LEAST, _LEAST_HAN = 2, 3


class Confidence(IntEnum):
    """How surely a clause has nothing to do with the command beside it."""

    NONE = 0
    POSSIBLE = 1
    LIKELY = 2
    STRONG = 3
    CERTAIN = 4
    #: No clause is: what needs it is never left out.
    NEVER = 5


@dataclass(frozen=True)
class StatementClassifier:
    """The classifier of one language, by its ISO 639-1 code; its weights are read at the first question.

    Its methods raise `ConfigError` if the weights are missing or changed.
    """

    language: str

    def is_statement(self, clause: str, *, sure: bool = False) -> bool:
        """Return whether a clause reads as a statement; `sure` asks for a higher score."""
        words = _words(clause)
        if len(words) < (_LEAST_HAN if words and not words[0].isascii() else _LEAST) or begins_as_order(clause):
            return False
        head = _weights()[self.language].statement
        return _scores(self.language, clause)[0] > head.thresholds["sure" if sure else "statement"]

    def may_be_talk(self, clause: str) -> bool:
        """Return whether a clause may be talk beside a statement, as far as its words tell; it may have only one
        word."""
        if begins_as_order(clause):
            return False
        threshold = _weights()[self.language].statement.thresholds["statement"]
        return _scores(self.language, clause)[0] > threshold - _DOUBT

    def harmless(self, clause: str) -> Confidence:
        """Return how surely a clause says nothing that changes what the command beside it means or endangers."""
        points, thresholds = _scores(self.language, clause)[1], _weights()[self.language].harmless.thresholds
        return Confidence(sum(points > threshold for threshold in thresholds.values()))


class Head(NamedTuple):
    """One question: `SIZE` signed bytes, and the scores that an answer needs, by its name."""

    weights: bytes
    thresholds: dict[str, int]


class Weights(NamedTuple):
    """The questions about a clause of one language: is it a statement, and has it nothing to do with a command?"""

    statement: Head
    harmless: Head


@lru_cache(maxsize=256)
def _scores(language: str, clause: str) -> tuple[int, int]:
    known, found = _weights()[language], buckets(clause)
    return _sum(found, known.statement.weights), _sum(found, known.harmless.weights)


def score(clause: str, weights: bytes) -> int:
    """Return the sum of the weights of a clause's features; `weights` are `SIZE` signed bytes, and 0 for empty text."""
    return _sum(buckets(clause), weights)


def _sum(found: set[int], weights: bytes) -> int:
    signed = memoryview(weights).cast("b")
    return sum(signed[at] for at in found)


def buckets(clause: str) -> set[int]:
    """Return the numbers of a clause's features."""
    return {crc32(feature.encode()) % SIZE for feature in _features(clause)}


def begins_as_order(clause: str) -> bool:
    """Return whether a verb stands where that of an order does, so that no score makes the clause a statement."""
    words = _words(clause)
    return _verb_of_order(words) >= 0 or _HAN_ORDER.match("".join(words)) is not None


def joins_order(clause: str) -> bool:
    """Return whether a verb follows that may be an order of its own: "I'm bored and count the chairs"."""
    words = [word for word in _words(clause) if word not in ("please", "also", "just")]
    after = (_verb_of_order(words[at:]) == 1 for at, word in enumerate(words) if word in ("and", "then", "so", "but"))
    return any(after) or _HAN_JOINT.search("".join(words)) is not None


@lru_cache(maxsize=256)
def _words(clause: str) -> list[str]:
    words = ["0" if word.isdigit() else word for word in _WORD.findall(clause.lower().replace("’", "'"))]
    return words if len(words) <= _MOST_WORDS else words[: _MOST_WORDS // 2] + words[-_MOST_WORDS // 2 :]


def _verb_of_order(words: list[str]) -> int:
    """Return where a verb stands as in an order: first, or after "please", "could you" and the like; -1 if nowhere."""
    first = next((at for at, word in enumerate(words) if word not in BEFORE_VERB), -1)
    return first if first >= 0 and words[first] in VERBS else -1


def _features(clause: str) -> Iterator[str]:
    words = _words(clause)
    if not words:
        return
    yield f"count {min(len(words), 8)}"
    for at, word in enumerate(words):
        yield word
        if at < _FIRST:
            yield f"{at} {word}"
            yield f"{at} -{word[-2:]}"
    for length in (1, 2, 3):
        for at in range(len(words) - length + 1):
            yield " ".join(words[at : at + length])
        if len(words) >= length:
            yield f"^ {' '.join(words[:length])}"
            yield f"$ {' '.join(words[-length:])}"
    yield from _verbs(words)
    if words[0].isascii():
        letters = f" {' '.join(words)} "
        for length in (2, 3, 4):
            for at in range(len(letters) - length + 1):
                yield f"~{letters[at : at + length]}"


def _verbs(words: list[str]) -> Iterator[str]:
    """Yield the verbs that stand as in an order."""
    if (first := _verb_of_order(words)) >= 0:
        yield f"order {words[first - 1] if first else '^'}"
        yield f"order {'later' if first else 'first'}"
        if len(words) > first + 1:
            yield f"order _ {words[first + 1]}"
    for before, word in pairwise(words):
        if word in VERBS and before in ("you", "to", "can", "please"):
            yield f"verb after {before}"


@cache
def _weights() -> dict[str, Weights]:
    return load_weights()


def load_weights(path: Path = WEIGHTS, sha256: str = SHA256) -> dict[str, Weights]:
    """Read the weights of each language. Raises `ConfigError` if the file is missing or changed."""
    try:
        content = path.read_bytes()
    except OSError as e:
        raise ConfigError(f"the weights of the statement classifier cannot be read: {e}; install agentrob again") from e
    if hashlib.sha256(content).hexdigest() != sha256:
        raise ConfigError(f"{path} does not have the expected checksum: install agentrob again")
    found = json.loads(content)["languages"]
    return {
        language: Weights(
            *(Head(base64.b64decode(heads[name]["weights"]), heads[name]["thresholds"]) for name in Weights._fields)
        )
        for language, heads in found.items()
    }
