"""Find what a text itself says: numbers with units, directions, actions and words of doubt, with their positions. Pure.

It is separate from the grammar on purpose: a model's reading is checked against it, and two independent readers do not
share a mistake. It may know more words than the grammar, because evidence alone never moves anything.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import TypeVar

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
    AGAIN = "again"  # repeats what was done before
    BACK = "back"  # reverses what was done before
    BREAK = "break"  # between two clauses
    END = "end"  # between two sentences


@dataclass(frozen=True, slots=True)
class Evidence:
    """Something the text says from `start` to `end`. `value` is in SI units and degrees."""

    kind: EvidenceKind
    start: int
    end: int
    value: float = 0.0
    direction: Direction | None = None
    op: str | None = None


V = TypeVar("V")


# ---------------------------------------------------------------------- the words
def _table(rows: Mapping[str, V]) -> dict[str, V]:
    """Map phrases separated by | to their meaning."""
    return {phrase.strip(): value for phrases, value in rows.items() for phrase in phrases.split("|")}


#: Only forms that can be commands; "walked" and "has turned" are not.
ACTIONS: dict[str, tuple[Op, ...]] = _table(
    {
        "walk|move|go|step|advance|proceed|stroll|march|travel|"
        "head|come|drive|run|trot|crawl|scoot|shuffle|strafe|"
        "go back|walk back|move back|come back|step back|sidestep|walking|moving|going|approach|"
        "retreat|back up|back off|reverse|pace|roll|creep|amble|wander|"
        "走|移动|前进|前行|后退|倒退|退后|退|行走|平移|横移|挪|移|迈|跑|直走|直行|过去|过来|靠近": (Op.MOVE,),
        "turn back|turn|rotate|spin|pivot|swivel|twist|face|swing|turning|rotating|"
        "veer|转|旋转|转动|转向|转身|掉头|调头|拐|扭": (Op.TURN,),
        "wave|waving|greet|say hello|say hi|greeting|hello|打招呼|打个招呼|招手|挥手|挥挥手|问好|问个好|你好": (
            Op.HELLO,
        ),
        "shake hands|shake hand|shake my hand|shake a hand|handshake|shake paws|shake paw|"
        "offer your hand|give me your hand|give me your paw|give paw|give me a paw|offer your paw|"
        "握手|握个手|握握手|握一握手|握一下手|伸出手|伸爪子|给个爪子": (Op.SHAKE, Op.HELLO),
        "clap|clapping|clap hands|applaud|applause|"
        "鼓掌|鼓个掌|鼓鼓掌|拍手|拍拍手|拍个手|拍一拍手|拍一下手|拍掌|拍拍掌|拍巴掌": (Op.CLAP,),
        "heart|make a heart|show love|比心|比个心|爱心|画心|画个心": (Op.HEART,),
        "backflip|back flip|flip|somersault|后空翻|空翻|翻跟头|翻个跟头|跟斗": (Op.BACKFLIP,),
        "sit|sit down|have a seat|take a seat|坐|坐下": (Op.SIT,),
        "stand|stand up|get up|rise|站起来|起立|站立|起来": (Op.STAND,),
        "stretch|stretching|limber up|伸懒腰|伸个懒腰|伸展|拉伸|舒展": (Op.STRETCH,),
        "photo|picture|pic|photograph|image|snapshot|snap|shot|"
        "selfie|camera|look|see|show me|what do you see|view|"
        "photos|pictures|pics|images|拍照|照片|拍|照相|"
        "照|图片|看看|看一下|看见|看到|画面|相片": (Op.GET_FRONT_IMAGE,),
    }
)

DIRECTIONS: dict[str, Direction] = _table(
    {
        "forward|forwards|ahead|straight|straight ahead|onward|onwards|advance|frontward|"
        "前|向前|往前|朝前|前进|前行|直走|直行|前面|前方": Direction.FORWARD,
        "go back|walk back|move back|come back|step back|and back|now back|backward|backwards|"
        "back|back up|back off|retreat|reverse|rearward|rearwards|behind|"
        "后|向后|往后|朝后|后退|倒退|退后|退|后面|后方": Direction.BACKWARD,
        "left|leftward|leftwards|counterclockwise|counter-clockwise|anticlockwise|anti-clockwise|port|"
        "左|向左|往左|左边|左侧|左转|左拐|逆时针": Direction.LEFT,
        "right|rightward|rightwards|clockwise|starboard|右|向右|往右|右边|右侧|右转|右拐|顺时针": Direction.RIGHT,
    }
)
# "左转" is a direction and an action at once.
ACTIONS |= dict.fromkeys(("左转", "左拐", "右转", "右拐"), (Op.TURN,))

#: What phrases with an angle of their own ask for.
TURNING = Op.TURN
#: Phrases that say an angle without a number.
FIXED_ANGLES: dict[str, float] = _table(
    {
        "turn around|turn round|about face|u-turn|u turn|half turn|half circle|"
        "掉头|调头|转身|转过身|转过去|向后转|转半圈": 180.0,
        "full turn|full circle|full rotation|complete turn|all the way around|"
        "spin around|转一圈|转个圈|转圈|转一整圈": 360.0,
        "right angle|quarter turn|直角|四分之一圈": 90.0,
    }
)

#: Other words that matter: (kind, value).
QUALIFIERS: dict[str, tuple[str, float]] = _table(
    {
        "don't|do not|dont|not|never|no|without|avoid|instead of|rather than|neither|nor|refuse|stop|"
        "cannot|can't|won't|"
        "shouldn't|must not|mustn't|isn't|wasn't|didn't|forget|ignore|except|"
        "不|别|勿|没|没有|不要|不用|禁止|拒绝|避免|停|停止|除了": ("not", 0.0),
        "if|unless|until|while|whenever|when|once|as soon as|otherwise|or|either|whether|"
        "如果|要是|假如|除非|直到|的时候|一旦|否则|或者|或|等到|当": ("if", 0.0),
        "slow|slowly|slower|carefully|gently|gentle|careful|slow down|慢|慢慢|缓慢|小心|轻轻|慢一点|慢点": (
            "slow",
            0.0,
        ),
        "again|once more|one more time|repeat|same|the same|do it|do that|redo|another|more|further|"
        "再|又|再来|再一次|重复|同样|一样|继续|还": ("again", 0.0),
        "undo|return|come back|go back|walk back|turn back|"
        "move back|back again|back to where|and back|now back|"
        "回来|回去|返回|回到|退回|转回": ("back", 0.0),
        "twice|two times|两次|两遍|两回|二次": ("times", 2.0),
        "thrice|three times|三次|三遍|三回": ("times", 3.0),
        "four times|四次|四遍": ("times", 4.0),
        "five times|五次|五遍": ("times", 5.0),
        "then|and|and then|go ahead and|after that|afterwards|next|before|after|but|while|followed by|finally|also|"
        "plus|"
        ",|;|:|(|)|[|]|—|–|，|、|；|：|（|）|然后|接着|并|并且|之后|随后|最后|而后|但|但是|同时": ("break", 0.0),
        ".|!|?|。|！|？|…": ("end", 0.0),
    }
)
QUALIFIERS["\n"] = ("end", 0.0)

_LENGTHS = {
    "m|meter|meters|metre|metres|米|公尺": 1.0,
    "cm|centimeter|centimeters|centimetre|centimetres|厘米|公分": 0.01,
    "mm|millimeter|millimeters|millimetre|millimetres|毫米": 0.001,
    "dm|分米": 0.1,
    "km|kilometer|kilometers|kilometre|kilometres|公里|千米": 1000.0,
    "ft|foot|feet|英尺": 0.3048,
    "in|inch|inches|英寸": 0.0254,
    "yd|yard|yards|码": 0.9144,
}
_ANGLES = {
    "deg|degree|degrees|°|度": 1.0,
    "rad|radian|radians|弧度": 57.29577951308232,
    "turn|turns|revolution|revolutions|rotation|rotations|circle|circles|圈|周": 360.0,
}
_SPEEDS = {
    "m/s|mps|meters per second|metres per second|"
    "meter per second|metre per second|meters a second|metres a second|"
    "米每秒|米/秒": 1.0,
    "cm/s|centimeters per second|centimetres per second|厘米每秒|厘米/秒": 0.01,
    "ft/s|feet per second": 0.3048,
    "km/h|kph|kmh|kilometers per hour|kilometres per hour|公里每小时|公里/小时": 1 / 3.6,
    "mph|miles per hour": 0.44704,
}
#: A unit as written: (kind, factor to metres, degrees or metres per second). "times" counts.
UNITS: dict[str, tuple[str, float]] = {
    **{p: ("length", f) for p, f in _table(_LENGTHS).items()},
    **{p: ("angle", f) for p, f in _table(_ANGLES).items()},
    **{p: ("speed", f) for p, f in _table(_SPEEDS).items()},
    **dict.fromkeys(("times", "次", "遍", "回", "下", "张"), ("times", 1.0)),
}

# ---------------------------------------------------------------------- the patterns
_HAN = r"\u3400-\u9fff"
# Ranges, signs, thousands, products and powers are not evidence of either number.
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
    """Return everything that a text says, in order."""
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
    """Yield numbers with their units, or as plain numbers; of overlapping ones the first and longest."""
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
    """Yield every number in digits or words: start, end, value."""
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


#: Numbers with more letters are not distances or angles for a robot.
_LONGEST_NUMBER = 60


def _english(words: str) -> float | None:
    if len(words) > _LONGEST_NUMBER:
        return None
    from text_to_num import text2num

    whole, _, decimals = words.replace("-", " ").partition(" point ")
    try:
        counted = re.sub(r"^a ", "one ", whole).replace(" and ", " ")
        counted = _HUNDREDS_LEFT_OUT.sub(r"\1 hundred \2", counted)
        value = float(text2num(counted, "en"))
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
    """Return an alternation, longest phrase first; Latin words match whole words, Chinese ones anywhere."""
    parts = [
        rf"(?<![a-z']){re.escape(p)}(?![a-z'])" if p.isascii() and p[0].isalpha() else re.escape(p)
        for p in sorted(phrases, key=len, reverse=True)
    ]
    return re.compile("|".join(parts))


#: A purpose, and the words in it that request no photo: "2 m back to get a better view".
_PURPOSE = re.compile(r"\b(?:to (?:get|have)|for) an? \w+ (?:view|look)\b|(?:好让|为了|免得)[^，。；！？,.;!?]*")
_SIGHT = frozenset(["see", "view", "look", "看见", "看到", "看看", "看一下"])
#: Characters before 起来 with which it means to get up.
_RISES_AFTER = "站坐爬立你您请快就再并后吧先"
_ALL: dict[str, object] = {**dict.fromkeys((*ACTIONS, *DIRECTIONS, *FIXED_ANGLES, *QUALIFIERS))}
_WORDS = _pattern(_ALL)


def _words(low: str, taken: list[bool]) -> Iterator[Evidence]:
    """Yield words with a meaning, outside of amounts. One phrase can be several ("back up": motion, backward)."""
    purposes = [match.span() for match in _PURPOSE.finditer(low)]
    for match in _WORDS.finditer(low):
        start, end, phrase = match.start(), match.end(), match[0]
        if phrase in _SIGHT and any(begin <= start < stop for begin, stop in purposes):
            continue
        if any(taken[start:end]) or (phrase == "." and low[end : end + 1].isdigit()):
            continue
        if phrase == "起来" and re.search(rf"[{_HAN}]$", low[:start]) and low[start - 1] not in _RISES_AFTER:
            continue  # 嗨起来
        for op in ACTIONS.get(phrase, ()):
            yield Evidence(EvidenceKind.ACTION, start, end, op=op)
        if direction := DIRECTIONS.get(phrase):
            yield Evidence(EvidenceKind.DIRECTION, start, end, direction=direction)
        if angle := FIXED_ANGLES.get(phrase):
            yield Evidence(EvidenceKind.ACTION, start, end, op=TURNING)
            yield Evidence(EvidenceKind.ANGLE, start, end, angle)
        if mark := QUALIFIERS.get(phrase):
            name, value = mark
            yield Evidence(EvidenceKind(name), start, end, value)
