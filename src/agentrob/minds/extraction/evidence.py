"""What a text itself says: its numbers with units, directions, actions and words of doubt, each with its place. Pure.

Kept apart from the grammar on purpose: it is what a model's reading is checked against, and two independent readers do
not share a mistake. It may know more words than the grammar, since words alone never move anything.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

from agentrob.minds.extraction.evidence_words import ACTIONS, DIRECTIONS, FIXED_ANGLES, MARKS, UNITS
from agentrob.model import Direction, Op


class EvidenceKind(StrEnum):
    LENGTH = "length"  # metres
    ANGLE = "angle"  # degrees
    SPEED = "speed"  # metres per second
    NUMBER = "number"  # without a unit
    TIMES = "times"  # how often
    DIRECTION = "direction"
    ACTION = "action"
    NOT = "not"
    IF = "if"
    SLOW = "slow"
    AGAIN = "again"  # what was done before, once more
    BACK = "back"  # what was done before, reversed
    BREAK = "break"  # between two clauses
    END = "end"  # between two sentences


@dataclass(frozen=True, slots=True)
class Evidence:
    """Something that stands in the text at `start` to `end`. `value` is in SI units and degrees."""

    kind: EvidenceKind
    start: int
    end: int
    value: float = 0.0
    direction: Direction | None = None
    op: Op | None = None


_HAN = r"\u3400-\u9fff"
# Ranges, signs, thousands, products and powers are no evidence of either number.
_DIGITS = re.compile(
    r"(?<![a-z0-9_.])(?:(?P<whole>\d{1,6})[ ]+(?P<over>[1-9])/(?P<under>[1-9]\d?)|(?P<n>\d{1,6})/(?P<d>[1-9]\d?)"
    r"|(?P<plain>\d{1,6}(?:\.\d{1,6})?|\.\d{1,6}))(?![\d])(?![.,/:^×][\d])"
)
_BEFORE_BAD = re.compile(r"[-−–~×*^/.,]$")
_AFTER_BAD = re.compile(r"^\s?[-–~×*^]\s?\d|^\s?x\s?\d", re.IGNORECASE)
_EN_NUMBER_WORDS = """zero one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen
sixteen seventeen eighteen nineteen twenty thirty forty fifty sixty seventy eighty ninety hundred thousand""".split()  # noqa: SIM905
_EN = f"(?:{'|'.join(_EN_NUMBER_WORDS)})"
_EN_RUN = re.compile(rf"\b(?:a[ ](?=hundred|thousand))?{_EN}(?:[ -](?:and[ ](?={_EN}\b))?(?:{_EN}|point))*\b")
#: "one eighty", "two seventy": hundreds left out, as people say angles.
_HUNDREDS_LEFT_OUT = re.compile(r"^(one|two|three) ((?:[a-z]+ty)(?: (?!hundred|thousand)[a-z]+)?)$")
_ZH_RUN = re.compile(r"[零〇一二两三四五六七八九十百千]+(?:点[零〇一二三四五六七八九]+)?")
_ONE = re.compile(r"\b(?:an?|single)\b")
_HALF = re.compile(r"\b(?:half(?:[ ](?:an?|of[ ]an?|the))?|(?:a|one)[ ]half)\b|半个?")
_QUARTER = re.compile(r"\b(?:a|one)[ ]quarter(?:[ ]of)?(?:[ ]an?)?\b|四分之一")
_AND_HALF = re.compile(r"[ -](?:and[ ])?a[ -]half\b")
_ZH_TAIL = re.compile(
    rf"^(半|[一二三四五六七八九])(?![{_HAN}\d]*?[米度圈尺厘公分])(?![零一二两三四五六七八九十百千点\d])"
)
_UNIT = re.compile(
    r"^(?:[ ]?-?[ ]?(?:more[ ]|full[ ]|whole[ ]|uh[ ])?|个)("
    + "|".join(
        (rf"{re.escape(w)}(?![a-z/])" if w.isascii() and w[-1].isalpha() else re.escape(w))
        for w in sorted(UNITS, key=len, reverse=True)
    )
    + ")"
)
_PER_SECOND = re.compile(r"每秒钟?$")


def evidence_in(text: str) -> tuple[Evidence, ...]:
    """Everything that a text says, in order."""
    low = _same_length_lower(text)
    amounts = list(_amounts(low))
    taken = [False] * (len(low) + 1)
    for mention in amounts:
        taken[mention.start : mention.end] = [True] * (mention.end - mention.start)
    found = [*amounts, *_words(low, taken)]
    return tuple(sorted(found, key=lambda m: (m.start, m.end)))


def _same_length_lower(text: str) -> str:
    return "".join(c.lower() if len(c.lower()) == 1 else c for c in text).replace("’", "'").replace("‘", "'")


# ---------------------------------------------------------------------- amounts
def _amounts(low: str) -> Iterator[Evidence]:
    """Numbers with the unit after them; without one as bare numbers. Of two that overlap the first and longest."""
    end = 0
    for start, stop, value in sorted(_numbers(low), key=lambda n: (n[0], -n[1])):
        if start < end:
            continue
        mention = _with_unit(low, start, stop, value)
        if mention is None:
            continue
        yield mention
        end = mention.end


def _with_unit(low: str, start: int, stop: int, value: float) -> Evidence | None:
    stop, value = _and_a_half(low, stop, value)
    unit = _UNIT.match(low[stop : stop + 40])
    if unit is None:
        weak = low[start:stop] in ("a", "an", "半", "半个", "half", "single") or low[start:stop].startswith("half")
        return None if weak else Evidence(EvidenceKind.NUMBER, start, stop, value)
    kind, factor = UNITS[unit[1]]
    end = stop + unit.end()
    if kind == "length":
        tail = _ZH_TAIL.match(low[end : end + 8]) if not unit[1].isascii() else None
        if tail:  # 一米五, 两米半
            value += 0.5 if tail[1] == "半" else "一二三四五六七八九".index(tail[1]) / 10 + 0.1
            end += 1
        half = _AND_HALF.match(low[end : end + 12])
        if half:  # "a metre and a half"
            value, end = value + 0.5, end + half.end()
        if before := _PER_SECOND.search(low[:start]):  # 每秒0.3米
            return Evidence(EvidenceKind.SPEED, before.start(), end, value * factor)
    return Evidence(EvidenceKind(kind), start, end, round(value * factor, 6))


def _and_a_half(low: str, stop: int, value: float) -> tuple[int, float]:
    half = _AND_HALF.match(low[stop : stop + 12])
    return (stop + half.end(), value + 0.5) if half else (stop, value)


def _numbers(low: str) -> Iterator[tuple[int, int, float]]:
    """Every number in digits or words: start, end, value."""
    for match in _DIGITS.finditer(low):
        if _BEFORE_BAD.search(low[: match.start()][-1:]) or _AFTER_BAD.match(low[match.end() : match.end() + 4]):
            continue
        yield match.start(), match.end(), _digits_value(match)
    for pattern, value in ((_QUARTER, 0.25), (_HALF, 0.5), (_ONE, 1.0)):
        for match in pattern.finditer(low):
            yield match.start(), match.end(), value
    for match in _EN_RUN.finditer(low):
        if (number := _english(match[0])) is not None:
            yield match.start(), match.end(), number
    for match in _ZH_RUN.finditer(low):
        if (number := _chinese(match[0])) is not None:
            yield match.start(), match.end(), number


def _digits_value(match: re.Match[str]) -> float:
    if match["plain"]:
        return float(match["plain"])
    if match["n"]:
        return int(match["n"]) / int(match["d"])
    return int(match["whole"]) + int(match["over"]) / int(match["under"])


#: Numbers that take more letters are none that a robot walks or turns by.
_LONGEST_NUMBER = 60


def _english(words: str) -> float | None:
    if len(words) > _LONGEST_NUMBER:
        return None
    from text_to_num import text2num

    whole, _, decimals = words.replace("-", " ").partition(" point ")
    try:
        said = re.sub(r"^a ", "one ", whole).replace(" and ", " ")
        said = _HUNDREDS_LEFT_OUT.sub(r"\1 hundred \2", said)
        value = float(text2num(said, "en"))
        if decimals:
            value += float("0." + "".join(str(_EN_NUMBER_WORDS.index(w)) for w in decimals.split()))
        return value
    except ValueError:
        return None


def _chinese(words: str) -> float | None:
    if len(words) > _LONGEST_NUMBER / 5:
        return None
    import cn2an

    try:
        return float(cn2an.cn2an(words.replace("〇", "零"), "smart"))
    except (ValueError, KeyError, IndexError, OverflowError):
        return None


# ---------------------------------------------------------------------- words
def _pattern(phrases: dict[str, object]) -> re.Pattern[str]:
    """Longest phrase first; Latin words whole, Chinese ones anywhere."""
    parts = [
        rf"(?<![a-z']){re.escape(p)}(?![a-z'])" if p.isascii() and p[0].isalpha() else re.escape(p)
        for p in sorted(phrases, key=len, reverse=True)
    ]
    return re.compile("|".join(parts))


#: What 起来 may follow so that it means to get up.
_RISES_AFTER = "站坐爬立你您请快就再并后吧先"
_ALL: dict[str, object] = {**dict.fromkeys((*ACTIONS, *DIRECTIONS, *FIXED_ANGLES, *MARKS))}
_WORDS = _pattern(_ALL)


def _words(low: str, taken: list[bool]) -> Iterator[Evidence]:
    """Words with a meaning, outside of amounts. One phrase can be several things ("back up": going, backward)."""
    for match in _WORDS.finditer(low):
        start, end, phrase = match.start(), match.end(), match[0]
        if any(taken[start:end]) or (phrase == "." and low[end : end + 1].isdigit()):
            continue
        if phrase == "起来" and re.search(rf"[{_HAN}]$", low[:start]) and low[start - 1] not in _RISES_AFTER:
            continue  # 嗨起来
        for op in ACTIONS.get(phrase, ()):
            yield Evidence(EvidenceKind.ACTION, start, end, op=op)
        if direction := DIRECTIONS.get(phrase):
            yield Evidence(EvidenceKind.DIRECTION, start, end, direction=direction)
        if angle := FIXED_ANGLES.get(phrase):
            yield Evidence(EvidenceKind.ACTION, start, end, op=Op.TURN)
            yield Evidence(EvidenceKind.ANGLE, start, end, angle)
        if mark := MARKS.get(phrase):
            name, value = mark
            yield Evidence(EvidenceKind(name), start, end, value)
