"""Parts of the simulated world in isolation: the clock, the event log, assets."""

import json
import threading
import time

import numpy as np
import pytest

from agentrob.errors import SimError
from agentrob.sim.bodies.go2_gestures import STAND_RAD, Frame, Motion
from agentrob.sim.event_log import EventLog
from agentrob.sim.realtime_loop import WAIT_S, RealtimeLoop
from agentrob.sim.world import assets

pytestmark = pytest.mark.sim


def test_a_missing_package_is_named(monkeypatch):
    monkeypatch.setattr(assets, "_PACKAGE", "no_such_package_here")
    with pytest.raises(SimError, match="needs the package agentrob-world"):
        assets.model("go2")


def test_a_missing_file_is_named():
    with pytest.raises(SimError, match=r"h1\.xml is missing: install the package agentrob-world again"):
        assets.model("h1")


def test_a_motion_begins_at_the_joints_and_ends_at_its_last_pose():
    start = STAND_RAD + 0.1
    motion = Motion(start, [Frame(1.0, STAND_RAD), Frame(0.5, STAND_RAD, stiffness=2.0)])
    assert motion.seconds == 1.5
    first, nearly_last = motion(0.0), motion(1.49)
    assert first is not None
    assert nearly_last is not None
    assert np.allclose(first[0], start)
    assert np.allclose(nearly_last[0], STAND_RAD)
    assert nearly_last[1] == 2.0
    assert motion(1.5) is None


def run_clock(clock, tick):
    thread = threading.Thread(target=clock.run, args=(tick,))
    thread.start()
    return thread


def test_the_clock_does_work_at_once_not_at_the_next_tick():
    clock, done, ticked = RealtimeLoop(period_s=0.5), threading.Event(), threading.Event()
    thread = run_clock(clock, ticked.set)
    assert ticked.wait(60)
    began = time.monotonic()
    clock.call_soon(done.set)
    assert done.wait(60)
    assert time.monotonic() - began < 0.3
    clock.stop()
    thread.join(60)
    assert not thread.is_alive()


def test_a_slow_machine_shows_in_the_real_time_factor():
    clock, enough = RealtimeLoop(period_s=0.01), threading.Event()
    ticks = 0

    def slow_tick() -> None:
        nonlocal ticks
        ticks += 1
        threading.Event().wait(0.02)
        if ticks == 40:
            enough.set()

    thread = run_clock(clock, slow_tick)
    assert enough.wait(60)
    assert clock.real_time_factor < 0.8
    clock.stop()
    thread.join(60)


def test_a_fast_machine_runs_in_real_time():
    clock, enough = RealtimeLoop(period_s=0.01), threading.Event()
    ticks = 0

    def tick() -> None:
        nonlocal ticks
        ticks += 1
        if ticks == 100:
            enough.set()

    began = time.monotonic()
    thread = run_clock(clock, tick)
    assert enough.wait(60)
    assert time.monotonic() - began > 0.9
    assert 0.9 < clock.real_time_factor < 1.1
    clock.stop()
    thread.join(60)


def simulated(clock, seconds, tick=lambda: None, awaits=lambda: False):
    """Return the simulated seconds after this many real ones."""
    ticks = [0]

    def count():
        ticks[0] += 1
        tick()

    thread = threading.Thread(target=clock.run, args=(count, awaits))
    thread.start()
    time.sleep(seconds)
    clock.stop()
    thread.join(60)
    return ticks[0] * 0.01


def test_a_world_goes_at_the_pace_that_is_asked_for():
    assert 0.2 < simulated(RealtimeLoop(0.01, pace=0.5), 1.0) < 0.6
    assert 1.1 < simulated(RealtimeLoop(0.01, pace=4.0), 1.0) < 4.2


def test_a_world_waits_for_a_command_but_not_forever():
    assert simulated(RealtimeLoop(0.01, pace=4.0), 0.9 * WAIT_S, awaits=lambda: True) == 0
    assert simulated(RealtimeLoop(0.01, pace=4.0), WAIT_S + 1.0, awaits=lambda: True) > 1.0


def test_the_ledger_is_there_line_by_line(tmp_path):
    path = tmp_path / "ledger.jsonl"
    event_log = EventLog(path)
    event_log.write(1.5, "go2", "move_begin", {"x_m": 0.0}, {"velocity": [0.5, 0, 0]})
    line = json.loads(path.read_text())
    assert (line["time_s"], line["robot"], line["event"], line["velocity"]) == (1.5, "go2", "move_begin", [0.5, 0, 0])
    event_log.close()


def test_a_ledger_on_a_full_disk_says_so_once_and_does_not_stop_the_world(capsys):
    from pathlib import Path

    event_log = EventLog(Path("/dev/full"))
    for _ in range(3):
        event_log.write(0.0, "go2", "move_begin", {}, {})
    assert "No space" in event_log.last_error
    assert capsys.readouterr().err.count("incomplete") == 1


def test_a_ledger_that_cannot_be_opened_is_refused(tmp_path):
    with pytest.raises(SimError, match="cannot write the event log"):
        EventLog(tmp_path / "no" / "such" / "folder")
