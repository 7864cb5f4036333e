"""Words and what they mean to the grammar: the parts of speech, and cutting a text into them.

A language is one file (`en.py`, `zh.py`) with a table from meanings to the phrases people use. A meaning is one or more
symbols, `kind` or `kind=value`: "move" is a verb, "move dir=backward" says verb and direction at once ("back up").
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import NamedTuple

from agentrob.model import Language


class Kind(StrEnum):
    """Parts of speech of the robot's small world."""

    MOVE = "move"  # a verb of going, in any direction
    TURN = "turn"  # a verb of turning on the spot
    DIR = "dir"  # forward, backward, left, right
    OP = "op"  # a whole gesture or picture: "wave"
    NUMBER = "number"
    LENGTH_UNIT = "length_unit"  # value: metres
    ANGLE_UNIT = "angle_unit"  # value: degrees
    SPEED_UNIT = "speed_unit"  # value: metres per second
    STEP_UNIT = "step_unit"  # a step has no length
    TIME_UNIT = "time_unit"
    PER_SECOND = "per_second"  # 每秒 before the length
    LENGTH = "length"  # a number with its unit, in metres
    ANGLE = "angle"  # in degrees
    SPEED = "speed"  # in metres per second
    STEPS = "steps"
    DURATION = "duration"
    HALF = "half"
    AND_HALF = "and_half"  # "and a half"
    TIMES_UNIT = "times_unit"
    TIMES = "times"
    SHOW = "show"  # take, send, 拍: with a picture after it
    PICTURE = "picture"
    OF = "of"  # what follows a picture is its subject and commands nothing
    EACH = "each"  # "after each movement"
    VAGUE = "vague"  # "a bit"
    SLOW = "slow"
    SOFT = "soft"  # politeness, hesitation, articles: carries nothing
    AND = "and"  # joins clauses: and, then
    COMMA = "comma"  # separates clauses and ends a negation
    END = "end"  # ends a sentence
    ASKED = "asked"  # a question mark, 吗
    REQUEST = "request"  # can you, please: what follows is wanted
    WISH = "wish"  # we should, you can: what follows is wanted unless within talk
    TALK = "talk"  # opens a statement or question that commands nothing
    TALK_START = "talk_start"  # the same, but only where a clause begins
    REPORT = "report"  # the past: the whole sentence commands nothing
    CONDITION = "condition"  # if, until, or: beyond these rules
    NOT = "not"
    HELP = "help"
    STATUS = "status"
    MORE_STOP = "stop"  # "and stop" at the end
    GO_AHEAD = "go_ahead"  # encouragement, or a direction when a length follows
    WORD = "word"  # not known


Value = float | str | None


@dataclass(frozen=True, slots=True)
class Token:
    """A phrase with its meaning; `start` and `end` are its place in the text."""

    kind: Kind
    value: Value = None
    start: int = 0
    end: int = 0


class Piece(NamedTuple):
    """A word, a number in digits, one Chinese character or a mark, lower case."""

    text: str
    start: int
    end: int


#: Reads a number from the pieces at a position: (value, how many pieces), or None.
NumberReader = Callable[[Sequence[Piece], int], tuple[float, int] | None]


@dataclass(frozen=True)
class Lexicon:
    """One language. `phrases` maps pieces to meanings, `number` reads its numerals."""

    language: Language
    phrases: Mapping[tuple[str, ...], tuple[tuple[Kind, Value], ...]]
    number: NumberReader
    longest: int = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "longest", max(map(len, self.phrases)))


def lexicon(
    language: Language, table: Mapping[str, str], number: NumberReader, extends: Lexicon | None = None
) -> Lexicon:
    """Build a language from its table; phrases are separated by | and written as people write them."""
    phrases = dict(extends.phrases) if extends else {}
    for meaning, words in table.items():
        symbols = tuple(_symbol(s) for s in meaning.split())
        for phrase in words.replace("\n", " ").split("|"):
            if key := tuple(p.text for p in pieces_of(phrase)):
                phrases[key] = symbols
    return Lexicon(language, phrases, number)


def _symbol(text: str) -> tuple[Kind, Value]:
    name, _, value = text.partition("=")
    try:
        return Kind(name), float(value) if value else None
    except ValueError:
        return Kind(name), value


_PIECE = re.compile(
    r"(?P<bad>\d+(?:,\d+)+(?:\.\d+)?|(?<!\w)[-−]\.?\d+|\d+[-–~]\d+|\d+[x×*^]\d+)"  # 1,500 · -2 · 2-3: not to be guessed
    r"|\d+[/⁄][1-9]\d*|\d+(?:\.\d+)?(?![.]?\d)|\.\d+"
    r"|[a-z]+(?:'[a-z]+)*"
    r"|[\u3400-\u9fff]"
    r"|[^\W\d_a-z\u3400-\u9fff]+"
    r"|[^\s\w]|\w",
    re.ASCII,
)
_IGNORED_MARKS = frozenset("*_\"'“”‘’「」『』«»`-~#")
_DASHES = frozenset("–—―")


def pieces_of(text: str) -> list[Piece]:
    """Cut a text into pieces. A hyphen joins words ("forty-five"), a dash with spaces around it separates them."""
    lowered = _same_length_lower(text).replace("’", "'").replace("‘", "'")
    found: list[Piece] = []
    for match in _PIECE.finditer(lowered):
        piece, start, end = match[0], match.start(), match.end()
        if match["bad"]:
            found.append(Piece("\0" + piece, start, end))
        elif (piece in "-" and _stands_alone(lowered, start)) or piece in _DASHES:
            found.append(Piece("—", start, end))
        elif piece not in _IGNORED_MARKS:
            found.append(Piece(piece, start, end))
    return found


def _stands_alone(text: str, at: int) -> bool:
    return text[at - 1 : at].isspace() and text[at + 1 : at + 2].isspace()


def _same_length_lower(text: str) -> str:
    """Lower case that keeps every character's place (İ would become two)."""
    lowered = text.lower()
    return lowered if len(lowered) == len(text) else "".join(c.lower() if len(c.lower()) == 1 else c for c in text)


def tokens_of(text: str, words: Lexicon) -> list[Token]:
    """Cut a text into tokens, the longest known phrase first; line ends separate like commas."""
    found: list[Token] = []
    pieces = pieces_of(text)
    at = 0
    while at < len(pieces):
        if at and "\n" in text[pieces[at - 1].end : pieces[at].start]:
            found.append(Token(Kind.COMMA, None, pieces[at].start, pieces[at].start))
        length, symbols = _longest_phrase(pieces, at, words)
        number = words.number(pieces, at)
        if number and (number[1] > length or symbols[0][0] is Kind.WORD):
            length, symbols = number[1], ((Kind.NUMBER, number[0]),)
        start, end = pieces[at].start, pieces[at + length - 1].end
        found += (Token(kind, value, start, end) for kind, value in symbols)
        at += length
    return found


def _longest_phrase(pieces: Sequence[Piece], at: int, words: Lexicon) -> tuple[int, tuple[tuple[Kind, Value], ...]]:
    """The longest phrase at this place: (how many pieces, meaning). What is not known is one piece of WORD."""
    for length in range(min(words.longest, len(pieces) - at), 0, -1):
        if meaning := words.phrases.get(tuple(p.text for p in pieces[at : at + length])):
            return length, meaning
    if _is_pictograph(pieces[at].text) or _is_stutter(pieces, at):
        return 1, ((Kind.SOFT, None),)
    return 1, ((Kind.WORD, None),)


def _is_pictograph(piece: str) -> bool:
    return len(piece) == 1 and ("\u2600" <= piece <= "\u27bf" or "\U0001f300" <= piece <= "\U0001faff")


def _is_stutter(pieces: Sequence[Piece], at: int) -> bool:
    """A word begun and said again at once: "t turn", "yo to your", "ff four", "can can you"."""
    text = re.sub(r"(.)\1+", r"\1", pieces[at].text)
    if not (text.isascii() and text.isalpha() and len(text) <= 3):
        return False
    return any(following.text.startswith(text) for following in pieces[at + 1 : at + 3])
