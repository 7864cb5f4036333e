"""The guard refuses a step or ends it (laws 8, 9, 10 and 14), and halts (law 17)."""

from __future__ import annotations

import math
import re
import threading
import time
import tomllib
from pathlib import Path
from typing import Any

import pytest

from agentrob.config.robots import FenceConfig
from agentrob.model import Op, Outcome, Pose, Primitive, RobotState
from agentrob.robots.contract import go_on
from agentrob.robots.safety.lock import Halt
from tests.robots.guard_scene import B, F, L, Make, can_set_home, fake_of, move, turn
from tests.waiting import wait_for


# ------------------------------------------------------------------ before a step
@pytest.mark.parametrize(
    ("primitive", "word", "number"),
    [
        (move(5.1), "limit_step_m", "5 m"),
        (move(1e9), "limit_step_m", "5 m"),
        (move(1.0, speed_mps=0.6), "limit_speed_mps", "0.5 m/s"),
        (turn(361), "limit_step_deg", "360°"),
        (move(0), "invalid", "0.01 m"),
        (move(-1), "invalid", "0.01 m"),
        (move(math.nan), "invalid", "0.01 m"),
        (move(5e-324), "invalid", "0.01 m"),
        (move(math.inf), "limit_step_m", "5 m"),
        (move(1.0, speed_mps=math.nan), "invalid", "0.05 m/s"),
        (move(1.0, speed_mps=0.0), "invalid", "0.05 m/s"),
        (move(1.0, speed_mps=1e-300), "invalid", "0.05 m/s"),
        (Primitive(Op.MOVE, F), "invalid", "0.01 m"),
        (Primitive(Op.MOVE, None, distance_m=1.0), "invalid", "0.01 m"),
        (Primitive(Op.TURN, F, degrees=90), "invalid", "left or right"),
        (turn(math.nan), "invalid", "1°"),
        (turn(-90), "invalid", "1°"),
        (move(4.95), "fence", "5 m"),
        (move(4.95, B), "fence", "-5"),
    ],
)
def test_law_10_beyond_a_limit_is_refused_with_the_limit_named(
    make: Make, primitive: Primitive, word: str, number: str
) -> None:
    guard = make()
    result = guard.step(primitive, go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, word)
    assert number in result.message
    assert fake_of(guard).commanded == (0, 0, 0)


@pytest.mark.parametrize(
    ("faults", "word"),
    [
        ({"stale": True}, "stale_state"),
        ({"fallen": True}, "fallen"),
        ({"ranges": "missing"}, "ranges_unknown"),
        ({"ranges": "zero"}, "ranges_unknown"),
        ({"ranges": "constant"}, "ranges_unknown"),
    ],
)
def test_law_8_a_robot_in_no_fit_state_is_not_moved(make: Make, faults: dict[str, Any], word: str) -> None:
    guard = make({"faults": faults})
    if word == "stale_state":
        guard.step(move(0.1), go_on)  # virtual time stands still between steps
        fake_of(guard).wait_until(fake_of(guard).now_s() + 1.0)
    result = guard.step(move(0.5), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, word)
    assert fake_of(guard).pose.x_m < 0.2


def test_law_8_unknown_ranges_need_consent_and_then_mean_slow_and_the_result_says_so(make: Make) -> None:
    guard = make({"faults": {"ranges": "missing"}}, allow_unknown_ranges=True)
    result = guard.step(move(0.5), go_on)
    assert result.outcome is Outcome.DONE, result.message
    assert result.primitive == move(0.5)
    assert "0.2 m/s" in result.message
    assert "unknown" in result.message
    assert guard.step(turn(30), go_on).ok
    forward, left, turning = fake_of(guard).commanded
    assert max(forward, left) <= 0.2 + 1e-9
    assert turning * 0.4 <= 0.2 + 1e-9


def test_law_8_an_obstacle_at_hand_refuses_what_goes_towards_it_only(make: Make) -> None:
    guard = make({"obstacles": [[0.9, 0.0, 0.3]]})
    result = guard.step(move(1.0), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "obstacle")
    assert "0.60 m ahead" in result.message
    assert guard.step(move(0.5, B), go_on).ok


def test_law_8_a_turn_needs_room_all_around(make: Make) -> None:
    guard = make({"room": [-3, 3, -0.3, 3]})
    result = guard.step(turn(90), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "obstacle")
    assert "to the right" in result.message


def test_law_9_no_home_no_motion(make: Make) -> None:
    guard = make(home_on_start=False)
    result = guard.step(move(0.5), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "not_homed")
    wait_for(lambda: can_set_home(guard))
    assert guard.state().homed
    assert guard.step(move(0.5), go_on).ok


def test_a_real_robot_never_homes_itself(make: Make) -> None:
    guard = make(simulated=False)
    result = guard.step(move(0.5), go_on)
    assert result.reason == "not_homed"
    assert "home_on_start homes simulated robots only" in result.message
    unset = make(simulated=False, home_on_start=False)
    assert "home_on_start" not in unset.step(move(0.5), go_on).message


def test_the_configuration_of_the_guide_homes_its_robot(make: Make) -> None:
    guide = (Path(__file__).parents[3] / "docs/robots/add-a-robot.md").read_text(encoding="utf-8")
    written = tomllib.loads(next(t for t in re.findall(r"```toml\n(.*?)```", guide, re.DOTALL) if "[robots." in t))
    (settings,) = written["robots"].values()
    guard = make(**{"simulated": False, "home_on_start": False, **settings, "model": "fake"})
    assert guard.step(move(0.5), go_on).ok


def test_the_fence_lies_around_home_and_turns_with_it(make: Make) -> None:
    guard = make(fence=FenceConfig(x_min_m=-0.5, x_max_m=2, y_min_m=-0.5, y_max_m=0.5), home_on_start=False)
    fake_of(guard).carry(Pose(3.0, -2.0, math.pi / 2))
    wait_for(lambda: can_set_home(guard))
    assert guard.step(move(1.8), go_on).ok
    assert fake_of(guard).pose.y_m == pytest.approx(-0.2, abs=0.05)
    refused = guard.step(move(0.5, L), go_on)
    assert refused.reason == "fence"
    assert "y 0.5" in refused.message


def test_a_step_that_cannot_end_in_time_is_not_begun(make: Make) -> None:
    guard = make()
    result = guard.step(move(2.0), go_on, deadline_s=3.0)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "deadline")
    assert "4.0 s" in result.message
    assert guard.step(move(0.5), go_on, deadline_s=-1.0).reason == "deadline"
    assert guard.step(move(0.5), go_on, deadline_s=math.nan).outcome is not Outcome.DONE


def test_law_10_a_flip_needs_the_owners_consent_on_a_real_robot(make: Make) -> None:
    flip = Primitive(Op.BACKFLIP)
    real = make(simulated=False)
    wait_for(lambda: can_set_home(real))
    assert real.step(flip, go_on).reason == "consent"
    willing = make(simulated=False, allow_flip=True)
    wait_for(lambda: can_set_home(willing))
    assert willing.step(flip, go_on).ok
    assert make().step(flip, go_on).ok


def test_looking_is_always_allowed(make: Make) -> None:
    guard = make({"faults": {"fallen": True}}, home_on_start=False)
    guard.halt("owner")
    assert guard.step(Primitive(Op.GET_FRONT_IMAGE), go_on).ok


# ------------------------------------------------------------------ on the way
@pytest.mark.parametrize(
    ("faults", "word"),
    [
        ({"stale": True, "after_m": 0.5}, "stale_state"),
        ({"fallen": True, "after_m": 0.5}, "fallen"),
        ({"jump_m": 1.0, "after_m": 0.5}, "odometry_jump"),
        ({"ranges": "zero", "after_m": 0.5}, "ranges_unknown"),
        ({"mode": "damping", "after_m": 0.5}, "halted"),
    ],
)
def test_law_8_trouble_on_the_way_ends_the_step(make: Make, faults: dict[str, Any], word: str) -> None:
    guard = make({"faults": faults})
    result = guard.step(move(2.0), go_on)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, word), result.message
    assert "measured" in result.message
    assert fake_of(guard).pose.x_m - (1.0 if faults.get("jump_m") else 0.0) < 1.2


def test_law_8_an_obstacle_on_the_way_ends_the_move_before_it(make: Make) -> None:
    guard = make({"obstacles": [[2.0, 0.0, 0.3]]})
    result = guard.step(move(2.0), go_on)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "obstacle")
    assert "ahead" in result.message
    assert 0.8 < result.measured["distance_m"] < 1.35


def test_the_deadline_ends_a_step(make: Make) -> None:
    guard = make({"time_scale": 1})
    began_s = time.monotonic()
    result = guard.step(move(0.2), go_on, deadline_s=0.5)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "deadline")
    assert time.monotonic() - began_s < 5.0


def test_a_robot_that_answers_but_does_not_move_has_failed(make: Make) -> None:
    guard = make({"faults": {"frozen": True}})
    result = guard.step(move(1.0), go_on)
    assert (result.outcome, result.reason) == (Outcome.FAILED, "stalled")
    assert "Asked 1 m, measured 0.00 m" in result.message


def test_lost_commands_do_not_spoil_a_step(make: Make) -> None:
    guard = make({"faults": {"drops": 0.3}})
    result = guard.step(move(1.0), go_on)
    assert result.ok, result.message


def test_a_stop_that_the_robot_does_not_follow_is_reported(make: Make) -> None:
    guard = make({"faults": {"unconfirmed": True}, "time_scale": 10})
    moving = threading.Event()

    def watch(state: RobotState) -> str | None:
        if state.pose and state.pose.x_m > 0.2:
            moving.set()
        return None

    thread = threading.Thread(target=lambda: guard.step(move(3.0), watch))
    thread.start()
    assert moving.wait(60)
    stopped = guard.stop()
    thread.join(60)
    assert stopped.was_moving
    assert not stopped.confirmed
    assert stopped.coasted_m is None
    assert stopped.message


def test_two_steps_at_once_are_not_done(make: Make) -> None:
    guard = make({"time_scale": 1})
    inside = threading.Event()

    def watch(_: RobotState) -> str | None:
        inside.set()
        return None

    thread = threading.Thread(target=lambda: guard.step(move(1.0), watch))
    thread.start()
    assert inside.wait(60)
    assert guard.step(turn(10), go_on).reason == "busy"
    guard.stop()
    thread.join(60)


def test_law_14_a_stop_while_a_step_is_prepared_ends_it(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    guard = make()
    wait_for(lambda: guard.state().homed)
    look, stops = fake_of(guard).state, list[bool]()

    def state() -> RobotState:
        if threading.current_thread() is threading.main_thread() and not stops:  # the first check of the step
            stops.append(True)
            guard.stop()
        return look()

    monkeypatch.setattr(fake_of(guard), "state", state)
    result = guard.step(move(1.0), go_on)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stop")
    assert fake_of(guard).commanded == (0, 0, 0)
    assert guard.step(move(0.3), go_on).ok


# ------------------------------------------------------------------ halt
def test_law_17_a_halt_lasts_across_restarts_until_released(make: Make) -> None:
    first = make()
    assert first.halt("owner", "smoke").confirmed
    second = make()
    result = second.step(move(0.3), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "halted")
    assert "smoke" in result.message
    second.release("owner")
    assert second.step(move(0.3), go_on).ok
    assert not make().state().halted


def test_a_halt_file_that_cannot_be_read_is_a_halt(tmp_path: Path) -> None:
    path = tmp_path / "fake.halt"
    for write in (lambda: path.write_text("{nonsense"), lambda: path.write_bytes(b"\xff\xfe"), path.mkdir):
        path.unlink(missing_ok=True)
        write()
        assert Halt(path).why is not None


def test_a_halt_that_the_disk_refuses_holds_while_the_process_lives_and_says_so(make: Make, tmp_path: Path) -> None:
    guard = make()
    guard._halt.path = tmp_path / "a file" / "x.halt"
    (tmp_path / "a file").write_text("not a folder")
    stopped = guard.halt("owner")
    assert "disk" in stopped.message
    assert guard.step(move(0.3), go_on).reason == "halted"
