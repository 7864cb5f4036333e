"""Stops robots through their drivers' host locks: needs no forum, agent, journal, configuration or lease (law 13)."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor

from agentrob.config.robots import RobotConfig
from agentrob.errors import RobotError, RobotUnreachable
from agentrob.model import StopResult
from agentrob.process import host_lock
from agentrob.robots.codec import decode_stop, display_name
from agentrob.robots.driver.process import lock_name

#: A robot may take 3 s to come to rest before its driver answers.
ANSWER_S = 5.0


def stop_robot(name: str, settings: RobotConfig, by: str) -> StopResult:
    """Stop one robot. Raises `RobotUnreachable` if it has no driver or the driver does not answer."""
    return stop_driver(lock_name(name, settings), by)


def halt_robot(name: str, settings: RobotConfig, by: str) -> StopResult:
    """Stop one robot and lock it until its owner releases it. Raises as `stop_robot`."""
    return _tell(lock_name(name, settings), "halt", by)


def stop_driver(lock: str, by: str) -> StopResult:
    """Stop the robot whose driver holds this lock (`driver/lo/1`)."""
    return _tell(lock, "stop", by)


def _tell(lock: str, word: str, by: str) -> StopResult:
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


def stop_all(by: str, among: str = "driver/") -> dict[str, StopResult | RobotUnreachable]:
    """Stop every robot with a driver on this host, in parallel, including other users' robots. The keys of the result
    are the drivers' locks.

    `among` restricts it to locks with this prefix (`driver/lo/`).
    """
    locks = host_lock.held(among)
    if not locks:
        return {}
    with ThreadPoolExecutor(len(locks)) as pool:
        return dict(zip(locks, pool.map(lambda lock: _try(lock, by), locks), strict=True))


def _try(lock: str, by: str) -> StopResult | RobotUnreachable:
    try:
        return stop_driver(lock, by)
    except RobotUnreachable as e:
        return e
