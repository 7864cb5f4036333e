"""The driver's HTTP API on its Unix socket, as specified in docs/reference/interfaces.md."""

from __future__ import annotations

import asyncio
import logging
import math
import socket
import threading
import time
from collections import OrderedDict
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any, NamedTuple, TypeVar

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from agentrob.errors import Fenced, LeaseLost, RobotBusy, RobotError
from agentrob.model import FencingToken, StopResult
from agentrob.process.http_server import HttpServer
from agentrob.robots.codec import decode_primitive, display_name, encode
from agentrob.robots.driver.driver import Driver
from agentrob.robots.safety.crash_marker import boot_id
from agentrob.robots.zones.http import zone_routes

T = TypeVar("T")
log = logging.getLogger(__name__)
Answer = Callable[[Request], Awaitable[Response]]
STORE_CHARACTERS = 200
STOP_ID_CHARACTERS = 64
#: The most steps of a request for a zone.
MOST_STEPS = 100
#: Ids of stops that are remembered, so that none is done twice.
STOPS_REMEMBERED = 256


async def run_in_thread(work: Callable[[], T]) -> T:
    """Run blocking work on a thread of its own: no pool, so that a stop never waits for a free worker."""
    loop = asyncio.get_running_loop()
    future: asyncio.Future[T] = loop.create_future()

    def settle(result: T | None, error: BaseException | None) -> None:
        if not future.done():
            future.set_exception(error) if error else future.set_result(result)  # type: ignore[arg-type]

    def run() -> None:
        result, error = None, None
        try:
            result = work()
        except BaseException as e:
            error = e
        if not loop.is_closed():
            loop.call_soon_threadsafe(settle, result, error)

    threading.Thread(target=run, daemon=True).start()
    return await future


def _problem(status: int, code: str, message: str, **more: str) -> JSONResponse:
    return JSONResponse({"status": status, "code": code, "detail": message, **more}, status)


async def _body(request: Request) -> dict[str, Any]:
    try:
        data = await request.json()
    except ValueError:
        raise RobotError("the body must be a JSON object") from None
    if not isinstance(data, dict):
        raise RobotError("the body must be a JSON object")
    return data


def _text(data: dict[str, Any], key: str) -> str:
    value = data.get(key)
    if not isinstance(value, str) or not (text := display_name(value)):
        raise RobotError(f"{key!r} must be a non-empty string")
    return text


def _since(data: dict[str, Any]) -> float | None:
    """Read `since_s`; a time in the future is rejected, since no stop could be later than it."""
    since_s = data.get("since_s")
    if since_s is None:
        return None
    if isinstance(since_s, bool) or not isinstance(since_s, int | float) or not since_s <= time.monotonic():
        raise RobotError("'since_s' must be a time of this host's CLOCK_MONOTONIC that is not in the future")
    return float(since_s)


def _sent(data: dict[str, Any]) -> float:
    """Read `sent_s`, when a renewal was sent; without it, now. A client's estimate may be slightly in the future."""
    sent_s = data.get("sent_s", math.inf)
    if isinstance(sent_s, bool) or not isinstance(sent_s, int | float) or math.isnan(sent_s):
        raise RobotError("'sent_s' must be a time of this host's CLOCK_MONOTONIC")
    return float(sent_s)


def _fence(data: Any) -> FencingToken:
    store, number = (data.get("store"), data.get("number")) if isinstance(data, dict) else (None, None)
    if not isinstance(store, str) or not 0 < len(store) <= STORE_CHARACTERS or not store.isprintable():
        raise RobotError(f"'store' must name the journal's database in 1 to {STORE_CHARACTERS} printable characters")
    if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number < 2**63:
        raise RobotError("'number' must be a whole number from 0")
    return FencingToken(store, number)


def _check_boot(data: dict[str, Any]) -> None:
    """Raise `_OtherBoot` if the client converted `since_s` to the clock of an earlier boot of this host."""
    if data.get("boot") not in (None, boot_id()):
        raise _OtherBoot("this host was restarted since its clock was read; read it again: GET /clock")


class _OtherBoot(RobotError):
    pass


class _StopRequest(NamedTuple):
    """Who stops, and whether only the running command; by default, everything. The same `id` stops once."""

    by: str = "an unnamed caller"
    running_only: bool = False
    id: str = ""


async def _stop_request(request: Request) -> _StopRequest:
    """The content of a stop request. A stop without valid content is accepted, too."""
    try:
        data = await _body(request)
        id = data.get("id")
        given = id if isinstance(id, str) and len(id) <= STOP_ID_CHARACTERS else ""
        return _StopRequest(_text(data, "by"), data.get("running_only") is True, given)
    except RobotError:
        return _StopRequest()


def app(driver: Driver, *, remote: bool = False) -> Starlette:
    """The routes of one driver. For clients over the network (`remote`), a robot that workers share by fencing numbers
    is leased only with one: such a client may be a worker that lost the robot and does not know it."""
    handlers = _Handlers(driver, remote)
    routes = (
        ("/capabilities", "GET", handlers.capabilities),
        ("/clock", "GET", handlers.clock),
        ("/state", "GET", handlers.state),
        ("/pose", "GET", handlers.posture),
        ("/look", "GET", handlers.look),
        ("/fence", "POST", handlers.fence),
        ("/lease", "POST", handlers.take),
        ("/lease/{lease}", "PUT", handlers.renew),
        ("/lease/{lease}", "DELETE", handlers.give_back),
        ("/room", "POST", handlers.enter_room),
        ("/step", "POST", handlers.step),
        ("/stop", "POST", handlers.stop),
        ("/halt", "POST", handlers.halt),
        ("/release", "POST", handlers.release),
        ("/home", "POST", handlers.home),
    )
    zones = [] if driver.kept is None else zone_routes(*driver.kept)
    ours = [Route(path, _translated(answer), methods=[method]) for path, method, answer in routes]
    return Starlette(routes=[*ours, *zones])


class _Handlers:
    """One method per route."""

    def __init__(self, driver: Driver, remote: bool) -> None:
        self.driver, self.remote = driver, remote
        self._stops = OrderedDict[str, asyncio.Future[StopResult]]()

    async def capabilities(self, _: Request) -> JSONResponse:
        return JSONResponse(encode(self.driver.guard.capabilities))

    async def clock(self, _: Request) -> JSONResponse:
        return JSONResponse({"now_s": time.monotonic(), "boot": boot_id()})

    async def state(self, _: Request) -> JSONResponse:
        holder = self.driver.leases.holder
        lease = None if holder is None else {"holder": holder}
        return JSONResponse({**encode(self.driver.state()), "lease": lease, "busy": self.driver.busy})

    async def posture(self, request: Request) -> JSONResponse:
        return JSONResponse(encode(self.driver.posture(joints=request.query_params.get("joints") != "0")))

    async def look(self, _: Request) -> Response:
        return Response(await run_in_thread(self.driver.look), media_type="image/jpeg")

    # ------------------------------------------------------------------ who may move it
    async def fence(self, request: Request) -> JSONResponse:
        fence = _fence(await _body(request))
        await run_in_thread(lambda: self.driver.fence(fence))
        return JSONResponse({})

    async def take(self, request: Request) -> JSONResponse:
        data = await _body(request)
        _check_boot(data)
        holder, since_s = _text(data, "holder"), _since(data)
        fence = None if data.get("fence") is None else _fence(data["fence"])
        if fence is None and self.remote and self.driver.leases.numbers.known:
            raise Fenced(
                "workers share this robot by fencing numbers, so over the network a lease needs one; use the driver's "
                "Unix socket on its own machine"
            )
        lease = await run_in_thread(lambda: self.driver.take(holder, since_s, fence))
        return JSONResponse({"lease": lease, "ttl_s": self.driver.leases.ttl_s})

    async def renew(self, request: Request) -> JSONResponse:
        data = await _body(request) if await request.body() else {}
        _check_boot(data)
        self.driver.leases.renew(request.path_params["lease"], _sent(data))
        return JSONResponse({"ttl_s": self.driver.leases.ttl_s})

    async def give_back(self, request: Request) -> JSONResponse:
        self.driver.give_back(request.path_params["lease"])
        return JSONResponse({})

    # ------------------------------------------------------------------ motion and stop
    async def enter_room(self, request: Request) -> JSONResponse:
        data = await _body(request)
        steps = data.get("steps")
        if not isinstance(steps, list) or len(steps) > MOST_STEPS:
            raise RobotError(f"'steps' must be a list of at most {MOST_STEPS} steps")
        plan = [decode_primitive(step) for step in steps]
        hindrance = await run_in_thread(lambda: self.driver.enter_room(plan))
        return JSONResponse({"hindrance": None if hindrance is None else encode(hindrance)})

    async def step(self, request: Request) -> JSONResponse:
        data = await _body(request)
        lease, primitive = _text(data, "lease"), decode_primitive(data.get("primitive"))
        deadline_s = data.get("deadline_s")
        if not isinstance(deadline_s, int | float) or not math.isfinite(deadline_s):
            raise RobotError("'deadline_s' must be a number of seconds")
        stepping = asyncio.ensure_future(run_in_thread(lambda: self.driver.step(lease, primitive, deadline_s)))
        disconnected = asyncio.ensure_future(request.receive())  # next message: end of connection
        try:
            await asyncio.wait({stepping, disconnected}, return_when=asyncio.FIRST_COMPLETED)
            if not stepping.done():  # the client disconnected: end its step before the lease lapses
                self.driver.give_back(lease)
            return JSONResponse(encode(await stepping))
        finally:
            disconnected.cancel()

    async def stop(self, request: Request) -> JSONResponse:
        asked_s = time.monotonic()
        asked = await _stop_request(request)
        stop = partial(self.driver.stop, asked.by, asked_s, running_only=asked.running_only)
        return JSONResponse(encode(await self._once(asked.id, stop)))

    async def halt(self, request: Request) -> JSONResponse:
        asked = await _stop_request(request)
        return JSONResponse(encode(await self._once(asked.id, lambda: self.driver.halt(asked.by))))

    async def _once(self, id: str, stop: Callable[[], StopResult]) -> StopResult:
        """Stop, unless it was asked for under this id before: a client may send each stop on two connections."""
        if not id:
            return await run_in_thread(stop)
        if id not in self._stops:
            self._stops[id] = asyncio.ensure_future(run_in_thread(stop))
            if len(self._stops) > STOPS_REMEMBERED:
                self._stops.popitem(last=False)
        return await asyncio.shield(self._stops[id])

    # ------------------------------------------------------------------ the owner's
    async def release(self, request: Request) -> JSONResponse:
        data = await _body(request)
        _check_boot(data)
        by, since_s = _text(data, "by"), _since(data)
        lock = await run_in_thread(lambda: self.driver.release(by, math.inf if since_s is None else since_s))
        return JSONResponse({"released": None if lock is None else encode(lock)})

    async def home(self, request: Request) -> JSONResponse:
        by = _text(await _body(request), "by")
        return JSONResponse({"home": encode(await run_in_thread(lambda: self.driver.home(by)))})


def _translated(answer: Answer) -> Answer:
    """Translate our errors to HTTP: 409 without the robot (`lease_lost`, `fenced`, `busy`), 422 if invalid."""

    async def translated(request: Request) -> Response:
        try:
            return await answer(request)
        except LeaseLost as e:
            return _problem(409, "lease_lost", str(e), why=e.why, by=e.by)
        except Fenced as e:
            return _problem(409, "fenced", str(e))
        except _OtherBoot as e:
            return _problem(409, "other_boot", str(e))
        except RobotBusy as e:
            return _problem(409, "busy", str(e))
        except RobotError as e:
            return _problem(422, "invalid", str(e))

    return translated


class DriverServer:
    """Serves a driver on a listening socket, in a thread, while the context is open."""

    def __init__(self, driver: Driver, listener: socket.socket) -> None:
        self._server = HttpServer(
            app(driver), handle_signals=False, lifespan="off", ws="none", timeout_graceful_shutdown=None
        )
        self._thread = threading.Thread(target=self._server.run, args=([listener],), name="service", daemon=True)

    def __enter__(self) -> DriverServer:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._server.should_exit = True
        self._thread.join(0.3)
