"""The buttons of robots: stop, emergency stop, release, set home, reset; and notifying the agent of viewers."""

from __future__ import annotations

import asyncio
import time
from dataclasses import replace
from datetime import UTC, datetime

import structlog

from agentrob.board.auth import rights
from agentrob.board.db.reader import not_found
from agentrob.board.db.records import StoredEvent, from_us, now_us
from agentrob.board.events import presence
from agentrob.board.events.poses import RobotPoses
from agentrob.board.events.presence import RobotPresence
from agentrob.board.services import Services
from agentrob.errors import BoardError
from agentrob.language.messages.durations import duration
from agentrob.model import Account, AccountKind, EventKind, Role

#: If writing takes longer (locked database, full disk), a stop is announced before it is written (law 15).
TELL_S = 0.05
#: The request for a stop returns after this many seconds, written or not.
WRITE_S = 0.25

log = structlog.get_logger(__name__)


def known_robot(services: Services, name: str) -> Account:
    """The account of a robot's agent. 404 names those that are there."""
    account = services.store.reader.account(name)
    if account is None or account.kind is not AccountKind.ROBOT_AGENT:
        known = ", ".join(a.name for a in services.store.reader.robots()) or "none"
        raise not_found("robot", name, f"valid: {known}")
    return account


async def stop(services: Services, robot: str, by: Account, key: str | None = None) -> StoredEvent:
    """Stop a robot. Every signed-in account may, without a limit, even if the disk cannot be written."""
    name = known_robot(services, robot).name
    return await _record_or_announce(services, EventKind.ROBOT_STOP, name, by, key)


async def emergency_stop(services: Services, robot: str, by: Account, key: str | None = None) -> StoredEvent:
    """Stop a robot and lock it until its owner releases it. Every signed-in account may, as `stop`."""
    name = known_robot(services, robot).name
    return await _record_or_announce(services, EventKind.ROBOT_ESTOP, name, by, key)


async def release(services: Services, robot: str, by: Account, key: str | None = None) -> StoredEvent:
    """Ask a robot's agent to release it. 403 unless the caller is its owner or an admin; the agent checks the right
    again."""
    name = check_owner(services, robot, by)
    return await services.store.record(EventKind.ROBOT_RELEASE, name, by, key=key)


async def home(services: Services, robot: str, by: Account, key: str | None = None) -> StoredEvent:
    """Ask a robot's agent to set its home where it stands. As `release`."""
    name = check_owner(services, robot, by)
    return await services.store.record(EventKind.ROBOT_HOME, name, by, key=key)


def check_owner(services: Services, robot: str, by: Account | None) -> str:
    """The robot's name. 403 if the account may not release it, 404."""
    name = known_robot(services, robot).name
    if not may_release(services, name, by):
        what = "only the robot's owner and admins may release it or set its home"
        raise BoardError(403, "not_owner", what, f"at its machine: agentrob release {name}, agentrob home {name}")
    return name


def may_release(services: Services, robot: str, by: Account | None) -> bool:
    """Whether an account may release this robot and set its home."""
    return rights.releases(rights.settings_of(services.store.reader, robot), by, _configured_owner(services, robot))


def owner_of(services: Services, robot: str) -> str:
    """The owner that this forum stores, else the one that its agent's configuration names, if there is such an
    account."""
    if owner := rights.settings_of(services.store.reader, robot).owner:
        return owner
    configured = _configured_owner(services, robot)
    return configured if configured and services.store.reader.account(configured) is not None else ""


def _configured_owner(services: Services, robot: str) -> str:
    configured = services.presence.robot(robot).card.get("owner")
    return configured.lower() if isinstance(configured, str) else ""


async def reset(services: Services, robot: str, by: Account, key: str | None = None) -> StoredEvent:
    """Reset a simulated room. 403 unless the account may command the robot."""
    name = check_resets(services, robot, by)
    return await services.store.record(EventKind.ROBOT_RESET, name, by, key=key)


def check_resets(services: Services, robot: str, by: Account) -> str:
    """The robot's name. 403 if the account may not reset its room, 404."""
    name = known_robot(services, robot).name
    kept = rights.settings_of(services.store.reader, name)
    by = replace(by, role=by.role_towards(services.presence.robot(name).card.get("simulated") is True))
    if by.role.rank < Role.OPERATOR.rank or not rights.reaches(by, kept.command["move"], kept.owner):
        raise BoardError(403, "not_operator", "only operators may reset the room", "ask an admin for the role operator")
    if (until := kept.closed_until(now := datetime.now(UTC))) is not None:
        left = duration((until - now).total_seconds())
        raise BoardError(403, "closed", f"this robot is in maintenance for another {left}", "come again")
    return name


def check_own_robot(by: Account, name: str) -> None:
    """403 unless the account is the agent of this robot."""
    if by.kind is not AccountKind.ROBOT_AGENT or by.name != name:
        raise BoardError(403, "not_this_robot", f"only the robot agent {name[:64]!r} may do this", "use its token")


def check_camera(services: Services, robot: str, viewer: Account | None) -> None:
    """403 unless the viewer may see pictures of this robot's camera."""
    kept = rights.settings_of(services.store.reader, robot)
    if not rights.sees_camera(kept, viewer, robot):
        what = f"pictures of this robot's camera need the role {kept.camera_role}"
        raise BoardError(403, "camera_role", what, "ask the robot's owner")


def watch(services: Services, robot: str) -> None:
    """Tell the robot's agent that its camera has viewers, at most once in `WATCH_EVERY_S`.

    The event is not stored: reading leaves nothing in the database. An agent that misses it gets it again when it next
    publishes its card.
    """
    _notify_agent_soon(services, services.presence.robot(robot), EventKind.ROBOT_WATCH)


def watch_poses(services: Services, robot: str) -> None:
    """Tell the robot's agent that its map has viewers, as `watch`."""
    _notify_agent_soon(services, services.presence.poses.robot(robot), EventKind.ROBOT_POSES)


def _notify_agent_soon(services: Services, now: RobotPresence | RobotPoses, kind: EventKind) -> None:
    wait_s = now.called_s + presence.WATCH_EVERY_S - time.monotonic()
    if wait_s <= 0:
        _notify_agent(services, now, kind)
    elif now.call is None:
        now.call = asyncio.get_running_loop().call_later(wait_s, _notify_agent_again, services, now, kind)


def _notify_agent(services: Services, now: RobotPresence | RobotPoses, kind: EventKind) -> None:
    if now.call is not None:  # its timer is late
        now.call.cancel()
        now.call = None
    now.called_s = time.monotonic()
    services.hub.announce(StoredEvent(services.hub.last_id, kind, from_us(now_us()), robot=now.name))


def _notify_agent_again(services: Services, now: RobotPresence | RobotPoses, kind: EventKind) -> None:
    now.call = None  # this timer
    if now.watched:
        _notify_agent(services, now, kind)


async def _record_or_announce(
    services: Services, kind: EventKind, robot: str, by: Account | None, key: str | None
) -> StoredEvent:
    at_us = now_us()
    writing = asyncio.ensure_future(services.store.record(kind, robot, by, key=key, at_us=at_us))
    try:
        async with asyncio.timeout(TELL_S):
            return await asyncio.shield(writing)
    except (TimeoutError, BoardError):
        event = StoredEvent(services.hub.last_id, kind, from_us(at_us), robot=robot, account=by)
        services.hub.announce(event)
    try:
        async with asyncio.timeout(WRITE_S - TELL_S):
            return await asyncio.shield(writing)
    except (TimeoutError, BoardError) as e:
        log.error("board.event_not_written", kind=str(kind), robot=robot, error=str(e) or "timeout")
        writing.add_done_callback(lambda task: task.cancelled() or task.exception())
        return event
