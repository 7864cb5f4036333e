"""Next runs, compared with cronsim where clocks change."""

from __future__ import annotations

from datetime import UTC, date, datetime, time, timedelta
from itertools import islice
from zoneinfo import ZoneInfo

import pytest
from cronsim import CronSim
from hypothesis import given, settings
from hypothesis import strategies as st

from agentrob.model import Schedule
from agentrob.model.schedules import first_runs, next_run, runs, zone_of

#: Zones with changes of an hour and of half an hour, at midnight, in the south, and without changes.
ZONES = (
    "Europe/Berlin", "America/New_York", "Australia/Lord_Howe", "America/Santiago", "Africa/Cairo", "America/Havana",
    "Asia/Beirut", "Africa/Casablanca", "Asia/Shanghai", "UTC",
)  # fmt: skip
BEGIN, END = datetime(2025, 1, 1, tzinfo=UTC), datetime(2027, 1, 1, tzinfo=UTC)


def schedule(tz: str = "UTC", start_at: datetime = BEGIN, until_at: datetime = END, **more: object) -> Schedule:
    return Schedule(start_at, until_at, tz, runs_left=10**6, **more)  # type: ignore[arg-type]


def changes(tz: str) -> list[datetime]:
    """Return the days of two years around which the zone's offset from UTC changes."""
    days = [BEGIN + timedelta(days=n) for n in range(729)]
    zone = zone_of(tz)
    return [a for a in days if a.astimezone(zone).utcoffset() != (a + timedelta(days=1)).astimezone(zone).utcoffset()]


def by_cronsim(at: time, days: tuple[int, ...], tz: str, after: datetime, count: int) -> list[datetime]:
    weekdays = ",".join(str((day + 1) % 7) for day in days) or "*"
    found = CronSim(f"{at.minute} {at.hour} * * {weekdays}", after.astimezone(ZoneInfo(tz)))
    return [run.astimezone(UTC) for run in islice(found, count)]


def test_the_zones_change_their_clocks() -> None:
    assert sum(len(changes(tz)) for tz in ZONES) >= 25


@pytest.mark.parametrize("tz", ZONES)
def test_every_minute_of_the_day_at_each_clock_change_as_cronsim_says(tz: str) -> None:
    for day in changes(tz):
        for minute in range(0, 24 * 60, 10):
            at = time(*divmod(minute, 60))
            begin = day - timedelta(days=1)
            ours = list(islice(runs(schedule(tz, at=(at,)), begin), 4))
            assert ours == by_cronsim(at, (), tz, begin, 4), f"{at} around {day} in {tz}"


@settings(max_examples=150, deadline=None)
@given(
    st.sampled_from(ZONES),
    st.times().map(lambda at: at.replace(second=0, microsecond=0)),
    st.sets(st.integers(0, 6)).map(lambda days: tuple(sorted(days))),
    st.datetimes(datetime(2025, 1, 1), datetime(2026, 11, 1), timezones=st.just(UTC)),
)
def test_runs_of_two_years_are_those_of_cronsim(tz: str, at: time, days: tuple[int, ...], after: datetime) -> None:
    after = after.replace(second=0, microsecond=0)
    assert list(islice(runs(schedule(tz, at=(at,), days=days), after), 6)) == by_cronsim(at, days, tz, after, 6)


@settings(max_examples=100, deadline=None)
@given(
    st.sampled_from(ZONES),
    st.lists(st.times().map(lambda at: at.replace(second=0, microsecond=0)), min_size=1, max_size=5),
    st.datetimes(datetime(2025, 1, 1), datetime(2026, 11, 1), timezones=st.just(UTC)),
)
def test_several_times_run_in_order_and_once_each_moment(tz: str, at: list[time], after: datetime) -> None:
    after = after.replace(second=0, microsecond=0)
    ours = list(islice(runs(schedule(tz, at=tuple(at)), after), 8))
    single = {run for one in at for run in by_cronsim(one, (), tz, after, 8)}
    assert ours == sorted(single)[:8]


def test_a_skipped_time_is_the_first_valid_minute_and_a_doubled_one_runs_once() -> None:
    berlin = schedule("Europe/Berlin", at=(time(2, 30),))
    spring, autumn = datetime(2026, 3, 28, 12, tzinfo=UTC), datetime(2026, 10, 24, 12, tzinfo=UTC)
    assert next_run(berlin, spring) == datetime(2026, 3, 29, 1, tzinfo=UTC), "03:00 there"
    twice = list(islice(runs(berlin, autumn), 2))
    assert twice == [datetime(2026, 10, 25, 0, 30, tzinfo=UTC), datetime(2026, 10, 26, 1, 30, tzinfo=UTC)]


def test_times_that_are_skipped_together_run_once() -> None:
    berlin = schedule("Europe/Berlin", at=(*(time(2, minute) for minute in range(0, 60, 15)), time(3)))
    found = list(islice(runs(berlin, datetime(2026, 3, 28, 12, tzinfo=UTC)), 2))
    assert found == [datetime(2026, 3, 29, 1, tzinfo=UTC), datetime(2026, 3, 30, 0, tzinfo=UTC)]


def test_an_interval_is_elapsed_time() -> None:
    hourly = schedule("Europe/Berlin", datetime(2026, 10, 24, 23, 30, tzinfo=UTC), every_s=3600)
    assert [run.hour for run in first_runs(hourly, 4)] == [23, 0, 1, 2]
    assert next_run(hourly, datetime(2026, 10, 25, 0, 30, tzinfo=UTC)) == datetime(2026, 10, 25, 1, 30, tzinfo=UTC)


def test_limits_and_exceptions_hold() -> None:
    daily = schedule(at=(time(9),), except_dates=(date(2025, 1, 2),), until_at=datetime(2025, 1, 4, tzinfo=UTC))
    assert [run.day for run in runs(daily)] == [1, 3]
    once = Schedule(BEGIN, END, "UTC", runs_left=1)
    assert list(runs(once)) == [BEGIN]
    assert next_run(once, BEGIN) is None
    assert len(list(runs(Schedule(BEGIN, END, "UTC", runs_left=3, every_s=600)))) == 3


def test_an_unknown_zone_is_refused_with_a_valid_one() -> None:
    with pytest.raises(ValueError, match="Europe/Berlin"):
        zone_of("Europe/Nowhere")
