"""From the parts of a time in words to a schedule, or to the question about what is unclear."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, date, datetime, time, timedelta, tzinfo
from typing import TypeVar

from agentrob.language.schedule.parts import (
    At,
    Between,
    Clock,
    Day,
    Delay,
    Every,
    Except,
    Part,
    Times,
    Until,
    Weekly,
    hour_within,
)
from agentrob.model import Schedule
from agentrob.model.schedules import first_runs, instant_of, zone_of

#: A schedule ends after this many runs or days, and two of its runs are at least this far apart.
MAX_RUNS, MAX_DAYS, MIN_EVERY_S = 30, 60, 300
P = TypeVar("P")


class Unclear(Exception):
    """Raised with the key of the question (`schedule.…`) and its values."""

    def __init__(self, key: str = "schedule.unclear", **values: object) -> None:
        super().__init__(key)
        self.key, self.values = key, values


def compose(parts: Sequence[Part], asked_at: datetime, tz: str) -> Schedule:
    """Return the schedule that these parts are together. Raises `Unclear`."""
    return _Composer(parts, asked_at, tz).schedule()


class _Composer:
    def __init__(self, parts: Sequence[Part], asked_at: datetime, tz: str) -> None:
        self._parts, self._tz, self._zone = parts, tz, zone_of(tz)
        whole = asked_at.astimezone(UTC)
        self._asked_at = whole.replace(microsecond=0) + timedelta(seconds=1 if whole.microsecond else 0)
        self._today = self._asked_at.astimezone(self._zone).date()
        self._latest = self._asked_at + timedelta(days=MAX_DAYS)
        self._kinds = {type(part) for part in parts}
        if len(self._kinds) != len(parts):
            raise Unclear

    def _one(self, kind: type[P]) -> P | None:
        return next((part for part in self._parts if isinstance(part, kind)), None)

    def schedule(self) -> Schedule:
        kinds, found = self._kinds, None
        if kinds == {Delay}:
            found = self._once_after()
        elif kinds <= {Day, At}:
            found = self._on_one_day()
        elif Times in kinds and kinds <= {Times, Day, At, Delay} and self._apart_s:
            found = self._times_apart()
        elif Weekly in kinds and kinds <= {Weekly, At, Until, Except, Times}:
            found = self._weekly()
        elif Every in kinds and kinds <= {Every, Between, Weekly, Until, Except, Times}:
            found = self._every()
        if found is None or (self._apart_s and (Every in kinds or Weekly in kinds)):
            raise Unclear
        return self._checked(found)

    def _checked(self, schedule: Schedule) -> Schedule:
        if not first_runs(schedule, 1):
            raise Unclear("schedule.none")
        return schedule

    # ---------------------------------------------------------------- forms
    def _once_after(self) -> Schedule:
        delay = self._one(Delay)
        assert delay is not None
        if delay.seconds <= 0:
            raise Unclear
        return self._made(self._asked_at + timedelta(seconds=delay.seconds), runs=1)

    def _on_one_day(self) -> Schedule:
        day, at = self._one(Day), self._one(At)
        if at is None:
            raise Unclear("schedule.hour")
        if any(clock.midnight for clock in at.clocks):
            raise Unclear("schedule.midnight")
        clocks = tuple(sorted({self._time(clock, day) for clock in at.clocks}))
        on = self._date(day, clocks[0]) if day is not None else self._today
        start = max(self._asked_at, self._begin(on))
        found = self._made(start, until_at=self._begin(on + timedelta(days=1)), runs=len(clocks), at=clocks)
        if len(first_runs(found, len(clocks))) < len(clocks):
            raise Unclear("schedule.past", time=f"{clocks[0]:%H:%M}")
        return found

    def _times_apart(self) -> Schedule:
        times = self._one(Times)
        assert times is not None
        if self._kinds == {Times}:
            start = self._asked_at
        elif Delay in self._kinds and len(self._kinds) == 2:
            start = self._once_after().start_at
        else:
            once = _Composer([p for p in self._parts if not isinstance(p, Times)], self._asked_at, self._tz).schedule()
            if once.runs_left != 1:
                raise Unclear
            (start,) = first_runs(once, 1)
        return self._made(start, every_s=self._often_enough(times.apart_s), runs=self._count(times))

    def _weekly(self) -> Schedule:
        weekly, at = self._one(Weekly), self._one(At)
        assert weekly is not None
        if at is None:
            raise Unclear("schedule.hour")
        clocks = tuple(sorted({self._time(clock, weekly) for clock in at.clocks}))
        return self._recurring(weekly.days, clocks)

    def _every(self) -> Schedule:
        every, between, weekly = self._one(Every), self._one(Between), self._one(Weekly)
        assert every is not None
        every_s = self._often_enough(every.seconds)
        if between is not None:
            return self._recurring(weekly.days if weekly else (), self._within(between, every_s))
        if weekly is not None or Except in self._kinds:
            raise Unclear("schedule.between")
        until = self._until()
        start = self._asked_at + timedelta(seconds=every_s)
        times = self._one(Times)
        runs = self._count(times) if times else MAX_RUNS
        return self._made(start, until, runs, every_s=every_s, limited_runs=not times, limited_days=until is None)

    def _within(self, between: Between, every_s: int) -> tuple[time, ...]:
        start, end = (self._time(clock, between) for clock in (between.start, between.end))
        minutes, last = start.hour * 60 + start.minute, end.hour * 60 + end.minute
        if last <= minutes or every_s % 60:
            raise Unclear("schedule.between")
        return tuple(time(*divmod(minute, 60)) for minute in range(minutes, last + 1, every_s // 60))

    def _recurring(self, days: tuple[int, ...], at: tuple[time, ...]) -> Schedule:
        left_out, times, until = self._one(Except), self._one(Times), self._until()
        dates: tuple[date, ...] = ()
        if left_out is not None and left_out.day is not None:
            dates = (self._date(left_out.day),)
        elif left_out is not None:
            days = tuple(day for day in days or range(7) if day not in left_out.days)
            if not days:
                raise Unclear("schedule.none")
        runs = self._count(times) if times else MAX_RUNS
        return self._made(
            self._asked_at, until, runs, at=at, days=days, except_dates=dates, limited_runs=not times,
            limited_days=until is None,
        )  # fmt: skip

    # ---------------------------------------------------------------- parts
    @property
    def _apart_s(self) -> int:
        times = self._one(Times)
        return times.apart_s if times is not None else 0

    def _made(self, start_at: datetime, until_at: datetime | None = None, runs: int = 1, **more: object) -> Schedule:
        if start_at > self._latest:
            raise Unclear("schedule.far", days=MAX_DAYS)
        once = start_at + timedelta(seconds=1) if runs == 1 and not more else None
        return Schedule(start_at, until_at or once or self._latest, self._tz, runs, **more)  # type: ignore[arg-type]

    def _count(self, times: Times) -> int:
        if not 1 <= times.count <= MAX_RUNS:
            raise Unclear("schedule.runs", count=MAX_RUNS)
        return times.count

    def _often_enough(self, seconds: int) -> int:
        if seconds < MIN_EVERY_S:
            raise Unclear("schedule.often", minutes=MIN_EVERY_S // 60)
        return seconds

    def _time(self, clock: Clock, beside: object) -> time:
        hour, sure = clock.hour, clock.sure
        if isinstance(beside, Day | Weekly) and beside.hours:
            within = hour_within(clock.hour, beside.hours, exact=clock.exact)
            if within is None:
                raise Unclear
            hour, sure = within, True
        if clock.bare and beside is None:
            raise Unclear("schedule.day", hour=f"{clock.hour}:00")
        if not sure:
            raise Unclear("schedule.half", early=f"{hour}:{clock.minute:02}", late=f"{hour + 12}:{clock.minute:02}")
        return time(hour, clock.minute)

    def _until(self) -> datetime | None:
        until = self._one(Until)
        if until is None:
            return None
        if isinstance(until.end, Day):
            end = self._begin(self._date(until.end) + timedelta(days=1))
            if end > self._latest + timedelta(days=1):
                raise Unclear("schedule.far", days=MAX_DAYS)
            return min(end, self._latest)
        if Weekly in self._kinds:
            raise Unclear
        at = instant_of(datetime.combine(self._today, self._time(until.end, until)), self._zone)
        if at is None or at <= self._asked_at:
            raise Unclear("schedule.past", time=f"{until.end.hour:02}:{until.end.minute:02}")
        return at + timedelta(seconds=1)

    def _date(self, day: Day, first: time | None = None) -> date:
        """Return the date of a day. A weekday is today only if the time `first` is still to come."""
        try:
            found = self._date_of(day, first)
        except ValueError:
            raise Unclear from None
        if found < self._today:
            raise Unclear("schedule.past", time=found.isoformat())
        return found

    def _date_of(self, day: Day, first: time | None) -> date:
        if day.date is not None:
            return day.date
        if day.month_day is not None:
            this_year = date(self._today.year, *day.month_day)
            return this_year if this_year >= self._today else date(self._today.year + 1, *day.month_day)
        if day.weekday is None:
            return self._today + timedelta(days=day.ahead or 0)
        if day.next_week:
            return self._today + timedelta(days=7 - self._today.weekday() + day.weekday)
        ahead = (day.weekday - self._today.weekday()) % 7
        if ahead == 0 and first is not None:
            at = instant_of(datetime.combine(self._today, first), self._zone)
            ahead = 7 if at is None or at <= self._asked_at else 0
        return self._today + timedelta(days=ahead)

    def _begin(self, day: date) -> datetime:
        """Return when a day begins, which is not midnight where clocks change then."""
        return instant_of(datetime.combine(day, time()), self._zone) or _noon(day, self._zone)


def _noon(day: date, zone: tzinfo) -> datetime:
    return datetime.combine(day, time(12), zone).astimezone(UTC)
