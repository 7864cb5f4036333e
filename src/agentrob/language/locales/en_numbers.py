"""Read English numerals: "two", "one eighty", "three point five"."""

from __future__ import annotations

from collections.abc import Sequence

from text_to_num import text2num

from agentrob.language.parser.lexicon import Piece, digits

NUMERALS = frozenset(
    """zero one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen seventeen
    eighteen nineteen twenty thirty forty fourty fifty sixty seventy eighty ninety hundred thousand""".split()  # noqa: SIM905
)
_STARTS = NUMERALS | {"a", "point"}
_UNITS = frozenset(["one", "two", "three", "four", "five", "six", "seven", "eight", "nine"])
_TENS = frozenset(["twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety", "ten"])


def number(pieces: Sequence[Piece], at: int) -> tuple[float, int] | None:
    """ "2", "0.5", "forty five", "one hundred and thirty five", "a hundred", "zero point eight", "one eighty"."""
    if pieces[at].text not in _STARTS:
        return None if pieces[at].text.isalpha() else digits(pieces, at)
    words = _number_words(pieces, at)
    if not words:
        return None
    said = " ".join("one" if w == "a" else w.replace("fourty", "forty") for w in words)
    whole, _, decimals = said.partition(" point ")
    try:
        value = _whole(whole) if whole != "point" else 0.0
        return value + _decimals(decimals.removeprefix("point ")), len(words)
    except ValueError:
        return None


def _number_words(pieces: Sequence[Piece], at: int) -> list[str]:
    """The run of number words at a place; "and" and "point" only between them, "a" only before hundred or thousand."""
    texts = [p.text for p in pieces[at : at + 12]]
    run: list[str] = []
    for i, word in enumerate(texts):
        following = texts[i + 1] if i + 1 < len(texts) else ""
        joins = word == "and" and run and run[-1] in ("hundred", "thousand") and following in NUMERALS
        joins = joins or (word == "point" and following in _UNITS | {"zero"} and "point" not in run)
        starts = word == "a" and not run and following in ("hundred", "thousand")
        if not (word in NUMERALS or joins or starts):
            break
        run.append(word)
    return run


def _whole(said: str) -> float:
    if not said:
        return 0.0
    words = said.split()
    # "one eighty", "two seventy", "three sixty": hundreds left out, as people say angles.
    if len(words) in (2, 3) and words[0] in _UNITS and words[1] in _TENS and (len(words) == 2 or words[2] in _UNITS):
        return float(text2num(words[0], "en")) * 100 + float(text2num(" ".join(words[1:]), "en"))
    return float(text2num(said, "en"))


def _decimals(said: str) -> float:
    if not said:
        return 0.0
    return float("0." + "".join(str(text2num(word, "en")) for word in said.split()))
