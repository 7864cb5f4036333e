"""Read a post to several robots in which one waits for another: which robot does what, and after which parts (pure).

    @quadruped walk 1 m, then @humanoid wave        等@quadruped走完，再让@humanoid挥手
    @a walk 1 m. Meanwhile @b turn left. Then both of you wave.      @a @b one of you take a photo

Every agent reads the same text by the same words, whatever its mind, its robot and what was done before, so that all
agree on the parts. If anything is uncertain, they ask about it and nobody moves (law 18).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from datetime import UTC, datetime
from functools import cache, lru_cache

from agentrob.language.joint.parts import (
    LEAST_PARTS,
    MOST_DEEP,
    MOST_PARTS,
    Choice,
    JointCommand,
    JointPart,
    JointWords,
    cycle_of,
    depth_of,
    ordered,
)
from agentrob.language.messages.catalog import quote, say
from agentrob.language.parser.grammar import MAX_CHARS, parse, small_talk_of
from agentrob.language.parser.small_talk import SmallTalk
from agentrob.language.previews.reading import speaks_of_preview
from agentrob.language.registry import known, language_of
from agentrob.language.schedule.reading import timed_text
from agentrob.language.visible_text import mention_spans, without_mentions
from agentrob.model import Intent, Language, Op, Plan

#: A mention while the text is read: one character of the private use area for each robot.
_FIRST_MARK, _MOST_ROBOTS = 0xE000, 256
_ROBOT = "[\ue000-\ue0ff]"
_STRONG, _WEAK = ".!?;\n。！？；", ",:，：、"
_BETWEEN = r"[\s,，、:：]"
#: Words of how many robots are meant: "both of you" of three is not clear.
_TWO = re.compile(r"both|two|俩|两|二", re.IGNORECASE)
_WAITS = ("it", "all", "robot", "then")
#: Only whether a part says when matters, not when that is.
_ANY_DAY = datetime(2000, 1, 1, tzinfo=UTC)


@dataclass(frozen=True, slots=True)
class JointProblem:
    """Why a post in which robots wait for each other is not understood, as a question in `language`, and a sentence
    with a post that is. Both quote people's words as code only; the example mentions the robots of the post."""

    question: str
    example: str
    language: Language


class _Unclear(Exception):
    """Raised with the sentence that asks, and its values."""

    def __init__(self, key: str, **values: object) -> None:
        super().__init__(key)
        self.key, self.values = key, values


@dataclass
class _Unit:
    """A unit of the text that addresses one robot or several. `kinds` are the words that say when it begins, by their
    names in `_Patterns`; `waits_for` are robots that are named in them."""

    robots: list[str]
    choice: Choice
    text: str
    kinds: list[str]
    waits_for: list[str]
    near: str = ""
    numbers: list[int] = field(default_factory=list)

    @property
    def after_others(self) -> bool:
        return any(kind in _WAITS for kind in self.kinds)


@lru_cache(maxsize=64)
def joint_command(visible: str) -> JointCommand | JointProblem | None:
    """Read the visible text of a post (law 3). None if none of its robots waits for another and none is chosen: then
    each does its own part at once."""
    handles = list(dict.fromkeys(name for name, _, _ in mention_spans(visible)))
    if not 2 <= len(handles) <= _MOST_ROBOTS or len(visible) > MAX_CHARS or re.search(_ROBOT, visible):
        return None
    language = language_of(without_mentions(visible))
    try:
        units = _units(_marked(visible, handles), handles)
        return JointCommand(_parts(units), language) if units else None
    except _Unclear as e:
        first, second = handles[:2]
        example = say("joint.example", language, first=first, second=second)
        return JointProblem(say(e.key, language, **e.values), example, language)


def _marked(visible: str, handles: Sequence[str]) -> str:
    """The text with one character for each mention."""
    text, at = [], 0
    for name, start, end in mention_spans(visible):
        text += [visible[at:start], chr(_FIRST_MARK + handles.index(name))]
        at = end
    text.append(visible[at:])
    return "".join(text).replace("’", "'")


# -------------------------------------------------------------------- from text to units
def _units(text: str, handles: Sequence[str]) -> list[_Unit]:
    """The units of a text in order; empty if no robot waits for another and none is chosen. Raises `_Unclear`."""
    words = _patterns()
    heads = [head for head in words.head.finditer(text) if head["start"] is not None or head["lead"]]
    found: list[tuple[_Unit, re.Match[str], list[tuple[str, str]], bool]] = []
    for at, head in enumerate(heads):
        until = heads[at + 1].start() if at + 1 < len(heads) else len(text)
        body = text[head.end() : until]
        strong = at + 1 == len(heads) or (heads[at + 1]["start"] or ",") in _STRONG or body.rstrip()[-1:] in _STRONG
        body = body.strip(_STRONG + _WEAK + " \t\r~")
        leads, tail = words.kinds(f"{head['lead']} {head['late']}"), []
        if (tailed := words.tail.search(body)) is not None:
            body, tail = body[: tailed.start()].strip(_STRONG + _WEAK + " \t\r"), words.kinds(tailed[0])
        robots, choice = _addressed(head["who"], handles, words)
        waits = [handles[ord(mark) - _FIRST_MARK] for _, said in (*leads, *tail) for mark in re.findall(_ROBOT, said)]
        kinds = [kind for kind, _ in (*leads, *tail) if kind != "lead"]
        unit = _Unit(robots, choice, body, kinds, waits, words.near(head["who"]) if choice is Choice.NEAREST else "")
        found.append((unit, head, tail, strong))
    units = [unit for unit, *_ in found]
    chosen = any(unit.choice is not Choice.NAMED for unit in units)
    if not chosen and not any(kind != "first" for unit in units for kind in unit.kinds):
        return []
    if speaks_of_preview(text, text):
        raise _Unclear("joint.preview")
    if not words.greets.fullmatch(text[: heads[0].start()]) or any(re.search(_ROBOT, unit.text) for unit in units):
        raise _Unclear("joint.unclear")
    for at, (unit, head, tail, strong) in enumerate(found):
        following = units[at + 1] if at + 1 < len(units) else None
        _check_ends(unit, tail, strong, following)
        _check_lead(units[:at], unit, head, words)
    return units


def _check_ends(unit: _Unit, tail: Sequence[tuple[str, str]], strong: bool, following: _Unit | None) -> None:
    """Raise `_Unclear` if the words behind a part may belong to the next one: "@b wave, when @a is done, @c sit"."""
    if "first" in unit.kinds and (following is None or not following.after_others):
        raise _Unclear("joint.unclear")
    waits = any(kind in _WAITS for kind, _ in tail)
    if waits and not strong and following is not None and not following.kinds:
        raise _Unclear("joint.unclear")


def _check_lead(before: Sequence[_Unit], unit: _Unit, head: re.Match[str], words: _Patterns) -> None:
    """Raise `_Unclear` if the words before a part may belong to the one before it: "wave to her and @b then sit"."""
    leads = words.kinds(head["lead"])
    joined = before and head["start"] is None and all(kind == "lead" for kind, _ in leads)
    if joined and any(kind in _WAITS for kind, _ in words.kinds(head["late"])):
        raise _Unclear("joint.unclear")
    if not before or not leads or (head["start"] or ",") in _STRONG:
        return
    kind, said = leads[0]
    if kind == "robot" and (before[-1].choice is not Choice.NAMED or unit.waits_for[:1] != before[-1].robots):
        raise _Unclear("joint.unclear")
    if kind in ("it", "all") and said.isascii() and len(before) > 1:
        raise _Unclear("joint.unclear")


def _addressed(who: str, handles: Sequence[str], words: _Patterns) -> tuple[list[str], Choice]:
    """The robots that are addressed, and how one of them is chosen."""
    named = list(dict.fromkeys(handles[ord(mark) - _FIRST_MARK] for mark in re.findall(_ROBOT, who)))
    choice = words.choice(who)
    plain = re.sub(_ROBOT, "", who).strip()
    robots = named or list(handles)
    if choice is not Choice.NAMED and len(robots) < LEAST_PARTS:
        raise _Unclear("joint.who", words=quote(plain))
    if not named and _TWO.search(plain) and len(robots) != 2:
        raise _Unclear("joint.who", words=quote(plain))
    return robots, choice


# -------------------------------------------------------------------- from units to parts
def _parts(units: Sequence[_Unit]) -> tuple[JointPart, ...]:
    """The parts of all units. Raises `_Unclear`."""
    number = 0
    for unit in units:
        count = len(unit.robots) if unit.choice is Choice.NAMED else 1
        unit.numbers = list(range(number + 1, number + count + 1))
        number += count
    named = [[n for name in unit.waits_for for n in _parts_of(name, at, units)] for at, unit in enumerate(units)]
    if number > MOST_PARTS:
        raise _Unclear("joint.count", count=number, most=MOST_PARTS)
    if number < LEAST_PARTS and units[0].choice is Choice.NAMED:
        raise _Unclear("joint.unclear")
    after: dict[int, tuple[int, ...]] = {}
    parts: list[JointPart] = []
    for at, unit in enumerate(units):
        waits = tuple(sorted({*named[at], *_after(at, units, after)}))
        plan = _plan(unit)
        for place, n in enumerate(unit.numbers):
            robots = (unit.robots[place],) if unit.choice is Choice.NAMED else tuple(unit.robots)
            after[n] = waits
            parts.append(JointPart(n, robots, plan, unit.text, waits, unit.choice, unit.near))
    _check(parts)
    return tuple(parts)


def _parts_of(name: str, at: int, units: Sequence[_Unit]) -> list[int]:
    """The part of a robot for which the unit `at` waits: the last one before it, or the only one behind it."""
    there = [(j, unit.numbers[unit.robots.index(name)]) for j, unit in enumerate(units)
             if name in unit.robots and unit.choice is Choice.NAMED]  # fmt: skip
    before, behind = [n for j, n in there if j < at], [n for j, n in there if j > at]
    if before or len(behind) == 1:
        return [before[-1] if before else behind[0]]
    if any(j == at for j, _ in there):
        return [n for j, n in there if j == at]  # it waits for itself: a cycle
    if behind or any(name in unit.robots for unit in units):
        raise _Unclear("joint.unclear")
    raise _Unclear("joint.nothing", robot=quote(name))


def _after(at: int, units: Sequence[_Unit], after: dict[int, tuple[int, ...]]) -> tuple[int, ...]:
    """The parts for which a unit waits that it does not name."""
    unit, before = units[at], units[:at]
    kinds = {kind for kind in unit.kinds if kind not in ("first", "robot")}
    if "meanwhile" in unit.kinds:
        if unit.after_others:
            raise _Unclear("joint.when", robot=_names(unit))
        return after[before[-1].numbers[0]] if before else ()
    if not kinds:
        if "robot" not in unit.kinds and any(kind in ("then", "it", "all") for u in before for kind in u.kinds):
            raise _Unclear("joint.when", robot=_names(unit))
        return ()
    if not before:
        raise _Unclear("joint.unclear")
    waited_for = {n for waits in after.values() for n in waits}
    last = tuple(n for n in after if n not in waited_for)
    if ("it" in kinds and (len(last) != 1 or list(last) != before[-1].numbers)) or ("all" in kinds and len(last) < 2):
        raise _Unclear("joint.when", robot=_names(unit))
    return last


def _plan(unit: _Unit) -> Plan:
    """The plan of a part, by the rules and without anything that another robot may not know. Raises `_Unclear`."""
    text = unit.text
    timed = timed_text(text, _ANY_DAY, "UTC") if text else None
    if timed is not None and (timed.schedule is not None or timed.surely_later):
        raise _Unclear("joint.later")
    understood = parse(text, (), (), frozenset(Op)) if text else None
    if understood is None or understood.intent is not Intent.COMMAND or small_talk_of(text, (), ()) is SmallTalk.CANCEL:
        raise _Unclear("joint.part", robot=_names(unit), words=quote(text or "…"))
    return understood.plan


def _check(parts: Sequence[JointPart]) -> None:
    """Raise `_Unclear` for parts that wait in a circle, follow one another too deep, or whose order is not known."""
    language = language_of(" ".join(part.text for part in parts))
    if cycle := cycle_of(parts):
        named = [say("joint.cycle.part", language, robot=_name(part), words=quote(part.text)) for part in cycle]
        raise _Unclear("joint.cycle", parts=" → ".join([*named, named[0]]))
    if (deep := depth_of(parts)) > MOST_DEEP:
        raise _Unclear("joint.deep", count=deep, most=MOST_DEEP)
    for part in parts:
        for other in parts[: part.number - 1]:
            both = [name for name in part.robots if name in other.robots]
            n, m = part.number, other.number
            if both and not (ordered(parts, m, n) or ordered(parts, n, m)):
                raise _Unclear("joint.same", robot=quote(both[0]))


def _names(unit: _Unit) -> str:
    return ", ".join(quote(name) for name in unit.robots)


def _name(part: JointPart) -> str:
    return ", ".join(quote(name) for name in part.robots)


# -------------------------------------------------------------------- words
class _Patterns:
    """The words of all languages. `head` matches what begins a part, with who is addressed; `tail` what may end it."""

    def __init__(self) -> None:
        words = _all_words()
        conditions = {"it": words.ended_it, "all": words.ended_all, "robot": words.ended_robot,
                      "meanwhile": words.meanwhile, "then": words.then}  # fmt: skip
        waits = "|".join(f"(?:{pattern})" for pattern in conditions.values())
        waits_named = "|".join(f"(?:{pattern})" for kind, pattern in conditions.items() if kind != "then")
        everyone = (w for t in known().values() for w in t.together.replace("\n", "").split("|") if w)
        together = "|".join(sorted(everyone, key=len, reverse=True))
        choices = {Choice.NEAREST: words.nearest, Choice.FREE: words.free, Choice.ANY: words.any_of}
        joint = rf"\s*(?:(?:[,，、&+/]|{_word('and|和|与|跟|还有')}|{_word(words.either)})\s*)*"
        group = rf"R(?:{joint}R)*"
        choosing = _word("|".join(f"(?:{pattern})" for pattern in choices.values()) + f"|{together}")
        who = rf"(?:{group}(?:{_BETWEEN}*{choosing})?|{choosing}(?:[,，:：\s]+{group})?)"
        lead = rf"(?:{_word(f'{waits}|(?:{words.leads})')}{_BETWEEN}*)"
        # "@b then wave", but not "and @b, then …"
        linking = _word(f"(?:{words.then})|(?:{words.first})|(?:{words.linking})")
        late = rf"(?:{_BETWEEN}*{_word(waits_named)}|[\s:：]*{linking})"
        start = rf"^|[{re.escape(_STRONG + _WEAK)}]"
        self.head = _compiled(rf"(?P<start>{start})?\s*(?P<lead>{lead}{{0,5}})(?P<who>{who})(?P<late>{late}{{0,4}})")
        self.tail = _compiled(rf"{_BETWEEN}*{_word(f'{waits}|(?:{words.first})')}\s*$")
        self.greets = _compiled(rf"(?:{_word(words.greets)}|[\s{re.escape(_STRONG + _WEAK)}])*")
        self._either = _compiled(rf"R\s*(?:[,，、]\s*)?{_word(words.either)}\s*R")
        self._choices = {choice: _compiled(_word(pattern)) for choice, pattern in choices.items()}
        self._near = [re.compile(language.joint.near, re.IGNORECASE) for language in known().values()]
        kinds = {**conditions, "first": words.first, "lead": f"(?:{words.leads})|(?:{words.linking})"}
        self._kinds = _compiled("|".join(f"(?P<{kind}>{_word(pattern)})" for kind, pattern in kinds.items()))

    def kinds(self, said: str) -> list[tuple[str, str]]:
        """Find the words that say when a part begins: (kind, words), in their order."""
        return [(str(found.lastgroup), found[0]) for found in self._kinds.finditer(said)]

    def near(self, who: str) -> str:
        """To what the nearest robot is addressed; empty if that is not said."""
        found = (pattern.search(who) for pattern in self._near)
        return next((match["place"].strip() for match in found if match), "")

    def choice(self, who: str) -> Choice:
        """How one of the robots addressed is chosen."""
        found = (choice for choice, pattern in self._choices.items() if pattern.search(who))
        return next(found, Choice.ANY if self._either.search(who) else Choice.NAMED)


@cache
def _patterns() -> _Patterns:
    return _Patterns()


def _all_words() -> JointWords:
    """The words of all languages together: a post may mix them."""
    every = [t.joint for t in known().values()]
    return JointWords(**{f.name: "|".join(getattr(words, f.name) for words in every) for f in fields(JointWords)})


def _word(pattern: str) -> str:
    """Match whole words only, where they are of Latin letters."""
    return rf"(?<![A-Za-z])(?:{pattern})(?![A-Za-z])"


def _compiled(pattern: str) -> re.Pattern[str]:
    """Compile a pattern in which `R` stands for one robot."""
    return re.compile(re.sub(r"(?<![A-Za-z\\])R(?![A-Za-z])", _ROBOT, pattern), re.IGNORECASE)
