"""The file that exists while a step runs: when it is refreshed, how long it counts, and what is left after the step."""

from __future__ import annotations

import math
import os
from pathlib import Path
from types import SimpleNamespace

import pytest

from agentrob.robots.safety import crash_marker
from agentrob.robots.safety.crash_marker import BEAT_S, COUNTS_S, CrashMarker, InterruptedStep


class Clock:
    """The monotonic clock of the marker; it starts at the first second of the machine."""

    def __init__(self) -> None:
        self.now_s = 0.0


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    made = Clock()
    monkeypatch.setattr(crash_marker, "time", SimpleNamespace(monotonic=lambda: made.now_s))
    return made


def begun(path: Path, mode: str = "walking") -> CrashMarker:
    mark = CrashMarker(path)
    mark.begin("move", mode)
    return mark


def test_the_times_are_those_of_a_robot_that_moves_on_after_its_driver_died() -> None:
    assert BEAT_S == 0.5, "twice before the motion of a killed driver ends"
    assert COUNTS_S == 10.0, "as long as the longest gesture"


def test_it_is_written_at_the_beginning_also_right_after_the_machine_started(tmp_path: Path, clock: Clock) -> None:
    begun(tmp_path / "new" / "drivers" / "robot.step")
    assert CrashMarker(tmp_path / "new" / "drivers" / "robot.step").interrupted_step() == InterruptedStep(
        "move", "walking"
    )


def test_it_is_refreshed_when_the_beat_is_over_and_not_before(tmp_path: Path, clock: Clock) -> None:
    mark = begun(tmp_path / "robot.step", "idle")
    for now_s, mode, told in (
        (BEAT_S / 2, "walking", "idle"),
        (math.nextafter(BEAT_S, 0), "walking", "idle"),
        (BEAT_S, "walking", "walking"),
        (math.nextafter(2 * BEAT_S, 0), "idle", "walking"),
        (2 * BEAT_S, "idle", "idle"),
    ):
        clock.now_s = now_s
        mark.refresh(mode)
        assert CrashMarker(mark.path).interrupted_step() == InterruptedStep("move", told)


def test_law_12_it_counts_for_ten_seconds_after_it_was_written_and_not_before(tmp_path: Path, clock: Clock) -> None:
    clock.now_s = 100.0
    mark = begun(tmp_path / "robot.step")
    for now_s, counts in (
        (100.0, True),
        (100.0 + COUNTS_S, True),
        (math.nextafter(100.0 + COUNTS_S, math.inf), False),
        (math.nextafter(100.0, 0), False),
    ):
        clock.now_s = now_s
        assert (CrashMarker(mark.path).interrupted_step() is not None) == counts, now_s


def test_a_long_mode_is_cut_and_a_shorter_one_replaces_it_whole(tmp_path: Path, clock: Clock) -> None:
    mark = begun(tmp_path / "robot.step", "m" * 31)
    assert CrashMarker(mark.path).interrupted_step() == InterruptedStep("move", "m" * 30)
    clock.now_s = BEAT_S
    mark.refresh("up")
    assert CrashMarker(mark.path).interrupted_step() == InterruptedStep("move", "up")


def test_only_the_owner_may_read_it(tmp_path: Path) -> None:
    mark = begun(tmp_path / "robot.step")
    assert mark.path is not None
    assert mark.path.stat().st_mode & 0o777 == 0o600


def test_after_a_step_no_file_is_left_open_and_nothing_is_written_any_more(tmp_path: Path, clock: Clock) -> None:
    opened = set(os.listdir("/proc/self/fd"))
    mark = begun(tmp_path / "robot.step")
    mark.end()
    assert set(os.listdir("/proc/self/fd")) == opened
    with (tmp_path / "other").open("w") as other:  # it gets the number that the marker's file had
        clock.now_s = 10 * BEAT_S
        mark.refresh("walking")
        mark.end()
        other.write("of somebody else")
    assert (tmp_path / "other").read_text() == "of somebody else"
    assert not (tmp_path / "robot.step").exists()


def test_a_marker_that_is_gone_already_is_no_problem(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    mark = begun(tmp_path / "robot.step")
    (tmp_path / "robot.step").unlink()
    mark.end()
    assert not caplog.records
