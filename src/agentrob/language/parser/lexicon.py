"""Map words to meanings, and split a text into tokens.

A language is a file in the folder `locales` with a table from meanings to the phrases people use. A meaning is one or
more symbols, `kind` or `kind=value`: "move" is a verb, "move dir=backward" is a verb with a direction ("back up").
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import lru_cache
from typing import Any, NamedTuple

from agentrob.model import Language


class TokenKind(StrEnum):
    """Parts of speech in the domain of a robot."""

    MOVE = "move"  # a verb of motion in any direction; values "sideways", "to" (to a place), "gait" (how to walk)
    TURN = "turn"  # a verb of turning on the spot
    DIR = "dir"  # forward, backward, left, right
    ALONG = "along"  # down, up: ahead, where a walk has no other direction
    #: A gesture, picture or routine: "wave"; value "shake/hello": the second if the robot lacks the first.
    OP = "op"
    ARGUMENT = "argument"  # of an operation that a robot declares; value: "name=option"
    BEYOND = "beyond"  # beyond the robots' abilities: eyes ("find"), hands ("pick up"), path ("in a circle"), wait
    AGAIN = "again"  # repeat what was done before; values: "back", the way back; "more"; "move", "turn": one
    BACK = "back"  # stands before a walk backward that, without a distance, is the way back
    NUMBER = "number"
    LENGTH_UNIT = "length_unit"  # value: metres
    ANGLE_UNIT = "angle_unit"  # value: degrees
    SPEED_UNIT = "speed_unit"  # value: metres per second
    STEP_UNIT = "step_unit"  # a step has no length unless the robot's configuration gives one
    TIME_UNIT = "time_unit"  # value: seconds
    PER_SECOND = "per_second"  # 每秒 before a length
    LENGTH = "length"  # a number with its unit, in metres
    ANGLE = "angle"  # in degrees
    SPEED = "speed"  # in metres per second
    STEPS = "steps"
    DURATION = "duration"  # in seconds
    HALF = "half"
    AND_PART = "and_part"  # "and a half"; value: the part
    TIMES_UNIT = "times_unit"
    TIMES = "times"
    MORE_TIMES_UNIT = "more_times_unit"  # "three more times": besides the first
    MORE_TIMES = "more_times"
    SHOW = "show"  # take, send, 拍: with a picture after it; value "picture": also one alone: "snap"
    PICTURE = "picture"
    OF = "of"  # what follows a picture or a greeting is its subject and commands nothing; values "look", "watch": 看看
    EACH = "each"  # "after each movement"; value: after which operation only
    VAGUE = "vague"  # "a bit"
    SLOW = "slow"  # value "er": slower than before
    FASTER = "faster"
    SOFT = "soft"  # politeness, hesitation, articles: no meaning of its own; values: see `Soft`
    THANKS = "thanks"  # the same; a name may follow; value "hello": a greeting
    AGREE = "agree"  # "right" as in "right, take a photo"; the direction follows
    AND = "and"  # joins clauses: and, then
    AFTER = "after"  # 后, 前: a direction, or after an action what joins (value "and") or a condition ("condition")
    COMMA = "comma"  # separates clauses and ends a negation; values "colon", and "word": one that may also be an adverb
    END = "end"  # ends a sentence
    ASKED = "asked"  # a question mark, 吗
    REQUEST = "request"  # can you, please: what follows is requested
    WISH = "wish"  # we should, you can: what follows is requested unless within talk
    TALK = "talk"  # begins a statement, which is not a command; values: "question"; "ask" and "tell": wants an answer
    TALK_START = "talk_start"  # the same, but only where a clause begins
    IS = "is"  # 是: talk, or a correction when a motion was said before it
    REPORT = "report"  # the past: the sentence is not a command
    #: if, until, or: beyond these rules; value "wait": 等五秒 waits; "later": a time; "hedge": maybe; "after"; "ends":
    #: 的话, which stands at the end of its clause.
    CONDITION = "condition"
    NOT = "not"
    NO = "no"  # "no" before a comma or after a motion: what follows corrects it
    FIX = "fix"  # "no wait", 不对: what follows corrects what was said; value "amount": "make it", in the same unit
    CANCEL = "cancel"  # "never mind": cancels earlier posts
    HELP = "help"
    STATUS = "status"  # value "battery": also within a question; "asked": only there
    MORE_STOP = "stop"  # "and stop" at the end; value "wait": only there
    GO_AHEAD = "go_ahead"  # encouragement, or a direction when a length follows
    WORD = "word"  # an unknown word; value "number": an unreadable number, "place": a place


class Soft(StrEnum):
    """How a word without meaning of its own affects its neighbours; a numeric value stands for "a": one, before a
    unit.
    """

    HELLO = "hello"
    UH = "uh"  # hesitates: what was begun may begin anew
    IN = "in"  # inches, after a number at the end of a clause
    TO = "to"  # an unknown word after it is a place, where one goes
    THE = "the"  # the same
    TOWARDS = "towards"  # an unknown word after it is a place
    OBJECT = "object"  # 把: belongs to the thing after it
    SEND = "send"  # "post it": a picture, which must have been taken
    MORE = "more"  # "three more feet": as before
    ONE_MORE = "one_more"  # "another": one more of what was before, or of the unit after it
    ASSENT = "assent"  # "yes", "now": alone it says that something is to be done, but not what
    FOR = "for"  # 给, 对: for whom something is to be done


Value = float | str | None


class Token(NamedTuple):
    """A phrase with its meaning; `start` and `end` are its position in the text.

    Of an amount `unit` is one unit in metres, degrees or seconds; `more` says of it or of a picture that it is "more",
    "another".
    """

    kind: TokenKind
    value: Value = None
    start: int = 0
    end: int = 0
    unit: float = 0.0
    more: bool = False


class Piece(NamedTuple):
    """A word, a number in digits, one Chinese character or a punctuation mark, in lower case."""

    text: str
    start: int
    end: int


#: Reads a number from the pieces at a position: (value, number of pieces), or None.
NumberReader = Callable[[Sequence[Piece], int], tuple[float, int] | None]


Meaning = tuple[tuple[TokenKind, Value], ...]
_SIDE_WORDS = {TokenKind.DIR, TokenKind.AGREE, TokenKind.BACK}


@dataclass(frozen=True, eq=False)
class Lexicon:
    """The vocabulary of one language.

    `phrases` maps pieces to meanings; `number` reads its numerals, which consist of `numerals`. `misspelt` maps common
    typing mistakes to the intended words; `misread` maps phrases that are known although they are written with a
    wrong character (往钱) to the intended ones, so that the reply can say so; `twins` maps a character to
    its standard variant.
    """

    language: Language
    phrases: Mapping[tuple[str, ...], Meaning]
    number: NumberReader
    numerals: frozenset[str] = frozenset()
    misspelt: Mapping[str, str] = field(default_factory=dict)
    misread: Mapping[str, str] = field(default_factory=dict)
    twins: Mapping[int, int] = field(default_factory=dict)
    vocabulary: frozenset[str] = field(init=False)
    #: Beginnings of words that people break off, and say again or replace: "turn ri left", "thir forty degrees".
    begun_sides: frozenset[str] = field(init=False)
    begun_numerals: frozenset[str] = field(init=False)
    _tree: dict[str, Any] = field(init=False)

    def __post_init__(self) -> None:
        tree: dict[str, Any] = {}
        for phrase, meaning in self.phrases.items():
            at = tree
            for word in phrase:
                at = at.setdefault(word, {})
            at[""] = meaning
        said = frozenset(word for phrase in self.phrases for word in phrase) | self.numerals
        sides = {phrase[0] for phrase, meaning in self.phrases.items() if {k for k, _ in meaning} <= _SIDE_WORDS}
        object.__setattr__(self, "_tree", tree)
        object.__setattr__(self, "vocabulary", said)
        object.__setattr__(self, "begun_sides", _beginnings(sides))
        object.__setattr__(self, "begun_numerals", _beginnings(self.numerals))

    def longest(self, pieces: Sequence[Piece], at: int, end: int | None = None) -> tuple[int, Meaning | None]:
        """Return the longest phrase at this position, up to `end`, as (number of pieces, meaning), or (0, None)."""
        node, best, meaning = self._tree, 0, None
        for here in range(at, len(pieces) if end is None else end):
            if (following := node.get(pieces[here].text)) is None:
                break
            node = following
            if "" in node:
                best, meaning = here + 1 - at, node[""]
        return best, meaning


def _beginnings(said: Iterable[str]) -> frozenset[str]:
    return frozenset(word[:n] for word in said if word.isascii() for n in range(1, min(len(word), 4)))


def lexicon(
    language: Language,
    table: Mapping[str, str],
    number: NumberReader,
    *,
    numerals: frozenset[str] = frozenset(),
    twins: Mapping[int, int] | None = None,
    misread: Mapping[str, str] | None = None,
    extends: Lexicon | None = None,
) -> Lexicon:
    """Build a language from its table; phrases are separated by | and written as people write them."""
    phrases: dict[tuple[str, ...], Meaning] = {}
    for meaning, words in (*PUNCTUATION.items(), *table.items()):
        symbols = tuple(_symbol(s) for s in meaning.split())
        for phrase in words.replace("\n", " ").split("|"):
            if key := _phrase(phrase):
                phrases[key] = symbols
    wanted = {key[0] for key, symbols in phrases.items() if len(key) == 1 and symbols[0][0] in _SPELT}
    mistakes = [(wrong, right) for right in sorted(wanted) for wrong in misspellings(right)]
    if extends:
        phrases, mistakes = {**extends.phrases, **phrases}, [*extends.misspelt.items(), *mistakes]
    known = {word for phrase in phrases for word in phrase} | numerals
    misspelt = {wrong: right for wrong, right in mistakes if wrong not in known}
    return Lexicon(language, phrases, number, numerals, misspelt, misread or {}, twins or {})


_PLAIN_WORDS, _PLAIN_HAN = re.compile("[a-z ]*"), re.compile(" *([\u3400-\u9fff]*) *")


def _phrase(written: str) -> tuple[str, ...]:
    """Return the pieces of a phrase in a table; plain words and Chinese are split without the regular expression."""
    if _PLAIN_WORDS.fullmatch(written):
        return tuple(written.split())
    if han := _PLAIN_HAN.fullmatch(written):
        return tuple(han[1])
    return tuple(piece.text for piece in pieces_of(written))


#: Punctuation means the same in every language.
PUNCTUATION = {
    "comma": ",|/|;|(|)|[|]|—|，|、|；|（|）|【|】",
    "comma=colon": ":|：",
    "end": ".|!|…|。|！|．",
    "asked end": "?|？",
    "and": "&|+",
}
_SPELT = (
    TokenKind.MOVE,
    TokenKind.TURN,
    TokenKind.DIR,
    TokenKind.AGREE,
    TokenKind.OP,
    TokenKind.LENGTH_UNIT,
    TokenKind.ANGLE_UNIT,
    TokenKind.PICTURE,
)


_LONGEST_NUMBER = 15


def digits(pieces: Sequence[Piece], at: int) -> tuple[float, int] | None:
    """Read a number in digits: "2", "0.5", "1/2"; None if it has too many digits to be meant."""
    first = pieces[at].text
    if len(first) > _LONGEST_NUMBER or first[-1] not in "0123456789" or first[0] not in "0123456789.":
        return None
    above, _, below = first.replace("⁄", "/").partition("/")
    return float(above) / float(below or 1), 1


def _symbol(text: str) -> tuple[TokenKind, Value]:
    name, _, value = text.partition("=")
    try:
        return TokenKind(name), float(value) if value else None
    except ValueError:
        return TokenKind(name), value


_PIECE = re.compile(
    # 1,500 · -2 · 2-3 · 2x3: not to be guessed
    r"(?P<bad>[0-9]+(?:,[0-9]+)+(?:\.[0-9]+)?|(?<![^\W\u3400-\u9fff])[-−]\.?[0-9]+|[0-9]+[-–~][0-9]+|[0-9]+[x×*^][0-9]+)"
    # An arrow leads to a word: before an amount it may be "more than", and before nothing the end of a comment.
    r"|(?P<arrow>(?:[=-]*>+|[→➡➜➔⇒⟶])\ufe0f?(?=\s*[^\W\d_一二两三四五六七八九十百半]))"
    r"|(?P<feet>[0-9]+)['′]\s?(?P<inches>[0-9]+)(?:[\"”″]|''|′′)?(?!\w)"  # 6'2"
    r"|[0-9]+[/⁄][1-9][0-9]*|[0-9]+(?:\.[0-9]+)?(?![.]?[0-9])|\.[0-9]+"
    r"|[^\W\d_\u3400-\u9fff]+(?:'[^\W\d_\u3400-\u9fff]+)*"
    r"|[\u3400-\u9fff]"
    r"|[^\s\w]|\w",
)
_IGNORED_MARKS = frozenset("*_\"'“”‘’「」『』«»`-~#¡¿")
_DASHES = frozenset("–—―")
#: Between spaces they separate, as the marks of a list or a table do.
_BULLETS = frozenset("-•▪◦‣●|")


def pieces_of(text: str) -> list[Piece]:
    """Split a text into pieces. A hyphen joins words ("forty-five"), a dash between spaces separates them."""
    lowered = _same_length_lower(text).replace("’", "'").replace("‘", "'")
    found: list[Piece] = []
    for match in _PIECE.finditer(lowered):
        piece, (start, end) = match[0], match.span()
        if match.lastgroup == "bad":
            found.append(Piece("\0" + piece, start, end))
        elif match.lastgroup == "arrow":
            found.append(Piece("&", start, end))
        elif match.lastgroup is not None:
            (feet, inches), last = (match.span(part) for part in ("feet", "inches")), match.end("inches")
            found += [Piece(match["feet"], *feet), Piece("′", *feet), Piece(match["inches"], *inches)]
            found.append(Piece("″", last, max(last, end)))
        elif (piece in _BULLETS and _stands_alone(lowered, start)) or piece in _DASHES:
            found.append(Piece("—", start, end))
        elif piece not in _IGNORED_MARKS:
            found.append(Piece(piece, start, end))
    return found


def _stands_alone(text: str, at: int) -> bool:
    return (at == 0 or text[at - 1].isspace()) and text[at + 1 : at + 2].isspace()


def _same_length_lower(text: str) -> str:
    """Return the text in lower case with every character at its position (İ would become two characters)."""
    lowered = text.lower()
    return lowered if len(lowered) == len(text) else "".join(c.lower() if len(c.lower()) == 1 else c for c in text)


@lru_cache(maxsize=128)
def tokens_of(text: str, words: Lexicon) -> tuple[tuple[Token, ...], tuple[tuple[str, str], ...]]:
    """Split a text into tokens, the longest known phrase first; line ends separate like commas.

    Also return the words that were taken for typing mistakes, each as (written, meant).
    """
    found: list[Token] = []
    plain = text.translate(words.twins) if words.twins else text
    pieces, mistyped = _spelt(pieces_of(plain), words)
    misread = [(wrong, right) for wrong, right in words.misread.items() if wrong in plain]
    lines = _line_ends(pieces, text)
    at = line = 0
    while at < len(pieces):
        while lines[line] < at:
            line += 1
        if at == lines[line]:
            found.append(Token(TokenKind.COMMA, None, pieces[at].start, pieces[at].start))
            line += 1
        length, meaning = words.longest(pieces, at, lines[line])  # "90 degrees⏎turn around" is no "degrees turn"
        number = words.number(pieces, at)
        if number and (meaning is None or number[1] > length):
            length, meaning = number[1], ((TokenKind.NUMBER, number[0]),)
        if meaning is None:
            length = _hesitation(pieces, at, words)
            run = 0 if length else _odd_numerals(pieces, at, words)
            odd = ((TokenKind.WORD, "number" if run else None),)
            length, meaning = (length, ((TokenKind.SOFT, None),)) if length else (run or 1, odd)
        start, end = pieces[at].start, pieces[at + length - 1].end
        if misread:
            mistyped += [(wrong, right) for wrong, right in misread if wrong in plain[start:end]]
        found += [Token(kind, value, start, end) for kind, value in meaning]
        at += length
    return tuple(found), tuple(mistyped)


def _line_ends(pieces: Sequence[Piece], text: str) -> list[int]:
    """Return at which piece each line ends."""
    begun = (at for at in range(1, len(pieces)) if "\n" in text[pieces[at - 1].end : pieces[at].start])
    return [*(begun if "\n" in text else ()), len(pieces)]


def _odd_numerals(pieces: Sequence[Piece], at: int, words: Lexicon) -> int:
    """Return how many pieces here form a number that cannot be read: "1,500", "2-3", 两三 in 两三米; 0 for none."""
    end = at
    while end < len(pieces) and (pieces[end].text[0] in "\0.0123456789" or pieces[end].text in words.numerals):
        end += 1
    return end - at


def _spelt(pieces: list[Piece], words: Lexicon) -> tuple[list[Piece], list[tuple[str, str]]]:
    """Return the pieces with typing mistakes corrected, and the corrections."""
    wrong = {p.text: words.misspelt[p.text] for p in pieces if p.text in words.misspelt}
    if not wrong:
        return pieces, []
    return [Piece(wrong.get(p.text, p.text), p.start, p.end) for p in pieces], list(wrong.items())


def _hesitation(pieces: Sequence[Piece], at: int, words: Lexicon) -> int:
    """Return how many pieces here are emoji or words that are broken off and repeated; 0 for none.

    Examples: "t turn", "yo to your", "ff four"; before a number also the beginning of another one, and so before a
    direction: "fif ninety degrees", "to the r left", "nin degree ninety degrees".
    """
    piece = pieces[at].text
    if len(piece) == 1 and ("\u2600" <= piece <= "\u27bf" or "\U0001f300" <= piece <= "\U0001faff"):
        return 1
    if not (piece.isascii() and piece.isalpha() and len(piece) <= 12):
        return 0
    if len(piece) > 3 and piece[0] != piece[1]:
        return 0
    begun = re.sub(r"^(.)\1+", r"\1", piece)
    if len(begun) > 3:
        return 0
    if begun in words.begun_numerals and _is_unit(pieces, at + 1, words) and _is_number(pieces, at + 2, words):
        return 2
    again = any(following.text.startswith(begun) for following in pieces[at + 1 : at + 3])
    # One or two letters may also be short for a side ("l", "ne"), but hardly "fff" or "fif".
    numeral = begun in words.begun_numerals and (
        len(piece) > len(begun) or (len(begun) == 3 and begun not in words.begun_sides)
    )
    return 1 if again or _is_replaced(pieces, at + 1, words, side=begun in words.begun_sides, numeral=numeral) else 0


def _is_unit(pieces: Sequence[Piece], at: int, words: Lexicon) -> bool:
    meaning = words.longest(pieces, at)[1]
    return meaning is not None and meaning[0][0] in (TokenKind.LENGTH_UNIT, TokenKind.ANGLE_UNIT)


def _is_number(pieces: Sequence[Piece], at: int, words: Lexicon) -> bool:
    return at < len(pieces) and words.number(pieces, at) is not None


def _is_replaced(pieces: Sequence[Piece], at: int, words: Lexicon, *, side: bool, numeral: bool) -> bool:
    """Return whether the word here replaces one that was begun, a `side` or a `numeral`. In "walk l 1 m" nothing
    replaces the side."""
    if at >= len(pieces):
        return False
    meaning = words.longest(pieces, at)[1]
    is_side = meaning is not None and meaning[-1][0] is TokenKind.DIR
    return (side and is_side) or (numeral and _is_number(pieces, at, words))


# ---------------------------------------------------------------------- spelling mistakes
#: Real words that are one typing mistake away from a known word, and must not be corrected.
_OTHER_WORDS = """ange carb cree crepe dane dive ever feat ford gallo hart heat loop mach marc mere mete moor moto
    niches nude revere riot rotes sake sand saps sasha scot serve shit sift sill sins slid soot stan steep step
    steps swig taps tort trad trod twit""".split()  # noqa: SIM905
_SHORTEST, _SHORTEST_WITH_GAP = 4, 5


def misspellings(word: str) -> frozenset[str]:
    """Return the likely typing mistakes of a word of at least four Latin letters; the first letter is never dropped."""
    if len(word) < _SHORTEST or not (word.isascii() and word.isalpha()):
        return frozenset()
    return frozenset(_slips(word)).difference(_OTHER_WORDS, {word})


def _slips(word: str) -> Iterator[str]:
    for at in range(len(word) - 1):
        yield word[:at] + word[at + 1] + word[at] + word[at + 2 :]
    for at, letter in enumerate(word):
        yield word[:at] + letter + word[at:]
        if at and len(word) >= _SHORTEST_WITH_GAP:
            yield word[:at] + word[at + 1 :]


# ---------------------------------------------------------------------- statements of where things are
_CLAUSE = re.compile(r"(?:[^，,。.！!？?；;：:\n]|(?<=\d)\.(?=\d))+")


def without_statements(part: str, stated: str, twins: Mapping[int, int] | None = None) -> str:
    """Blank out clauses that state where something is, so that they are not parsed as commands: 前面五米是墙.

    `stated` is a language's pattern for their beginning, in the standard characters of `twins`. Questions stay.
    """
    if not stated:
        return part
    said = re.compile(rf"\s*{stated}")

    def blank(clause: re.Match[str]) -> str:
        asked = part[clause.end() : clause.end() + 1] in ("?", "？")
        found = None if asked else said.match(clause[0].translate(twins or {}))
        return " " * found.end() + clause[0][found.end() :] if found else clause[0]

    return _CLAUSE.sub(blank, part)
