"""The guard reads a robot's states: implausible values are unknown, and a home stays where it is."""

from __future__ import annotations

import math
import time
from dataclasses import replace

import pytest

from agentrob.model import Op, Outcome, Primitive, RobotState
from agentrob.robots.contract import go_on
from agentrob.robots.safety.guard import sanitized
from tests.robots.guard_scene import Make, fake_of, move
from tests.waiting import wait_for


@pytest.mark.parametrize("velocity_mps", [(math.nan, 0.0), (0.0, math.inf), (math.nan, math.nan)])
def test_a_velocity_of_which_one_part_is_no_number_is_unknown(velocity_mps: tuple[float, float]) -> None:
    assert sanitized(RobotState(age_s=0.0, velocity_mps=velocity_mps)).velocity_mps is None


def test_values_at_the_edge_of_what_makes_sense_are_kept() -> None:
    state = RobotState(age_s=0.0, velocity_mps=(0.0, -0.1), battery_percent=0.0)
    assert sanitized(state) == state
    assert sanitized(replace(state, battery_percent=0.5)).battery_percent == 0.5


def test_a_negative_age_or_charge_is_unknown() -> None:
    seen = sanitized(RobotState(age_s=-0.001, battery_percent=-0.001))
    assert (seen.age_s, seen.battery_percent) == (math.inf, None)


def test_law_8_a_robot_whose_mode_says_that_it_has_fallen_is_not_known_to_stand(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    guard = make()
    wait_for(lambda: guard.state().homed)
    seen = fake_of(guard)._seen
    monkeypatch.setattr(fake_of(guard), "_seen", lambda: replace(seen(), upright=True, mode="fallen"))
    result = guard.step(Primitive(Op.HELLO), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "fallen")
    assert result.message == "The robot is not known to stand upright."


def test_of_an_old_state_without_a_position_its_age_is_told(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agentrob.robots.safety.guard.PREPARE_S", 0.1)
    guard = make()
    wait_for(lambda: guard.state().homed)
    seen = fake_of(guard)._seen
    monkeypatch.setattr(fake_of(guard), "_seen", lambda: replace(seen(), pose=None, age_s=0.5))
    result = guard.step(Primitive(Op.HELLO), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "stale_state")
    assert result.message == "The robot's state is 0.5 s old; it must be younger than 0.5 s."


def test_law_9_a_simulated_robot_that_has_a_home_keeps_it_where_it_rests(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    guard = make()
    assert guard.step(move(1.0), go_on).ok
    seen, update = list[bool](), guard._takeover.update

    def noted(now_s: float, state: RobotState, **ours: bool) -> str | None:
        seen.append(guard._odometry.still(now_s))
        return update(now_s, state, **ours)

    monkeypatch.setattr(guard._takeover, "update", noted)
    wait_for(lambda: seen.count(True) > 2)  # the guard has seen it stand, as it must to set a home
    assert guard._odometry.still(time.monotonic())
    pose = guard.posture().pose
    assert pose is not None
    assert pose.x_m == pytest.approx(1.0, abs=0.1)
