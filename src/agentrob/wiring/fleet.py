"""Read the state of all robots from the configured forum, and show it in a table."""

from __future__ import annotations

import asyncio
from datetime import datetime
from typing import TYPE_CHECKING

from agentrob.config.load import Config
from agentrob.errors import ConfigError
from agentrob.forums.protocol import Fleet
from agentrob.model import FleetRobot
from agentrob.wiring import app

if TYPE_CHECKING:
    from rich.table import Table


def read_fleet(config: Config) -> tuple[FleetRobot, ...]:
    """All robots of the forum, by name. Raises `ConfigError` if the forum keeps no cards, `ForumError` if it does not
    answer."""

    async def read() -> tuple[FleetRobot, ...]:
        forum = app.make_forum(config, _token(config))
        try:
            if not isinstance(forum, Fleet):
                raise ConfigError(f"a forum of the kind {config.forum.kind!r} does not list its robots")
            return await forum.fleet()
        finally:
            await forum.close()

    return asyncio.run(read())


def _token(config: Config) -> str:
    """The common token, or that of a robot: all may read."""
    for robot in ("", *config.robots):
        try:
            return app.secret(config, robot)
        except ConfigError as e:
            error = e
    raise error


def table(robots: tuple[FleetRobot, ...], now: datetime) -> Table:
    """The robots as a table for a terminal."""
    from rich.table import Table
    from rich.text import Text

    made = Table("robot", "worker", "version", "state", "lag", "queue", "battery", "last stop", "failures", "seen")
    for robot in robots:
        stop_s = (now - robot.stop_at).total_seconds() if robot.stop_at else None
        stop = "" if stop_s is None else f"{_number(robot.stop_ms, ' ms') or 'not reached'}, {ago(stop_s)}"
        failures = ", ".join(f"{kind} {count}" for kind, count in robot.failures)
        state = Text(robot.state_label, style="" if robot.served else "bold red")
        numbers = _number(robot.lag_ms, " ms"), _number(robot.queue), _number(robot.battery_percent, " %")
        # As `Text`, since a card may contain the markup of rich.
        texts = (robot.name, robot.worker, robot.version, state, *numbers, stop, failures, ago(robot.age_s))
        made.add_row(*(Text(cell) if isinstance(cell, str) else cell for cell in texts))
    return made


def ago(seconds: float | None) -> str:
    """A duration since something happened, in its largest unit."""
    if seconds is None:
        return "never"
    for unit, length_s in (("d", 86400), ("h", 3600), ("min", 60)):
        if seconds >= length_s:
            return f"{seconds / length_s:.0f} {unit} ago"
    return f"{max(0.0, seconds):.0f} s ago"


def _number(value: float | None, unit: str = "") -> str:
    return "" if value is None else f"{value:.0f}{unit}"
