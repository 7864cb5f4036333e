"""Poses for the viewers of live maps: the planned path of a command comes once, and no viewer misses it."""

from __future__ import annotations

import asyncio
import json
from typing import Any

from starlette.types import Message

from agentrob.board.events.poses import PoseStream, PoseTracker

PLAN = [[0.0, 0.0], [1.0, 0.0]]
LIMIT_S = 30.0


class Viewer:
    """A viewer of one robot, which reads only while `reads` is set."""

    def __init__(self, tracker: PoseTracker) -> None:
        self.reads, self.waits, self.got = asyncio.Event(), asyncio.Event(), asyncio.Condition()
        self.messages: list[dict[str, Any]] = []
        self._left = asyncio.Event()
        stream = PoseStream(tracker, ["quadruped"], False, None, lambda: True, asyncio.Event())
        self._task = asyncio.create_task(stream({"type": "http"}, self._receive, self._send))
        self.reads.set()

    async def _receive(self) -> Message:
        await self._left.wait()
        return {"type": "http.disconnect"}

    async def _send(self, message: Message) -> None:
        if not self.reads.is_set():
            self.waits.set()
            await self.reads.wait()
        for line in message.get("body", b"").decode().splitlines():
            if line.startswith("data: "):
                self.messages.append(json.loads(line.removeprefix("data: ")))
        async with self.got:
            self.got.notify_all()

    async def received(self, key: str, value: object) -> None:
        async with asyncio.timeout(LIMIT_S), self.got:
            await self.got.wait_for(lambda: any(message.get(key) == value for message in self.messages))

    async def leave(self) -> None:
        self._left.set()
        await self._task


def pose(x_m: float, **more: object) -> dict[str, Any]:
    return {"pose": [x_m, 0.0, 0.0], **more}


async def test_a_viewer_that_was_busy_when_a_command_began_gets_its_planned_path_with_the_next_pose() -> None:
    tracker = PoseTracker()
    slow, quick = Viewer(tracker), Viewer(tracker)
    tracker.show("quadruped", pose(0.0))
    for viewer in (slow, quick):
        await viewer.received("pose", [0.0, 0.0, 0.0])
    slow.reads.clear()
    tracker.show("quadruped", pose(0.1))
    await slow.waits.wait()
    tracker.show("quadruped", pose(0.2, plan=PLAN))
    await quick.received("plan", PLAN)
    slow.reads.set()
    await slow.received("pose", [0.1, 0.0, 0.0])
    assert not any(message.get("plan") for message in slow.messages)
    tracker.show("quadruped", pose(0.3))
    await slow.received("plan", PLAN)
    tracker.show("quadruped", pose(0.4))
    await slow.received("pose", [0.4, 0.0, 0.0])
    assert sum(message.get("plan") == PLAN for message in slow.messages) == 1
    for viewer in (slow, quick):
        await viewer.leave()


async def test_a_planned_path_reaches_other_processes_although_a_newer_pose_came_before_it_was_shared() -> None:
    here, there = PoseTracker(), PoseTracker()
    here.show("quadruped", pose(0.0, plan=PLAN))
    here.show("quadruped", pose(0.1))
    there.receive("quadruped", here.shared("quadruped"))
    assert there.robot("quadruped").plan == PLAN
    here.show("quadruped", pose(0.2))
    assert "plan" not in json.loads(here.shared("quadruped")), "once is enough"
