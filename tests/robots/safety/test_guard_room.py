"""Law 11 in a shared room, in the guard: when the robot's place there is known, and when a step gets its zone."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from agentrob.config.robots import RobotConfig
from agentrob.model import Hindrance, Outcome, Pose, RobotState
from agentrob.robots.contract import go_on
from agentrob.robots.fake import FakeRobot
from agentrob.robots.safety.crash_marker import boot_id
from agentrob.robots.safety.guard import SAME_PLACE_M, Guard
from agentrob.robots.safety.lock import Halt
from agentrob.robots.zones.keeper import LocalKeeper
from agentrob.robots.zones.member import RoomMember
from tests.robots.guard_scene import B, F, can_set_home, fake_of, move
from tests.waiting import wait_for

InRoom = Callable[..., tuple[Guard, RoomMember]]


@pytest.fixture
def in_room(tmp_path: Path) -> Iterator[InRoom]:
    """Make guarded fake robots that share a room; keywords are settings."""
    guards: list[Guard] = []

    def make(name: str, error_m: float | None = 0.1, **changed: object) -> tuple[Guard, RoomMember]:
        given = {"model": "fake", "simulated": True, "home_on_start": True, **changed}
        settings = RobotConfig.model_validate({"options": {"time_scale": math.inf}, **given})
        keeper = LocalKeeper(tmp_path / "lab.sqlite", boot_id, time.monotonic)
        room = RoomMember(name, "lab", keeper, error_m=error_m)
        room.start()
        guards.append(Guard(FakeRobot(settings), settings, Halt(tmp_path / f"{name}.halt"), room=room))
        return guards[-1], room

    yield make
    for guard in guards:
        guard.close()


def homed(guard: Guard) -> None:
    wait_for(lambda: guard.state().homed)


def set_home(guard: Guard) -> None:
    wait_for(lambda: can_set_home(guard))


def test_law_11_a_home_that_is_set_in_another_place_is_not_where_the_settings_say(in_room: InRoom) -> None:
    guard, room = in_room("ann")
    homed(guard)
    assert room.framed
    assert guard.step(move(1.0), go_on).ok
    set_home(guard)
    assert not room.framed, "it takes the whole room from now on"


def test_law_11_a_home_that_is_set_again_in_the_same_place_changes_nothing(in_room: InRoom) -> None:
    guard, room = in_room("ann", simulated=False, home_on_start=False)
    set_home(guard)
    assert guard.step(move(0.5 * SAME_PLACE_M), go_on).ok
    set_home(guard)
    assert room.framed


@pytest.mark.parametrize(("moved_m", "same"), [(0.08, True), (0.12, False)])
def test_law_11_homes_ten_centimetres_apart_are_in_different_places(
    in_room: InRoom, moved_m: float, same: bool
) -> None:
    guard, room = in_room("ann", simulated=False, home_on_start=False)
    set_home(guard)
    fake_of(guard).carry(Pose(moved_m, 0.0, 0.0))
    guard.observe()
    set_home(guard)
    assert room.framed is same


def test_law_11_a_home_is_in_the_same_place_wherever_the_odometry_begins(in_room: InRoom) -> None:
    guard, room = in_room("ann", home_on_start=False)
    for n in range(1, 6):  # each less than a jump
        fake_of(guard).carry(Pose(0.15 * n, 0.15 * n, 0.0))
        guard.observe()
    set_home(guard)
    set_home(guard)
    assert room.framed


@pytest.mark.parametrize("simulated", [True, False])
def test_law_11_back_at_its_first_home_only_a_simulated_robot_is_known_to_be_there(
    in_room: InRoom, simulated: bool
) -> None:
    guard, room = in_room("ann", simulated=simulated, home_on_start=False)
    set_home(guard)
    for way in (F, B):  # a restart may have set the odometry of a real robot to zero anywhere
        assert guard.step(move(1.0, way), go_on).ok
        set_home(guard)
    assert room.framed is simulated


def test_law_11_a_robot_whose_odometry_jumps_takes_the_whole_room(in_room: InRoom) -> None:
    guard, room = in_room("ann")
    homed(guard)
    fake_of(guard).carry(Pose(5.0, 0, 0))
    wait_for(lambda: not room.framed)


def test_law_11_a_step_is_refused_while_another_robot_of_the_room_moves(
    in_room: InRoom, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agentrob.robots.zones.member.KEEP_S", 1000.0)  # so that only leaving gives the room back
    ann, _ = in_room("ann", error_m=None)  # it always takes the whole room
    bob, member = in_room("bob", error_m=None)
    for guard in (ann, bob):
        homed(guard)
    assert ann.enter_room([move(0.3)]) is None
    asked = list[object]()
    with monkeypatch.context() as patched:
        patched.setattr(member, "admit", lambda steps, admit=member.admit: asked.append(steps) or admit(steps))
        hindrance = bob.enter_room([move(0.3)])
    assert hindrance is not None
    assert (hindrance.reason, hindrance.robot) == ("room_busy", "ann")
    assert len(asked) == 1, "it waits for its own rest only, not for others"
    refused = bob.step(move(0.3), go_on)
    assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "room_busy")
    ann.leave_room()
    wait_for(lambda: bob.enter_room([move(0.3)]) is None)
    assert bob.step(move(0.3), go_on).ok


def test_law_11_who_asks_for_a_zone_waits_until_the_robot_is_measured_to_rest(in_room: InRoom) -> None:
    guard, room = in_room("ann")
    assert not room.at_rest, "it has been watched for too short a time"
    assert guard.enter_room([move(0.3)]) is None
    assert room.at_rest


def shake(guard: Guard, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the robot sway where it stands: nobody drives it, and it is never measured to be at rest."""
    seen = fake_of(guard)._seen

    def swaying() -> RobotState:
        return replace(seen(), pose=Pose(0.05 * math.sin(20 * time.monotonic()), 0, 0))

    monkeypatch.setattr(fake_of(guard), "_seen", swaying)


def test_law_11_a_robot_that_does_not_come_to_rest_gets_no_zone(
    in_room: InRoom, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agentrob.robots.safety.guard.REST_S", 0.5)
    guard, _ = in_room("ann")
    shake(guard, monkeypatch)
    hindrance = guard.enter_room([move(0.3)])
    assert hindrance is not None
    assert hindrance.reason == "room_restless"
    assert not guard.state().halted


def test_law_11_a_stop_ends_the_wait_for_a_zone(in_room: InRoom, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agentrob.robots.safety.guard.REST_S", 1000.0)
    guard, _ = in_room("ann")
    shake(guard, monkeypatch)
    found: list[Hindrance | None] = []
    asking = threading.Thread(target=lambda: found.append(guard.enter_room([move(0.3)])), daemon=True)
    asking.start()
    asking.join(0.2)
    assert asking.is_alive(), "it waits"
    guard.stop()
    asking.join(60)
    assert [hindrance.reason for hindrance in found if hindrance is not None] == ["room_restless"]


def test_law_11_while_a_step_runs_the_robot_does_not_count_as_at_rest(in_room: InRoom) -> None:
    guard, room = in_room("ann")
    homed(guard)
    wait_for(lambda: room.at_rest)
    during: list[bool] = []
    assert guard.step(move(0.3), lambda _: during.append(room.at_rest)).ok
    assert during
    assert not any(during)
    wait_for(lambda: room.at_rest)


def test_a_robot_that_shares_no_room_has_no_zone_to_wait_for(make: Callable[..., Guard]) -> None:
    guard = make()
    assert guard.enter_room([move(0.3)]) is None
    guard.leave_room()


def test_law_11_a_closed_guard_reports_to_its_room_no_more(in_room: InRoom) -> None:
    before = set(threading.enumerate())
    guard, _ = in_room("ann")
    (reporting,) = (t for t in set(threading.enumerate()) - before if t.name == "room")
    guard.close()
    reporting.join(60)
    assert not reporting.is_alive()


def test_law_11_after_a_jump_of_the_odometry_the_place_in_the_room_is_unknown(in_room: InRoom) -> None:
    guard, room = in_room("ann", simulated=False, home_on_start=False)
    set_home(guard)
    assert room.framed
    fake_of(guard).carry(Pose(5.0, 0.0, 0.0))
    wait_for(lambda: not room.framed)
    assert not guard.state().homed
