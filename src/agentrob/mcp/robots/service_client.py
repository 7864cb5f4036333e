"""A client of the HTTP services of robots' agents."""

from __future__ import annotations

import asyncio
import contextlib
import math
from collections.abc import Awaitable, Callable, Mapping
from typing import Any, TypeVar
from urllib.parse import quote

import httpx2
from limits import RateLimitItemPerMinute
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter
from pydantic_core import from_json

from agentrob.forums.protocol import TRACE_ID
from agentrob.mcp.envelope import ToolError
from agentrob.process.tls import tls

CALL_S = 15.0
#: Interval at which a waiting call reports the command's progress.
LOOK_S = 0.5
#: HTTP status to error code of the envelope; other statuses keep the service's own code.
_CODES = {401: "denied", 403: "denied", 404: "not_found", 422: "invalid_arguments", 429: "rate_limited"}
T = TypeVar("T")
ReportProgress = Callable[[dict[str, Any]], Awaitable[None]]


class Service:
    """One robot's HTTP service."""

    def __init__(self, robot: str, url: str, token: str, http: httpx2.AsyncClient | None = None) -> None:
        self.robot = robot
        self._base = f"{url}/api/v1/robots/{quote(robot, safe='')}"
        self._headers = {"Authorization": f"Bearer {token}"}
        self._http = http or httpx2.AsyncClient(timeout=CALL_S, trust_env=False, follow_redirects=False, verify=tls())

    async def ask(self, method: str, path: str = "", body: Any = None, **headers: str) -> dict[str, Any]:
        """The JSON object of the answer; `ToolError` for anything else."""
        found = _json(await self._asked(method, path, body, headers))
        if not isinstance(found, dict):
            raise _stranger()
        return found

    async def picture(self) -> bytes:
        """A JPEG of the robot's own camera."""
        return (await self._asked("GET", "/camera.jpg", None, {})).content

    async def _asked(self, method: str, path: str, body: Any, headers: Mapping[str, str]) -> httpx2.Response:
        sent = {**self._headers, "X-Trace-Id": TRACE_ID.get() or "", **headers}
        try:
            answer = await self._http.request(method, self._base + path, json=body, headers=sent)
        except (httpx2.HTTPError, httpx2.InvalidURL, OSError) as e:
            hint = "the robot's state is unknown; to stop it use its own stop, or agentrob stop on its machine"
            message = f"the service of {self.robot} does not answer ({type(e).__name__})"
            raise ToolError("unreachable", message, hint, retryable=True) from None
        if answer.is_success:
            return answer
        raise _refusal(answer)

    async def close(self) -> None:
        await self._http.aclose()


def _json(answer: httpx2.Response) -> Any:
    """The JSON of an answer; None if it is invalid or cannot be passed on (lone surrogates, NaN)."""
    try:
        return from_json(answer.content, allow_inf_nan=False)
    except ValueError:
        return None


def _stranger() -> ToolError:
    return ToolError("unreachable", "the server at this address is not an AgentRob service", "", True)


def part(found: Mapping[str, Any], name: str, kind: type[T]) -> T:
    """A field of an answer; `ToolError` if it has the wrong type."""
    value = found.get(name)
    if not isinstance(value, kind):
        raise _stranger()
    return value


def _refusal(answer: httpx2.Response) -> ToolError:
    """The service's problem details as a `ToolError`."""
    try:
        problem = _json(answer)
        message, hint, code = str(problem["detail"]), str(problem.get("hint", "")), str(problem["code"])
    except (ValueError, KeyError, TypeError, AttributeError):
        message, hint, code = f"the service answered {answer.status_code}", "", "unreachable"
    after_s: float | None = None
    with contextlib.suppress(ValueError):
        after_s = float(answer.headers["retry-after"]) if "retry-after" in answer.headers else None
    if after_s is not None and not math.isfinite(after_s):
        after_s = None
    retryable = answer.status_code in (429, 503) or after_s is not None
    return ToolError(_CODES.get(answer.status_code, code), message, hint, retryable, after_s)


class Robots:
    """The robots of the configuration."""

    def __init__(self, services: Mapping[str, Service], pictures_per_minute: int) -> None:
        self._services = dict(services)
        self._pictures = RateLimitItemPerMinute(pictures_per_minute)
        self._limiter = MovingWindowRateLimiter(MemoryStorage())

    def __iter__(self) -> Any:
        return iter(self._services.values())

    def named(self, robot: str | None) -> Service:
        """The service of a robot; without a name, of the only robot."""
        if robot is None and len(self._services) == 1:
            return next(iter(self._services.values()))
        if robot in self._services:
            return self._services[robot]
        known = ", ".join(sorted(self._services))
        raise ToolError("not_found", "no robot of this name is configured here", f"robot is one of: {known}")

    def count_picture(self, robot: str) -> None:
        """Count a picture; `ToolError` if over the rate limit."""
        if not self._limiter.hit(self._pictures, robot):
            hint = f"at most {self._pictures.amount} pictures a minute"
            raise ToolError("rate_limited", "too many pictures", hint, True, 60.0 / self._pictures.amount)

    async def close(self) -> None:
        for service in self._services.values():
            await service.close()


async def wait_for_command(
    service: Service, command: dict[str, Any], wait_s: float, report: ReportProgress
) -> dict[str, Any]:
    """Return a command when it has ended, or after at most `wait_s`; `report` is called at each change."""
    loop, command_id = asyncio.get_running_loop(), quote(part(command, "id", str), safe="")
    until_s, shown = loop.time() + wait_s, None
    while True:
        now = (command.get("state"), command.get("step"), command.get("place"))
        if now != shown and wait_s:
            await report(command)
            shown = now
        left_s = until_s - loop.time()
        if command.get("ended") or left_s <= 0:
            return command
        pause_s = max(0.0, min(LOOK_S, left_s))
        command = await service.ask("GET", f"/commands/{command_id}?wait_s={pause_s:.2f}")
