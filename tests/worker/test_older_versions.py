"""Drivers and workers of two versions: the driver's API of version 0.1, which had no fencing numbers and no clock."""

from __future__ import annotations

import socket
import threading
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from typing import Any

import httpx2
import pytest
from starlette.applications import Starlette
from starlette.routing import Route

from agentrob.errors import RobotError
from agentrob.model import Direction, FencingToken, Op, Primitive
from agentrob.process.http_server import HttpServer
from agentrob.robots.codec import encode
from agentrob.robots.driver.api import app
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.driver import Driver
from agentrob.robots.driver.process import listening, make_robot
from agentrob.robots.safety.crash_marker import CrashMarker
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt
from tests.agent.agent_scene import ROBOT, robot_settings
from tests.waiting import until

NEAR = Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.3)
#: Routes that version 0.1 did not have.
NEW_ROUTES = {"/clock", "/fence", "/pose", "/room"}


@contextmanager
def serving(api: Starlette, listener: socket.socket) -> Iterator[None]:
    server = HttpServer(api, handle_signals=False, lifespan="off", ws="none", timeout_graceful_shutdown=None)
    thread = threading.Thread(target=server.run, args=([listener],), daemon=True)
    thread.start()
    try:
        yield
    finally:
        server.should_exit = True
        thread.join(10)


@pytest.fixture
def driver(short_folder: Path) -> Iterator[Driver]:
    settings = robot_settings()
    marks = Halt(short_folder / "halt"), CrashMarker(short_folder / "step")
    driver = Driver(ROBOT, Guard(make_robot(settings), settings, *marks))
    driver.guard.settle()
    yield driver
    driver.close()


@pytest.fixture
def older_driver(driver: Driver, short_folder: Path) -> Iterator[Path]:
    """The socket of a driver that offers what version 0.1 did."""
    routes = [route for route in app(driver).routes if isinstance(route, Route) and route.path not in NEW_ROUTES]
    assert len(routes) == 11
    with listening(short_folder / "r.sock") as listener, serving(Starlette(routes=routes), listener):
        yield short_folder / "r.sock"


@asynccontextmanager
async def older_client(driver: Driver, folder: Path) -> AsyncIterator[Any]:
    """The requests of a client of version 0.1 to a driver of this version."""
    with listening(folder / "r.sock") as listener, serving(app(driver), listener):
        transport = httpx2.AsyncHTTPTransport(uds=str(folder / "r.sock"))
        async with httpx2.AsyncClient(transport=transport, base_url="http://driver") as http:

            async def ask(method: str, path: str, body: Any = None) -> Any:
                return (await http.request(method, path, json=body)).raise_for_status().json()

            yield ask


async def test_a_client_of_version_0_1_moves_and_stops_the_robot(driver: Driver, short_folder: Path) -> None:
    async with older_client(driver, short_folder) as ask:
        await until(lambda: ask("GET", "/state"), lambda state: state["homed"])
        assert "x_m" in (await ask("POST", "/home", {"by": "ann"}))["home"]
        lease = (await ask("POST", "/lease", {"holder": "agent t1", "since_s": None}))["lease"]
        step = {"lease": lease, "primitive": encode(NEAR), "deadline_s": 20.0}
        assert (await ask("POST", "/step", step))["outcome"] == "done"
        await ask("PUT", f"/lease/{lease}")
        assert (await ask("POST", "/stop", {"by": "ann", "running_only": False}))["confirmed"]
        assert (await ask("POST", "/halt", {"by": "ann"}))["confirmed"]
        assert (await ask("POST", "/release", {"by": "ann", "since_s": None}))["released"]
        await ask("DELETE", f"/lease/{lease}")


async def test_a_driver_of_version_0_1_is_moved_by_the_only_worker_of_a_robot(older_driver: Path) -> None:
    async with DriverClient(ROBOT, older_driver) as robot:
        async with robot.lease("agent t1") as lease:
            assert (await robot.step(lease, NEAR, 20)).ok
        assert (await robot.stop("ann")).confirmed


async def test_law_11_a_worker_that_shares_its_robots_refuses_a_driver_without_fencing_numbers(
    older_driver: Path,
) -> None:
    async with DriverClient(ROBOT, older_driver) as robot:
        with pytest.raises(RobotError, match=r"older version .* upgrade and restart the driver first"):
            await robot.fence(FencingToken("db", 1))
        assert (await robot.stop("ann")).confirmed, "a stop needs no number"
