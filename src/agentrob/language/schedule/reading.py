"""Split a post into the time at which it is to be carried out and the rest, which is the command.

A time stands at the beginning of a post or at its end. What says when and is not wholly understood is asked about:
nothing is carried out at another time than the one that was meant, and so nothing is carried out at once instead.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cache

from agentrob.language.messages.catalog import say
from agentrob.language.registry import known, language_of, locale
from agentrob.language.schedule.compose import Unclear, compose
from agentrob.language.schedule.parts import Delay, Part, ScheduleWords, Times
from agentrob.language.visible_text import without_mentions
from agentrob.model import Language, Schedule

#: Longer texts are not read as schedules: the grammar reads none of that length either.
MAX_CHARS = 2_000
#: The most parts before a command, and behind it: no schedule has two of a kind.
MOST_PARTS = 6
_ENDS = " \t\r\n,.!?;，。！？；、~"


@dataclass(frozen=True, slots=True)
class TimedText:
    """A post that says when. `rest` is the command without the time. `schedule` is None if the time is not understood;
    then `question` asks for it. Unless the post is `surely_later`, what says when may be a remark ("happy friday")."""

    rest: str
    schedule: Schedule | None = None
    question: str = ""
    surely_later: bool = False


def timed_text(part: str, asked_at: datetime, tz: str) -> TimedText | None:
    """Return when the part of a post for one robot is to be carried out; None if it says nothing about that.

    `asked_at` is when it was posted, `tz` the zone of its local times.
    """
    language = language_of(part)
    words = locale(language).schedule
    if len(part) > MAX_CHARS:
        return None
    parts, rest = _split(part, words)
    if not parts:
        vague = _is_vague(part, words)
        hinted = vague or _compiled(words.hints).search(part)
        return TimedText(part, question=_question(language), surely_later=vague) if hinted else None
    try:
        if _contradicts(rest, parts, words):
            raise Unclear
        if not rest.strip(_ENDS):
            raise Unclear("schedule.what")
        return TimedText(rest.strip(" \t\n,，、"), compose([one for one, _ in parts], asked_at, tz))
    except Unclear as e:
        return TimedText(rest, question=_question(language, e))


def lists_schedules(part: str) -> bool:
    """Return whether a text only asks for the schedules of a robot, in any language."""
    return _is_only(part, "lists")


def cancels_schedule(text: str) -> bool:
    """Return whether a text only cancels ("cancel", 取消日程), in any language, mentions aside."""
    return _is_only(without_mentions(text), "cancels")


def cancels_named_schedule(text: str) -> bool:
    """Return whether a text only cancels and says that it means a schedule ("cancel the schedule", 取消日程)."""
    return _is_only(without_mentions(text), "cancels_by_name")


def cancels_elsewhere(part: str) -> bool:
    """Return whether a text that is not about the schedule of its own thread cancels one ("cancel all schedules",
    "cancel tomorrow's photo"), in any language."""
    named = _is_only(part, "cancels_some") and any(_compiled(of.schedule.hints).search(part) for of in known().values())
    return named or _is_only(part, "cancels_by_name")


def renews_schedule(text: str) -> bool:
    """Return whether a text only renews a schedule ("keep on", 继续), in any language, mentions aside."""
    return _is_only(without_mentions(text), "renews")


def _is_only(text: str, which: str) -> bool:
    plain = " ".join(text.strip(_ENDS).split())
    return any(_compiled(getattr(of.schedule, which)).fullmatch(plain) for of in known().values())


def _question(language: Language, unclear: Unclear | None = None) -> str:
    problem = unclear or Unclear()
    return f"{say(problem.key, language, **problem.values)} {say('schedule.examples', language)}"


Placed = tuple[Part, bool]  # a part, and whether it stands behind the command


def _split(text: str, words: ScheduleWords) -> tuple[list[Placed], str]:
    """Return the parts at the beginning and at the end of a text, and what is left."""
    found: list[Placed] = []
    rest, first = text, True
    while len(found) < MOST_PARTS and (leading := _leading(rest, words, first)) is not None:
        part, end = leading
        if isinstance(part, Times) and not part.apart_s and first:
            break  # "three times wave" is no time
        found.append((part, False))
        rest, first = rest[end:], False
    behind: list[tuple[Part, str]] = []  # each with the text before it was taken off
    while len(behind) < MOST_PARTS and (trailing := _trailing(rest, words)) is not None:
        part, start = trailing
        behind.insert(0, (part, rest))
        rest = rest[:start]
    if behind and isinstance(count := behind[0][0], Times) and not count.apart_s and not count.total:
        rest = behind.pop(0)[1]  # "wave three times" says how often to wave
    return found + [(part, True) for part, _ in behind], rest


def _leading(text: str, words: ScheduleWords, first: bool) -> tuple[Part, int] | None:
    skipped = _compiled(words.begin if first else words.joint).match(text)
    at = skipped.end() if skipped else 0
    found = [(form, match) for form in words.forms if (match := form.pattern.match(text, at))]
    for form, match in sorted(found, key=lambda one: -one[1].end()):
        part = form.read(match)
        if part is not None and _ends_word(text, match.end()):
            return part, match.end()
    return None


def _ends_word(text: str, at: int) -> bool:
    return at >= len(text) or not (text[at].isascii() and text[at].isalnum() and text[at - 1].isascii())


def _trailing(text: str, words: ScheduleWords) -> tuple[Part, int] | None:
    end = len(text.rstrip(_ENDS))
    found = [
        (form, match)
        for form in words.forms
        if not form.leads
        for match in form.pattern.finditer(text, 0, end)
        if match.end() == end
    ]
    for form, match in sorted(found, key=lambda one: one[1].start()):
        part = form.read(match)
        if part is not None:
            return part, len(re.sub(rf"{words.joint}$", "", text[: match.start()]))
    return None


def _is_vague(text: str, words: ScheduleWords) -> bool:
    """Whether a text begins or ends with a delay that names no number."""
    plain = text.strip(_ENDS)
    begins = re.compile(f"(?:{words.begin})(?:{words.vague})", re.IGNORECASE).match(plain)
    return bool(begins or re.compile(f"(?:{words.vague})$", re.IGNORECASE).search(plain))


def _contradicts(rest: str, parts: Sequence[Placed], words: ScheduleWords) -> bool:
    """Return whether the command says when, too, or changes the time beside it, or it is open how much of it a time
    behind it is for."""
    if _compiled(words.hints).search(rest) or _compiled(words.present).search(rest):
        return True
    behind = [part for part, is_behind in parts if is_behind]
    if len(behind) < len(parts) and _compiled(words.qualifies_after).match(rest.lstrip(_ENDS)):
        return True
    if not behind:
        return False
    if _compiled(words.qualifies_before).search(rest.rstrip(_ENDS)):
        return True
    if any(isinstance(part, Delay) for part in behind) and _compiled(words.amount).search(rest):
        return True
    return len(behind) == len(parts) and bool(_compiled(words.breaks).search(rest.strip(_ENDS)))


@cache
def _compiled(pattern: str) -> re.Pattern[str]:
    return re.compile(pattern, re.IGNORECASE)
