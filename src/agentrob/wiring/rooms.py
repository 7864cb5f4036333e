"""`agentrob room`: who shares a room, who moves or waits there, and the owner's release of a zone."""

from __future__ import annotations

import math
from collections.abc import Iterator

from agentrob.config.load import Config
from agentrob.errors import ConfigError, RobotError
from agentrob.robots.driver.process import zone_keeper
from agentrob.robots.zones.keeper import ZoneKeeper
from agentrob.robots.zones.ledger import RELEASE_S, Other, StillHeard


def lines(room: str, config: Config, release: str | None = None) -> Iterator[str]:
    """The robots of a room, as lines for people; `release` ends the zone of one that its owner has seen at rest.

    Raises `ConfigError` for a room that no robot of the configuration shares, `RobotError` if it cannot be read, or if
    the driver of that robot still answers.
    """
    keeper = _keeper(room, config)
    if release is not None:
        yield _released(keeper, release)
    members, waiting = keeper.members()
    if not members:
        yield f"{room}: no driver has entered this room yet"
    for member in members:
        yield f"{member.robot}: {_state(member, waiting)}"


def _keeper(room: str, config: Config) -> ZoneKeeper:
    shared = {settings.room: settings for settings in config.robots.values() if settings.room}
    if room not in shared:
        known = ", ".join(sorted(shared)) or "none"
        raise ConfigError(f"no robot of the configuration shares the room {room!r}; valid: {known} (robots.NAME.room)")
    return zone_keeper(shared[room], config.data_dir)


def _released(keeper: ZoneKeeper, robot: str) -> str:
    known = [member.robot for member in keeper.members()[0]]
    if robot not in known:
        raise ConfigError(f"{robot!r} is not in this room; valid: {', '.join(known) or 'nobody'}")
    try:
        lease = keeper.release(robot)
    except StillHeard:
        raise RobotError(
            f"the driver of {robot} was heard in the last {RELEASE_S:g} s: it gives its zone back by itself once the "
            f"robot is at rest; stop the robot (agentrob stop {robot}), or end its driver first"
        ) from None
    return f"{robot}: {'it held no zone' if lease is None else 'its zone is free'}, and where it stands is forgotten"


def _state(member: Other, waiting: list[str]) -> str:
    place = member.place.pose
    where = "place unknown, so it needs the whole room"
    if place is not None:
        where = f"x {place.x_m:.2f} m, y {place.y_m:.2f} m, {math.degrees(place.yaw_rad):.0f}°"
    doing = f"holds a zone ({member.doing})" if member.moving else "at rest"
    if member.robot in waiting:
        doing = f"waits, number {waiting.index(member.robot) + 1}"
    heard = f"heard {member.silent_s:.0f} s ago" if math.isfinite(member.silent_s) else "not heard since a restart"
    return f"{doing}; {where}; {heard}"
