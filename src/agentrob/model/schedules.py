"""When a command runs: once at a later time, or again and again, in the local time of a zone, also where clocks change.

Pure, but for the time zones of `zoneinfo`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, date, datetime, time, timedelta, tzinfo
from enum import StrEnum
from functools import cache
from itertools import islice
from zoneinfo import ZoneInfo

#: How many days are searched; the weekdays of a schedule come again after a week, and exceptions are few.
_DAYS = 400
_SECOND = timedelta(seconds=1)


@dataclass(frozen=True, slots=True)
class Schedule:
    """The times of a command.

    With `at`, it runs at these local times of the zone `tz`, on the weekdays `days` (0 is Monday; empty means every
    day) except on `except_dates`. With `every_s` it runs at `start_at` and then at this interval of elapsed time. With
    neither it runs once, at `start_at`. It never runs before `start_at`, nor at `until_at` or later, and at most
    `runs_left` times. `start_at` and `until_at` are whole seconds. `limited_runs` and `limited_days`: its author did
    not say how often or until when, so it ends after as many runs or days as any schedule may have.
    """

    start_at: datetime
    until_at: datetime
    tz: str
    runs_left: int
    at: tuple[time, ...] = ()
    days: tuple[int, ...] = ()
    every_s: int = 0
    except_dates: tuple[date, ...] = ()
    limited_runs: bool = False
    limited_days: bool = False


@dataclass(frozen=True, slots=True)
class ScheduledRun:
    """Which run of a schedule a command is: the one of `at`. The schedule was posted, or renewed, at `posted_at`.
    `missed` counts the runs, this one included, that were not begun in time and of which this command tells.

    It is run `number` of `of`, counted from 1; both are 0 if that is not known. `limited`: its author did not say how
    often, so that `of` is the most. `url` is the address of the schedule's post, if it is known.
    """

    at: datetime
    posted_at: datetime
    tz: str
    missed: int = 0
    number: int = 0
    of: int = 0
    limited: bool = False
    url: str = ""


class ScheduleEnd(StrEnum):
    """Why a schedule has no further runs. The values are written to databases."""

    DONE = "done"  # after the last run that its author wanted
    LIMIT = "limit"  # after as many runs or days as any schedule may have
    STOP = "stop"  # its robot was stopped or released after it was posted
    CANCELLED = "cancelled"
    EDITED = "edited"
    REMOVED = "removed"
    RIGHTS = "rights"  # its author may not command the robot any more


@cache
def zone_of(name: str) -> tzinfo:
    """Return a time zone by its IANA name. Raises `ValueError` for an unknown one."""
    if name == "UTC":  # also on a machine without time zones
        return UTC
    try:
        return ZoneInfo(name)
    except (KeyError, ValueError, OSError):
        raise ValueError(f"unknown time zone {name!r}; valid: UTC, or an IANA name such as Europe/Berlin") from None


def next_run(schedule: Schedule, after: datetime) -> datetime | None:
    """Return the first run later than `after`, in UTC; None if there is none. Does not count runs."""
    earliest = max(after + timedelta.resolution, schedule.start_at)
    found = _next(schedule, earliest)
    return found if found is not None and found < schedule.until_at else None


def runs(schedule: Schedule, after: datetime | None = None) -> Iterator[datetime]:
    """Yield the runs later than `after`, at most `runs_left`; by default from the first one."""
    at = after if after is not None else schedule.start_at - _SECOND
    for _ in range(schedule.runs_left):
        following = next_run(schedule, at)
        if following is None:
            return
        yield (at := following)


def first_runs(schedule: Schedule, count: int) -> tuple[datetime, ...]:
    return tuple(islice(runs(schedule), count))


def _next(schedule: Schedule, earliest: datetime) -> datetime | None:
    start = schedule.start_at.astimezone(UTC)
    if schedule.at:
        return _next_local(schedule, earliest)
    if not schedule.every_s:
        return start if start >= earliest else None
    every = timedelta(seconds=schedule.every_s)
    passed = max(timedelta(), earliest - start)
    return start + every * -(-passed // every)


def _next_local(schedule: Schedule, earliest: datetime) -> datetime | None:
    zone = zone_of(schedule.tz)
    day = earliest.astimezone(zone).date() - timedelta(days=1)
    for _ in range(_DAYS):
        if (not schedule.days or day.weekday() in schedule.days) and day not in schedule.except_dates:
            instants = (instant_of(datetime.combine(day, at), zone) for at in schedule.at)
            if found := [at for at in instants if at is not None and at >= earliest]:
                return min(found)
        if datetime.combine(day, time(), UTC) > schedule.until_at + timedelta(days=2):
            return None
        day += timedelta(days=1)
    return None


def instant_of(local: datetime, zone: tzinfo) -> datetime | None:
    """Return when it is this local time, in UTC.

    A time that occurs twice, because clocks are set back, is the first of the two. For one that is skipped, because
    clocks are set forward, it is the first valid moment after it; None if the whole day is skipped.
    """
    found = local.replace(tzinfo=zone, fold=0).astimezone(UTC)
    if found.astimezone(zone).replace(tzinfo=None) == local:
        return found
    before = local.replace(tzinfo=zone, fold=1).astimezone(UTC)  # a skipped time: read with the offset after the change
    low, high = min(before, found), max(before, found)
    offset = high.astimezone(zone).utcoffset()
    while high - low > _SECOND:
        middle = low + (high - low) // 2
        low, high = (low, middle) if middle.astimezone(zone).utcoffset() == offset else (middle, high)
    change = high.replace(microsecond=0)
    return change if change.astimezone(zone).date() == local.date() else None
