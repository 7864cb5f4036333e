"""When a command runs: once at a later time, or again and again, in the local time of one zone."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import date, datetime, time
from enum import StrEnum


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
    """Which run of a schedule a command is: the one of `at`. The schedule was posted at `posted_at`. `missed` counts
    the runs, this one included, that were not begun in time and of which this command tells."""

    at: datetime
    posted_at: datetime
    tz: str
    missed: int = 0


class ScheduleEnd(StrEnum):
    """Why a schedule has no further runs. The values are written to databases."""

    DONE = "done"  # after the last run that its author wanted
    LIMIT = "limit"  # after as many runs or days as any schedule may have
    STOP = "stop"  # its robot was stopped or released after it was posted
    CANCELLED = "cancelled"
    EDITED = "edited"
    REMOVED = "removed"
    RIGHTS = "rights"  # its author may not command the robot any more
