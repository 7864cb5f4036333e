"""An agent waits for the room that its robot shares, says for whom, and never counts the wait as the command's time."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

import pytest

from agentrob.agent.execution.room_entry import RoomEntry
from agentrob.agent.reporting.room_text import on_card, waits_for_room, who_does
from agentrob.model import Direction, Hindrance, Op, Primitive

WALK = (Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0),)
BUSY = Hindrance("room_busy", "taken", "humanoid", "move")
BLOCKED = Hindrance("room_blocked", "humanoid stands in the way.", "humanoid")


class Room:
    """A driver that answers in this order, and then lets the robot in."""

    def __init__(self, *answers: Hindrance | None) -> None:
        self.answers, self.asked = list(answers), 0

    async def enter_room(self, steps: Sequence[Primitive]) -> Hindrance | None:
        assert tuple(steps) == WALK
        self.asked += 1
        return self.answers.pop(0) if self.answers else None


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agentrob.agent.execution.room_entry.ASK_S", 0.001)


async def test_it_waits_while_that_helps_and_tells_each_reason_once() -> None:
    queued = Hindrance("room_busy", "taken", "dog", "wait")
    room, told, cards = Room(BUSY, BUSY, queued), list[Hindrance](), list[object]()
    entry = RoomEntry(room, True, lambda: cards.append(on_card(entry.awaited)))  # type: ignore[arg-type]
    assert await entry.enter(WALK, told.append) is None
    assert told == [BUSY, queued]
    assert cards == [
        {"waits_for_the_room": "@humanoid walks"}, {"waits_for_the_room": "@dog moves first"}, {}
    ]  # fmt: skip


async def test_it_does_not_wait_for_what_stands_in_the_way_nor_longer_than_it_may() -> None:
    told = list[Hindrance]()
    assert await RoomEntry(Room(BLOCKED), True).enter(WALK, told.append) is BLOCKED  # type: ignore[arg-type]
    assert await RoomEntry(Room(BUSY), True).enter(WALK, told.append, limit_s=0.0) is BUSY  # type: ignore[arg-type]
    assert told == []


async def test_an_end_of_the_command_ends_the_wait() -> None:
    room, ended = Room(*[BUSY] * 100_000), asyncio.Event()
    entry = RoomEntry(room, True)  # type: ignore[arg-type]
    waiting = asyncio.create_task(entry.enter(WALK, lambda _: ended.set(), ended.is_set))
    async with asyncio.timeout(60):
        assert await waiting is None
    assert entry.awaited is None


async def test_who_shares_no_room_and_what_does_not_move_asks_nobody() -> None:
    room = Room(BUSY)
    assert await RoomEntry(room, False).enter(WALK, lambda _: None) is None  # type: ignore[arg-type]
    photo = (Primitive(Op.GET_FRONT_IMAGE),)
    assert await RoomEntry(room, True).enter(photo, lambda _: None) is None  # type: ignore[arg-type]
    assert room.asked == 0


def test_it_is_said_for_whom_and_when_a_driver_is_silent() -> None:
    assert waits_for_room(BUSY, "en") == "Waits for the room: @humanoid walks."
    assert waits_for_room(BUSY, "zh") == "等待房间：@humanoid 正在行走。"
    wave = Hindrance("room_busy", "", "humanoid", "hello")
    assert who_does(wave, "en") == "@humanoid moves"
    silent = waits_for_room(Hindrance("room_busy", "", "humanoid", "move", 60.0), "en")
    assert "Its driver has been silent for 1 minute" in silent
    assert "`--release humanoid`" in silent
    assert "silent for an unknown time" in waits_for_room(Hindrance("room_busy", "", "dog", "move", float("inf")), "en")
