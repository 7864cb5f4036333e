"""The file of a robot's lock (law 17): its content, and a release that removes only the lock that it was meant for."""

from __future__ import annotations

import json
import threading
import time
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from agentrob.errors import RobotError
from agentrob.model import EMERGENCY_STOP
from agentrob.robots.safety import lock as halts
from agentrob.robots.safety.lock import Halt, sentence


def test_law_17_who_locked_it_why_and_when_outlives_the_process(tmp_path: Path) -> None:
    path = tmp_path / "data" / "rex.halt"
    first = Halt(path)
    assert first.save(), "there is nothing to write"
    assert not path.exists()
    assert first.set("bob", EMERGENCY_STOP).endswith(": an emergency stop")
    assert first.save()
    lock = Halt(path).lock
    assert lock is not None
    assert (lock.by, lock.why) == ("bob", "an emergency stop")
    assert lock.at is not None
    assert abs(datetime.now(UTC) - lock.at) < timedelta(seconds=10)
    earlier = replace(lock, at=lock.at - timedelta(minutes=12))
    assert sentence(earlier) == "Halted by bob 12 minutes ago: an emergency stop"
    assert sentence(replace(lock, at=None)) == "Halted by bob: an emergency stop"


@pytest.mark.parametrize(
    ("kept", "said"),
    [
        # As written by version 0.1.
        ('{"why": "Halted by olga: smoke", "at": "2026-11-22T16:00:05+00:00"}', "Halted by olga: smoke"),
        ("", "cannot be read"),
        ("{}", "cannot be read"),
        ("[]", "cannot be read"),
        ("null", "cannot be read"),
        ('{"why": "x", "at": "yesterday"}', "cannot be read"),
        ('{"why": "x", "at": 7}', "cannot be read"),
        ("\xff", "cannot be read"),
    ],
)
def test_law_17_whatever_is_in_the_file_it_is_locked_and_can_be_released(tmp_path: Path, kept: str, said: str) -> None:
    path = tmp_path / "rex.halt"
    path.write_bytes(kept.encode("latin-1"))
    halt = Halt(path)
    assert halt.why is not None
    assert halt.why == said or (said in halt.why and halt.why.startswith("Halted: "))
    assert halt.release(time.monotonic()) is not None
    assert halt.lock is None
    assert not path.exists()


def test_law_17_a_halt_that_is_not_on_the_disk_is_released_as_any_other(tmp_path: Path) -> None:
    for folder in (tmp_path, tmp_path / "never made"):
        halt = Halt(folder / "rex.halt")
        halt.set("bob", EMERGENCY_STOP)
        assert halt.release() is not None
        assert halt.lock is None
        assert halt.release() is None


@pytest.mark.parametrize("ahead", [timedelta(days=400), timedelta()], ids=["to come", "now"])
def test_law_17_a_release_of_before_does_not_end_a_lock_that_was_read_from_the_file(
    tmp_path: Path, ahead: timedelta
) -> None:
    path, at = tmp_path / "rex.halt", datetime.now(UTC) + ahead
    asked_s = time.monotonic() - 60
    path.write_text(json.dumps({"by": "bob", "why": "x", "at": at.isoformat()}))
    halt = Halt(path)
    with pytest.raises(RobotError, match="locked after this release was requested"):
        halt.release(asked_s)
    assert path.exists()
    assert halt.release(time.monotonic()) is not None, "also when the clock had leapt ahead: one of now does"


def test_law_17_a_halt_that_comes_while_one_is_released_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The second stop comes while the file is being removed: an emergency stop is never lost."""
    halt = Halt(tmp_path / "rex.halt")
    halt.set("bob", EMERGENCY_STOP)
    halt.save()
    keeping: list[threading.Thread] = []

    def again(_: Path) -> None:
        halt.set("eve", EMERGENCY_STOP)
        keeping.append(threading.Thread(target=halt.save))
        keeping[0].start()

    monkeypatch.setattr(halts, "sync_folder", again)
    with pytest.raises(RobotError, match="locked again during the release"):
        halt.release()
    monkeypatch.undo()
    keeping[0].join(60)
    assert halt.lock is not None
    assert halt.lock.by == "eve"
    kept = Halt(halt.path).lock
    assert kept is not None
    assert kept.by == "eve", "it is on the disk too"
    assert halt.release() is not None
    assert Halt(halt.path).lock is None
