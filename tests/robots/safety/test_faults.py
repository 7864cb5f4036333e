"""Faults without physics: how the guard reacts to a fall, a low battery, a jumping clock and an empty picture."""

from __future__ import annotations

import io
import itertools
import math
import time
from dataclasses import replace
from typing import Any

import pytest
from PIL import Image

from agentrob.errors import RobotError
from agentrob.model import ActionResult, Op, Outcome, Primitive
from agentrob.robots.control.picture_check import picture_problem
from agentrob.robots.fake import FakeRobot
from agentrob.robots.protocol import Watch
from agentrob.robots.safety.guard import Guard
from tests.robots.guard_scene import Make, can_set_home, fake_of, move, turn
from tests.waiting import wait_for

STAND, HELLO, PHOTO = Primitive(Op.STAND), Primitive(Op.HELLO), Primitive(Op.GET_FRONT_IMAGE)


def keep_going(_: object) -> None:
    return None


# ------------------------------------------------------------------ falls
@pytest.mark.parametrize("primitive", [move(0.3), turn(30), HELLO, Primitive(Op.SIT)])
def test_law_8_a_robot_that_lies_does_nothing_but_stand_up(make: Make, primitive: Primitive) -> None:
    guard = make()
    assert guard.step(move(0.1), keep_going).ok
    fake_of(guard).faults.fallen = True
    result = guard.step(primitive, keep_going)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "fallen"), result.message


def gets_up(guard: Guard, monkeypatch: pytest.MonkeyPatch) -> FakeRobot:
    """Let the robot stand up when it is asked to, turned by 170° at once, as a body that rolls over may be."""
    fake = fake_of(guard)
    plain = fake.step

    def step(primitive: Primitive, watch: Watch) -> ActionResult:
        if primitive.op is Op.STAND and fake.faults.fallen:
            here = fake.state().pose
            assert here is not None
            fake.carry(replace(here, yaw_rad=here.yaw_rad + math.radians(170)))
        result = plain(primitive, watch)
        fake.faults.fallen = fake.faults.fallen and primitive.op is not Op.STAND
        return result

    monkeypatch.setattr(fake, "step", step)
    return fake


def test_a_robot_that_lies_gets_up_when_it_is_asked_and_goes_on(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    guard = make()
    assert guard.step(move(0.1), keep_going).ok
    gets_up(guard, monkeypatch).faults.fallen = True
    assert guard.step(STAND, keep_going).ok
    assert guard.step(move(0.1), keep_going).ok


def test_law_9_a_fall_voids_home_and_a_robot_that_lies_may_stand_up_without_one(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Home can only be set where the robot stands, so standing up cannot need it: nobody could ever move it again."""
    guard = make(home_on_start=False)
    wait_for(lambda: can_set_home(guard))
    fake = gets_up(guard, monkeypatch)
    fake.faults.fallen = True
    wait_for(lambda: not guard.state().homed)
    assert guard.step(HELLO, keep_going).reason == "fallen"
    assert guard.step(STAND, keep_going).ok
    for primitive in (STAND, move(0.1)):
        result = guard.step(primitive, keep_going)
        assert (result.outcome, result.reason) == (Outcome.REFUSED, "not_homed"), result.message
    wait_for(lambda: can_set_home(guard))
    assert guard.step(move(0.1), keep_going).ok


def test_law_18_a_robot_that_lies_afterwards_has_done_nothing_well(make: Make) -> None:
    guard = make()
    assert guard.step(move(0.1), keep_going).ok
    fake_of(guard).faults.fallen = True
    result = guard.step(STAND, keep_going)
    assert (result.outcome, result.reason) == (Outcome.FAILED, "fallen")
    assert "did not get up" in result.message


@pytest.mark.parametrize(("faults", "reason"), [({"jump_m": 1.0}, "fallen"), ({"frozen": True}, "stalled")])
def test_law_18_any_step_reports_a_robot_that_is_down_and_a_fall_explains_a_jump(
    make: Make, monkeypatch: pytest.MonkeyPatch, faults: dict[str, float | bool], reason: str
) -> None:
    guard = make({"faults": {**faults, "after_m": 0.2}})
    fake = fake_of(guard)
    plain = fake.step

    def falls(primitive: Primitive, watch: Watch) -> ActionResult:
        result = plain(primitive, watch)
        fake.faults.fallen = True
        return result

    monkeypatch.setattr(fake, "step", falls)
    result = guard.step(move(0.5), keep_going)
    assert (result.ok, result.reason) == (False, reason), result.message
    assert "The robot is now down" in result.message


def test_a_robot_without_an_attitude_is_not_stood_up(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    guard = make()
    assert guard.step(move(0.1), keep_going).ok
    seen = fake_of(guard)._seen
    monkeypatch.setattr(fake_of(guard), "_seen", lambda: replace(seen(), upright=None))
    result = guard.step(STAND, keep_going)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "fallen")


def test_law_9_a_robot_that_lies_is_given_no_home(make: Make) -> None:
    guard = make(home_on_start=False)
    fake_of(guard).faults.fallen = True
    wait_for(lambda: guard.state().mode == "fallen")
    with pytest.raises(RobotError, match="upright"):
        guard.home("owner")


# ------------------------------------------------------------------ battery
@pytest.mark.parametrize(
    ("percent", "least", "begins"), [(14.9, 15, False), (15, 15, True), (0, 0, True), (30, 40, False)]
)
def test_law_8_below_the_owners_level_no_motion_begins(make: Make, percent: float, least: float, begins: bool) -> None:
    guard = make(options={"faults": {"battery_percent": percent}}, least_battery_percent=least)
    result = guard.step(move(0.3), keep_going)
    assert result.ok is begins, result.message
    if not begins:
        assert (result.outcome, result.reason) == (Outcome.REFUSED, "low_battery")
        assert f"below {least:g} %" in result.message
        assert guard.step(PHOTO, keep_going).ok, "looking costs nothing"


@pytest.mark.parametrize("percent", [None, float("nan")])
def test_a_charge_that_is_not_reported_holds_nothing_up(
    make: Make, monkeypatch: pytest.MonkeyPatch, percent: float | None
) -> None:
    guard = make()
    fake_of(guard).faults.battery_percent = percent  # type: ignore[assignment]
    assert guard.step(move(0.3), keep_going).ok
    assert guard.state().battery_percent is None


def test_a_step_during_which_the_battery_runs_low_is_ended_in_order_and_says_so(make: Make) -> None:
    guard = make(options={"faults": {"battery_percent": 14, "after_m": 0.2}})
    result = guard.step(move(0.5), keep_going)
    assert result.ok
    assert "The battery is at 14 %" in result.message
    assert guard.step(move(0.1), keep_going).reason == "low_battery"


# ------------------------------------------------------------------ clocks
def test_a_wall_clock_that_leaps_changes_nothing(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    """The host's time of day may be changed at any moment; only the monotonic clock counts."""
    day_s = itertools.cycle((0.0, 86_400.0, -86_400.0))
    real = time.time
    monkeypatch.setattr(time, "time", lambda: real() + next(day_s))
    guard = make(options={"time_scale": 10})
    wait_for(lambda: guard.state().homed)
    result = guard.step(move(1.0), keep_going)
    assert result.ok, result.message
    assert 0 < result.duration_s < 10
    assert guard.stop().confirmed


# ------------------------------------------------------------------ pictures
def jpeg(picture: Image.Image) -> bytes:
    buffer = io.BytesIO()
    picture.save(buffer, "JPEG")
    return buffer.getvalue()


def noise(level: int, most: int) -> Image.Image:
    """Return a dark picture with sensor noise."""
    picture = Image.effect_noise((320, 240), most).convert("L")
    return picture.point(lambda v: max(0, min(255, v - 128 + level)))


@pytest.mark.parametrize(
    ("picture", "said"),
    [
        (Image.new("RGB", (640, 480)), "all black"),
        (Image.new("RGB", (640, 480), (0, 120, 0)), "all of one colour"),
        (noise(8, 6), "all black"),
    ],
)
def test_a_picture_that_shows_nothing_is_not_called_one(picture: Image.Image, said: str) -> None:
    assert said in (picture_problem(jpeg(picture)) or "")


def test_a_picture_that_shows_something_however_dark_is_one() -> None:
    dark = noise(10, 4)
    dark.paste(40, (100, 80, 160, 140))
    assert picture_problem(jpeg(dark)) is None


@pytest.mark.parametrize("spoil", [lambda b: b[:200], lambda b: b"\xff\xd8" + b"nonsense" * 99, lambda _: b""])
def test_what_is_no_picture_is_said_so(spoil: Any) -> None:
    whole = jpeg(Image.linear_gradient("L"))
    assert picture_problem(whole) is None
    assert "cannot be read" in (picture_problem(spoil(whole)) or "")


def test_law_18_a_blank_picture_is_a_failure_that_is_shown_all_the_same(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    guard = make()
    monkeypatch.setattr(fake_of(guard), "_picture", lambda: jpeg(Image.new("RGB", (320, 240))))
    result = guard.step(PHOTO, keep_going)
    assert (result.outcome, result.reason) == (Outcome.FAILED, "bad_image")
    assert result.image is not None
