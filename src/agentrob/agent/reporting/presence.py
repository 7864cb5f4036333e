"""Publish the state of a robot on its page, and reset a simulated room."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import asdict
from typing import Any

import httpx2
import structlog

from agentrob.agent.media.geometry import Geometry
from agentrob.agent.media.poses import has_moved
from agentrob.agent.media.room_map import RoomMap
from agentrob.agent.reporting.activity import AgentActivity
from agentrob.agent.stop.owner import OwnerActions
from agentrob.config.robots import RobotConfig
from agentrob.errors import ForumError, RobotError
from agentrob.forums.protocol import RobotPages
from agentrob.model import Capabilities, Lock, Pose, RobotState
from agentrob.model.operations.data import as_data
from agentrob.process.tls import tls
from agentrob.robots.driver.client import DriverClient

#: How often the robot is asked for its state: while it works or its card changes, and otherwise.
LOOK_S, IDLE_LOOK_S = 1.0, 2.0
#: Changes within this time are published together.
DEBOUNCE_S = 0.1
#: How many waiting commands are listed.
LINE = 20
REFRESH_S = 5.0
#: How often the driver is asked for the robot's limits, which change only with the driver's process.
LIMITS_S = 30.0
#: How often the driver is asked where a robot that stands still is in its room: its home may have been set.
PLACE_S = 30.0
#: After a reset the odometry jumps, so the guard accepts a new home only after a moment.
HOME_TRIES, HOME_WAIT_S = 10, 0.3
_log = structlog.get_logger()


class Presence:
    """Publishes a card every five seconds and on changes. `waiting` returns the queued commands' posts in order, `sees`
    are the things that the robot's detector knows, `scheduled` returns what the card says of schedules, `room_entry`
    for whom the robot waits in its room."""

    def __init__(
        self,
        pages: RobotPages,
        driver: DriverClient,
        name: str,
        settings: RobotConfig,
        waiting: Callable[[], Sequence[str]],
        owner: OwnerActions | None = None,
        activity: AgentActivity | None = None,
        room: RoomMap | None = None,
        geometry: Geometry | None = None,
        sees: Collection[str] = (),
        scheduled: Callable[[], dict[str, Any]] = dict,
        room_entry: Callable[[], dict[str, Any]] = dict,
    ) -> None:
        self._pages = pages
        self._driver = driver
        self._name = name
        self._settings = settings
        self._waiting = waiting
        self._owner = owner
        self._activity = activity
        self._room, self._geometry = room, geometry
        self._sees = sorted(sees)
        self._scheduled, self._room_entry = scheduled, room_entry
        self._stands: Pose | None = None
        self._odometry: Pose | None = None
        self._placed_s = -math.inf
        self._changed = asyncio.Event()
        self._capabilities: Capabilities | None = None
        self._asked_s = -math.inf

    def changed(self) -> None:
        """Publish soon, without waiting for the next look."""
        self._changed.set()

    async def run(self) -> None:
        """Publish until cancelled. If the forum does not answer, try again a second later."""
        shown: dict[str, Any] | None = None
        shown_s = -float("inf")
        while True:
            self._changed.clear()
            card = await self.card()
            look_s = LOOK_S if card != shown or self._waiting() else IDLE_LOOK_S
            if card != shown or time.monotonic() - shown_s >= REFRESH_S:
                try:
                    await self._pages.publish_robot(self._name, card)
                    shown, shown_s = card, time.monotonic()
                except ForumError as e:
                    _log.info("robot card not shown", robot=self._name, error=str(e))
            try:
                async with asyncio.timeout(look_s):
                    await self._changed.wait()
                await asyncio.sleep(DEBOUNCE_S)
            except TimeoutError:
                continue

    async def card(self) -> dict[str, Any]:
        """Return the current card; a robot whose driver does not answer is `offline`."""
        try:
            state = await self._driver.state()
            await self._note_pose(state)
            if self._capabilities is None or time.monotonic() - self._asked_s >= LIMITS_S:
                self._capabilities, self._asked_s = await self._driver.capabilities(), time.monotonic()
        except RobotError:
            self._capabilities = None  # another driver may answer next, with other limits
            return self._card(None, None)
        return self._card(self._capabilities, state)

    async def _note_pose(self, state: RobotState) -> None:
        """Note where it stands in its room. The driver is asked only when its odometry changed, or its home may have; a
        robot that only sways has not moved, so that its card stays the same."""
        if self._room is None or not state.homed or state.pose is None:
            return
        if not has_moved(self._odometry, state.pose) and time.monotonic() - self._placed_s < PLACE_S:
            return
        self._odometry, self._placed_s = state.pose, time.monotonic()
        posture = await self._driver.posture(joints=False)
        if posture.pose is not None and has_moved(self._stands, pose := self._room.in_room(posture.pose)):
            self._stands = pose

    def _map(self) -> dict[str, Any]:
        if self._room is None:
            return {}
        stands = self._stands
        pose = [round(v, 2) for v in (stands.x_m, stands.y_m, stands.yaw_rad)] if stands else None
        shape = self._geometry
        known = {"geometry": shape.name, "no_geometry": shape.missing} if shape else {}
        scene = {"scene": self._settings.scene} if self._settings.map.things else {}
        return {"map": {**self._room.as_data(), **scene, "pose": pose, **known}}

    def _card(self, capabilities: Capabilities | None, state: RobotState | None) -> dict[str, Any]:
        battery = state.battery_percent if state else None
        return {
            "model": capabilities.model if capabilities else self._settings.model,
            "ops": sorted(str(op) for op in capabilities.ops) if capabilities else [],
            "operations": [as_data(operation) for operation in capabilities.declared] if capabilities else [],
            "limits": asdict(capabilities.limits) if capabilities else {},
            "directions": sorted(str(way) for way in capabilities.move_directions) if capabilities else [],
            "state": ("halted" if state.halted else state.mode) if state else "offline",
            "battery_percent": None if battery is None else round(battery),
            "queue": len(waiting := self._waiting()),
            "line": list(waiting[:LINE]),
            "board": self._settings.boards[0] if self._settings.boards else "",
            "boards": list(self._settings.boards),
            "simulated": self._settings.simulated,
            "can_reset": bool(self._settings.room_reset),
            "camera": bool(self._settings.room_camera),
            "sees": self._sees,
            "owner": self._settings.owner,
            "consents": sorted(self._settings.consents),
            "approval": [str(kind) for kind in self._settings.approval.classes],
            "homed": state.homed if state else None,
            "lock": _lock_of(state) if state else None,
            "last_action": self._owner.last_action if self._owner else None,
            **self._map(),
            **self._scheduled(),
            **self._room_entry(),
            **(self._activity.card() if self._activity else {}),
        }


def _lock_of(state: RobotState) -> dict[str, str] | None:
    """Return who locked the robot, why and when, for its card; None if it is not locked."""
    if not state.halted:
        return None
    lock = state.lock or Lock("", "")
    return {"by": lock.by, "why": lock.why, "at": lock.at.isoformat() if lock.at else ""}


async def reset_room(driver: DriverClient, settings: RobotConfig, by: str) -> None:
    """Reset a simulated room and set the robot's home again. Raises `RobotError` if that fails."""
    try:
        async with httpx2.AsyncClient(timeout=10.0, trust_env=False, verify=tls()) as http:
            (await http.post(settings.room_reset)).raise_for_status()
    except (httpx2.HTTPError, httpx2.InvalidURL) as e:
        raise RobotError(f"the room was not reset: {e}") from None
    if not settings.simulated:
        return
    for left in reversed(range(HOME_TRIES)):
        await asyncio.sleep(HOME_WAIT_S)
        try:
            await driver.home(by)
            return
        except RobotError:
            if not left:
                raise
