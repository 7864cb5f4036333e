"""The parts of a time in words, and what a language provides to read them."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date


def hour_within(hour: int, hours: range, *, exact: bool) -> int | None:
    """Return the hour from 0 to 23 that is meant in a part of the day; None if there are none or two. Unless it is
    `exact`, it may also be meant twelve hours earlier or later."""
    meant = [one for one in {hour, *(() if exact else (hour % 12, hour % 12 + 12))} if one in hours]
    return meant[0] if len(meant) == 1 else None


@dataclass(frozen=True, slots=True)
class Clock:
    """A time of day. `sure`: it is hardly meant twelve hours later; `exact`: it cannot be. `bare`: a number alone,
    which is a time only beside a day. `midnight`: it may be that at the beginning of a day or at its end."""

    hour: int
    minute: int = 0
    sure: bool = True
    exact: bool = False
    bare: bool = False
    midnight: bool = False


@dataclass(frozen=True, slots=True)
class Delay:
    """ "In 10 minutes"."""

    seconds: int


@dataclass(frozen=True, slots=True)
class Day:
    """One day: `ahead` days from today, the next `weekday` (of the next week, with `next_week`), or a date. `month_day`
    is a date without a year. `hours` are those of the part of the day that it names ("tonight"); empty if it names
    none."""

    ahead: int | None = None
    weekday: int | None = None
    next_week: bool = False
    date: date | None = None
    month_day: tuple[int, int] | None = None
    hours: range = range(0)


@dataclass(frozen=True, slots=True)
class At:
    """ "At 9 and 17:00"."""

    clocks: tuple[Clock, ...]


@dataclass(frozen=True, slots=True)
class Weekly:
    """ "Every weekday": the days on which it runs, all of them if empty. `hours` are those of the part of the day that
    it names ("every morning"); empty if it names none."""

    days: tuple[int, ...]
    hours: range = range(0)


@dataclass(frozen=True, slots=True)
class Every:
    """ "Every 15 minutes"."""

    seconds: int


@dataclass(frozen=True, slots=True)
class Between:
    """ "Between 9 and 17"."""

    start: Clock
    end: Clock


@dataclass(frozen=True, slots=True)
class Until:
    """ "Until Friday": that whole day, or a time of today."""

    end: Day | Clock


@dataclass(frozen=True, slots=True)
class Times:
    """ "Three times, an hour apart", or behind an interval "three times". `apart_s` is 0 where an interval says it.
    `total`: it cannot be how often each run does something ("three times in all")."""

    count: int
    apart_s: int = 0
    total: bool = False


@dataclass(frozen=True, slots=True)
class Except:
    """ "Except on Fridays", "except on 24 December"."""

    days: tuple[int, ...] = ()
    day: Day | None = None


Part = Delay | Day | At | Weekly | Every | Between | Until | Times | Except


@dataclass(frozen=True, slots=True)
class Form:
    """One way to say a part. `read` returns the part of a match, None if the words are none after all. `leads`: only at
    the beginning of a post, since behind a command the words belong to that."""

    pattern: re.Pattern[str]
    read: Callable[[re.Match[str]], Part | None]
    leads: bool = False


@dataclass(frozen=True)
class ScheduleWords:
    """How one language speaks of times.

    `joint` matches what may stand between two parts, and `begin` what may also stand before the first one. `hints`
    matches words that say when, wherever they stand: if they are not understood as a part, the post is asked back.
    `vague` matches a delay without a number, which at the beginning or the end of a post is never a remark.
    `qualifies_before` and `qualifies_after` match words that change the time directly behind or before them ("not
    before 9", "9 London time"), at the end or the beginning of what is left: then the time is another one.
    `present` matches words of the present, which contradict a later time. `breaks` matches what separates the clauses
    of a command, `amount` what a duration behind a command may belong to ("walk 2 m in 10 minutes"). `lists` matches
    a post that asks for the schedules, `cancels` one that cancels them, `cancels_by_name` one that also says that it
    means a schedule, `cancels_some` one that cancels what it names, `renews` one that renews a schedule whose last run
    was.
    """

    forms: tuple[Form, ...] = ()
    joint: str = r"[\s,]*"
    begin: str = r"[\s,]*"
    hints: str = "(?!)"
    vague: str = "(?!)"
    qualifies_before: str = "(?!)"
    qualifies_after: str = "(?!)"
    present: str = "(?!)"
    breaks: str = "(?!)"
    amount: str = "(?!)"
    lists: str = "(?!)"
    cancels: str = "(?!)"
    cancels_by_name: str = "(?!)"
    cancels_some: str = "(?!)"
    renews: str = "(?!)"
