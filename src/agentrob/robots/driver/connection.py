"""HTTP from a client to a driver: over the Unix socket, or over the network on connections that are kept open."""

from __future__ import annotations

import asyncio
import contextlib
import math
import secrets
import socket
import ssl
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx2

from agentrob.errors import Fenced, LeaseLost, RobotBusy, RobotError, RobotUnreachable
from agentrob.robots.codec import display_name
from agentrob.robots.driver.clock import DriverClock

CALL_S = 5.0
#: Connections that are kept open over the network: for stops, for the lease, and for everything else.
STOP_CONNECTIONS, LEASE_CONNECTIONS = 3, 4
#: One that was not used for this long is used to measure the driver's clock …
KEEP_S = 5.0
#: … with this limit: a connection that does not answer is replaced.
PROBE_S = 3.0
#: A connection that was idle for longer is closed.
IDLE_S = 30.0
#: A connection whose host has not answered the kernel for about 10 s is closed, also while a step is waited for.
_ALIVE = (
    (socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1),
    (socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, 2),
    (socket.IPPROTO_TCP, socket.TCP_KEEPINTVL, 2),
    (socket.IPPROTO_TCP, socket.TCP_KEEPCNT, 4),
)
_NETWORK_ERRORS = (httpx2.TransportError, OSError)


class OtherBoot(RobotError):
    """The driver's host was restarted since its clock was measured."""


_ERRORS = {"busy": RobotBusy, "fenced": Fenced, "other_boot": OtherBoot, "bad_token": RobotUnreachable}


@dataclass(frozen=True)
class DriverAddress:
    """Where a driver listens: a Unix socket of this machine, or a URL with a TLS context and perhaps a token."""

    socket: Path | None = None
    url: str = "http://driver"
    tls: ssl.SSLContext | None = None
    token: str = ""

    @property
    def remote(self) -> bool:
        return self.socket is None

    def __str__(self) -> str:
        return self.url if self.socket is None else str(self.socket)

    def pool(self) -> httpx2.AsyncClient:
        """A new pool of connections."""
        limits = httpx2.Limits(max_connections=None, max_keepalive_connections=8, keepalive_expiry=IDLE_S)
        uds = None if self.socket is None else str(self.socket)
        transport = httpx2.AsyncHTTPTransport(
            uds=uds, verify=self.tls or False, limits=limits, trust_env=False, socket_options=None if uds else _ALIVE
        )
        headers = {"Authorization": f"Bearer {self.token}"} if self.token else {}
        return httpx2.AsyncClient(transport=transport, base_url=self.url, headers=headers, timeout=CALL_S)


class _Lane:
    """A connection of its own, and more only while that one waits for an answer."""

    def __init__(self, address: DriverAddress) -> None:
        self.http = address.pool()
        self.waiting, self.used_s = 0, -math.inf

    async def request(self, method: str, path: str, body: Any, timeout_s: float) -> httpx2.Response:
        self.waiting += 1
        self.used_s = time.monotonic()
        try:
            return await self.http.request(method, path, json=body, timeout=timeout_s)
        finally:
            self.waiting -= 1


class DriverConnection:
    """Sends requests to one driver. `clock` is the clock of its host, once measured; unused on a Unix socket.

    Over the network stops and the lease have connections of their own that are open already, since a packet that was
    lost holds up all that follows it on its connection.
    """

    def __init__(self, robot: str, address: DriverAddress) -> None:
        self.robot, self.address = robot, address
        self.clock = DriverClock()
        self._lane = _Lane(address)
        self._stop_lanes = [_Lane(address) for _ in range(STOP_CONNECTIONS)] if address.remote else [self._lane]
        self._lease_lanes = [_Lane(address) for _ in range(LEASE_CONNECTIONS)] if address.remote else [self._lane]
        self._keeping: asyncio.Task[None] | None = None
        self._copies: set[asyncio.Task[httpx2.Response]] = set()

    @staticmethod
    def now_s() -> float:
        """The monotonic clock of this host."""
        return time.monotonic()

    async def ask(self, method: str, path: str, body: Any = None, timeout_s: float = CALL_S) -> httpx2.Response:
        """The answer to a request. Raises `RobotUnreachable` if no driver answers, and its errors as exceptions."""
        if not self.address.remote:
            return await self._ask(self._lane, method, path, body, timeout_s)
        if path in ("/stop", "/halt"):
            return await self._stop(path, body, timeout_s)
        self._keep_open()  # but not for a client that only stops
        if path.startswith("/lease"):
            lane = min(self._lease_lanes, key=lambda lane: (lane.waiting, lane.used_s))
            return await self._ask(lane, method, path, body, timeout_s)
        return await self._ask(self._lane, method, path, body, timeout_s)

    async def _stop(self, path: str, body: dict[str, Any], timeout_s: float) -> httpx2.Response:
        """The answer to a stop. It is sent on several connections, so that a packet that was lost on one does not delay
        it; the driver does it once."""
        body = {**body, "id": secrets.token_urlsafe(12)}
        copies = {asyncio.create_task(self._ask(lane, "POST", path, body, timeout_s)) for lane in self._stop_lanes}
        self._copies |= copies
        for copy in copies:
            copy.add_done_callback(self._forget_copy)
        waiting = copies
        while True:
            done, waiting = await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
            answered = [copy for copy in done if copy.exception() is None]
            if answered or not waiting:
                return (answered or list(done))[0].result()

    def _forget_copy(self, copy: asyncio.Task[httpx2.Response]) -> None:
        self._copies.discard(copy)
        if not copy.cancelled():
            copy.exception()  # the other copy tells

    async def measure_clock(self) -> None:
        """Measure the clock of the driver's host. Raises `RobotError`."""
        await self._measure(min(self._stop_lanes, key=lambda lane: lane.waiting))

    async def close(self) -> None:
        tasks = [*self._copies, *([self._keeping] if self._keeping else [])]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        for lane in self._lanes():
            await lane.http.aclose()

    def _lanes(self) -> list[_Lane]:
        return [*self._stop_lanes, *self._lease_lanes, self._lane] if self.address.remote else [self._lane]

    def _keep_open(self) -> None:
        if self.address.remote and self._keeping is None and not self._lane.http.is_closed:
            self._keeping = asyncio.create_task(self._use_regularly(), name=f"connections to {self.robot}")

    async def _use_regularly(self) -> None:
        """Open the connections, use them so that nothing on the way closes them, and replace those that died."""
        while True:
            await asyncio.gather(*map(self._measure, self._idle()), return_exceptions=True)
            await asyncio.sleep(KEEP_S / 5)

    def _idle(self) -> list[_Lane]:
        """The connections to use now. Once they are open, those for stops take turns: a stop finds the others free."""
        idle_s = time.monotonic() - KEEP_S
        idle = [lane for lane in self._lanes() if not lane.waiting and lane.used_s < idle_s]
        stops = [lane for lane in idle if lane in self._stop_lanes and lane.used_s > -math.inf]
        return [lane for lane in idle if lane not in stops[1:]]

    async def _measure(self, lane: _Lane) -> None:
        asked_s = self.now_s()
        answer = (await self._ask(lane, "GET", "/clock", None, PROBE_S)).json()
        self.clock.measured(str(answer["boot"]), float(answer["now_s"]), asked_s, self.now_s())

    async def _ask(self, lane: _Lane, method: str, path: str, body: Any, timeout_s: float) -> httpx2.Response:
        if lane.http.is_closed:
            raise RobotUnreachable(f"this client of {self.robot!r} has been closed")
        try:
            answer = await lane.request(method, path, body, timeout_s)
        except _NETWORK_ERRORS as e:
            raise RobotUnreachable(self._unreachable(e)) from None
        if answer.is_success:
            return answer
        raise _error(answer)

    def _unreachable(self, error: Exception) -> str:
        kind = type(error).__name__
        if not self.address.remote:
            start = f"start one with: agentrob driver {self.robot}"
            return f"no driver of {self.robot!r} answers at {self.address} ({kind}); {start}"
        reason = display_name(f"{kind}: {error}").rstrip(": ")
        return (
            f"no driver of {self.robot!r} answers at {self.address} ({reason}); is it running there "
            f"(agentrob driver {self.robot}), and do both sides trust each other's certificates?"
        )


def _error(answer: httpx2.Response) -> RobotError:
    problem: Any = {}
    with contextlib.suppress(ValueError):
        problem = answer.json()
    try:
        code, detail = str(problem["code"]), str(problem["detail"])
    except (KeyError, TypeError):
        if answer.status_code == 404:
            return RobotError(
                "the driver is of an older version and does not know this request; upgrade and restart the driver first"
            )
        return RobotError(f"the driver answered {answer.status_code}")
    if code == "lease_lost":
        return LeaseLost(detail, str(problem.get("why", "lease_lapsed")), display_name(str(problem.get("by", ""))))
    return _ERRORS.get(code, RobotError)(detail)
