"""Stops robots through their drivers' host locks: needs no forum, agent, journal, configuration or lease (law 13). A
robot whose driver runs on another machine is stopped over the network, as its settings say."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial

from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError, RobotError, RobotUnreachable
from agentrob.model import StopResult
from agentrob.process import host_lock
from agentrob.robots.codec import decode_stop, display_name
from agentrob.robots.driver.process import lock_name

#: A robot may take 3 s to come to rest before its driver answers.
ANSWER_S = 5.0


def stop_robot(name: str, settings: RobotConfig, by: str) -> StopResult:
    """Stop one robot. Raises `RobotUnreachable` if it has no driver or the driver does not answer."""
    if settings.driver_url:
        return _send_remote(name, settings, "stop", by)
    return stop_driver(lock_name(name, settings), by)


def halt_robot(name: str, settings: RobotConfig, by: str) -> StopResult:
    """Stop one robot and lock it until its owner releases it. Raises as `stop_robot`."""
    if settings.driver_url:
        return _send_remote(name, settings, "halt", by)
    return _send(lock_name(name, settings), "halt", by)


def stop_driver(lock: str, by: str) -> StopResult:
    """Stop the robot whose driver holds this lock (`driver/lo/1`)."""
    return _send(lock, "stop", by)


def _send(lock: str, word: str, by: str) -> StopResult:
    try:
        with host_lock.connect(lock, ANSWER_S) as s:
            s.sendall(f"{word} {display_name(by)}\n".encode())
            line = s.makefile("r", encoding="utf-8").readline()
    except OSError as e:
        raise RobotUnreachable(f"no driver answers at {lock} ({type(e).__name__}): use the robot's own stop") from None
    try:
        return decode_stop(json.loads(line))
    except (ValueError, RobotError):
        raise RobotUnreachable(f"the driver at {lock} did not confirm ({line.strip()[:100]!r})") from None


def _send_remote(name: str, settings: RobotConfig, word: str, by: str) -> StopResult:
    """Stop a robot over the network, on new connections. Call it from a thread without an event loop."""
    from agentrob.robots.driver.remote import driver_client

    async def stopped() -> StopResult:
        async with driver_client(name, settings) as driver:
            return await (driver.halt(by) if word == "halt" else driver.stop(by))

    try:
        return asyncio.run(stopped())
    except RobotUnreachable:
        raise
    except (ConfigError, RobotError) as e:
        raise RobotUnreachable(f"{e}; use the robot's own stop") from None


def stop_all(
    by: str, among: str = "driver/", remote: Mapping[str, RobotConfig] | None = None
) -> dict[str, StopResult | RobotUnreachable]:
    """Stop every robot with a driver on this host, in parallel, including other users' robots, and the `remote` ones.
    The keys of the result are the drivers' locks, and the names of the remote robots.

    `among` restricts it to locks with this prefix (`driver/lo/`).
    """
    stops = {lock: partial(stop_driver, lock, by) for lock in host_lock.held(among)}
    stops |= {name: partial(stop_robot, name, settings, by) for name, settings in (remote or {}).items()}
    if not stops:
        return {}
    with ThreadPoolExecutor(len(stops)) as pool:
        return dict(zip(stops, pool.map(_try, stops.values()), strict=True))


def _try(stop: Callable[[], StopResult]) -> StopResult | RobotUnreachable:
    try:
        return stop()
    except RobotUnreachable as e:
        return e
