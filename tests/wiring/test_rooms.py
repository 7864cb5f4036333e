"""`agentrob room` says who shares a room, and releases the zone of a robot whose driver is silent, only then."""

from __future__ import annotations

from pathlib import Path

import pytest

from agentrob.config.load import Config, parse
from agentrob.errors import AgentRobError, ConfigError
from agentrob.model import Pose
from agentrob.robots.zones.keeper import LocalKeeper, room_file
from agentrob.robots.zones.ledger import Message, Place
from agentrob.wiring import rooms


def configuration(data: Path, **more: object) -> Config:
    return parse({"data": str(data), "robots": {"ann": {"model": "fake", "room": "lab", **more}, "bob": {}}})


def silent_holder(data: Path, age_s: float) -> None:
    """A driver took a zone so long ago, and has been silent since."""
    import time

    from agentrob.robots.safety.crash_marker import boot_id

    room = LocalKeeper(room_file(data, "lab"), boot_id, lambda: time.monotonic() - age_s)
    session = room.hello("ann")
    place = Place(Pose(1, 2, 0), 0.1)
    room.report(Message("ann", session, 1), 0, place, at_rest=True)
    assert room.take(Message("ann", session, 2), place, None, "move").number


def test_the_robots_of_a_room_are_listed_and_a_silent_one_is_released(tmp_path: Path) -> None:
    config = configuration(tmp_path)
    assert list(rooms.lines("lab", config)) == ["lab: no driver has entered this room yet"]
    silent_holder(tmp_path, 60)
    assert list(rooms.lines("lab", config)) == ["ann: holds a zone (move); x 1.00 m, y 2.00 m, 0°; heard 60 s ago"]
    first, second = rooms.lines("lab", config, "ann")
    assert first == "ann: its zone is free, and where it stands is forgotten"
    assert second.startswith("ann: at rest; place unknown")


def test_a_robot_whose_driver_answers_is_not_released(tmp_path: Path) -> None:
    silent_holder(tmp_path, 0)
    with pytest.raises(AgentRobError, match="gives its zone back by itself"):
        list(rooms.lines("lab", configuration(tmp_path), "ann"))
    with pytest.raises(ConfigError, match="valid: ann"):
        list(rooms.lines("lab", configuration(tmp_path), "cid"))


def test_what_belongs_to_a_shared_room_says_what_is_valid(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="valid: lab"):
        list(rooms.lines("hall", configuration(tmp_path)))
    for wrong, says in (
        ({"room": "", "room_url": "https://a:1"}, "set room"),
        ({"room_error_m": 0.1}, "set room = 'lab', home_at_m"),
        ({"room_url": "http://elsewhere:1", "driver_token_env": "TOKEN"}, "room_url must be https"),
        ({"room_url": "https://elsewhere:1"}, "room_url needs driver_token_env"),
    ):
        with pytest.raises(ConfigError, match=says):
            configuration(tmp_path, **wrong)
