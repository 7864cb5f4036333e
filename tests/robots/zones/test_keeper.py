"""A room in a file: shared by drivers, kept over crashes and restarts, and refused when it cannot be read."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest

from agentrob.errors import RobotError, RobotUnreachable
from agentrob.model import Pose
from agentrob.robots.zones.area import Capsule
from agentrob.robots.zones.keeper import LocalKeeper, room_file
from agentrob.robots.zones.ledger import LeaseGone, Message, OldSession, Place

PLACE = Place(Pose(1, 2, 0.5), 0.1)
AREA = (Capsule(0, 0, 1, 0, 0.5),)


def keeper(path: Path, boot: str = "one", now_s: float = 10.0) -> LocalKeeper:
    return LocalKeeper(path, lambda: boot, lambda: now_s)


def take(room: LocalKeeper, robot: str) -> int:
    session = room.hello(robot)
    room.report(Message(robot, session, 1), 0, PLACE, at_rest=True)
    return room.take(Message(robot, session, 2), PLACE, AREA, "move").number


def test_what_one_driver_took_holds_for_all_also_after_its_death_and_a_restart_of_the_host(tmp_path: Path) -> None:
    path = room_file(tmp_path, "lab")
    take(keeper(path), "ann")  # and it is killed: nothing is given back
    room = keeper(path, boot="two", now_s=1.0)
    session = room.hello("bob")
    room.report(Message("bob", session, 1), 0, Place(), at_rest=True)
    answer = room.take(Message("bob", session, 2), Place(), None, "move")
    assert (answer.reason, answer.robot) == ("room_busy", "ann")
    (ann, bob), waiting = room.members()
    assert (ann.place, ann.moving, bob.moving, waiting) == (PLACE, True, False, ["bob"])
    released = room.release("ann")
    assert released is not None
    assert released.area == AREA
    assert room.take(Message("bob", session, 3), Place(), None, "move").number


def test_what_a_refused_message_noted_counts(tmp_path: Path) -> None:
    room = keeper(tmp_path / "lab.sqlite")
    session = room.hello("ann")
    with pytest.raises(LeaseGone):
        room.report(Message("ann", session, 5), 99, PLACE, at_rest=False)
    with pytest.raises(OldSession):
        room.report(Message("ann", session, 5), 0, PLACE, at_rest=True)
    (ann,), _ = room.members()
    assert ann.place == PLACE


def test_a_file_that_cannot_be_read_or_written_gives_nobody_a_zone(tmp_path: Path) -> None:
    path = tmp_path / "lab.sqlite"
    assert take(keeper(path), "ann")
    with sqlite3.connect(path) as db:
        db.execute('update room set ledger = \'{"counter": "many"}\'')
    db.close()
    with pytest.raises(RobotUnreachable, match="see that every robot of the room is at rest"):
        keeper(path).hello("bob")
    other = tmp_path / "other.sqlite"
    other.write_bytes(b"no database" * 500)
    with pytest.raises(RobotUnreachable, match="cannot be used"):
        keeper(other).hello("bob")
    (tmp_path / "file").write_text("")
    with pytest.raises(RobotUnreachable, match="cannot be used"):
        keeper(tmp_path / "file" / "lab.sqlite").hello("bob")


def test_a_busy_file_is_waited_for_but_not_for_long(tmp_path: Path) -> None:
    path = tmp_path / "lab.sqlite"
    room = keeper(path)
    room.hello("ann")
    blocker = sqlite3.connect(path, isolation_level=None)
    blocker.execute("begin immediate")
    with pytest.raises(RobotUnreachable, match="locked"):
        room.hello("ann")
    blocker.execute("rollback")
    blocker.close()
    assert room.hello("ann")


def test_a_file_that_was_removed_is_made_anew(tmp_path: Path) -> None:
    path = tmp_path / "lab.sqlite"
    room = keeper(path)
    assert take(room, "ann")
    for part in tmp_path.glob("lab.sqlite*"):
        part.unlink()
    with pytest.raises(RobotUnreachable):
        room.hello("bob")
    assert room.hello("bob") == 1


@pytest.mark.parametrize("name", ["", "../lab", "a/b", ".hidden", "a\nb"])
def test_a_room_is_a_name_and_no_path(tmp_path: Path, name: str) -> None:
    with pytest.raises(RobotError, match="not a room's name"):
        room_file(tmp_path, name)
