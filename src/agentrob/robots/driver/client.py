"""Client of a robot's driver over its Unix socket, used by the agent, `agentrob drive` and scripts."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

import httpx2

from agentrob.config.load import runtime_dir
from agentrob.errors import LeaseLost, RobotBusy, RobotError, RobotUnreachable
from agentrob.model import ActionResult, Capabilities, Lock, Outcome, Plan, Pose, Primitive, RobotState, StopResult
from agentrob.robots import codec
from agentrob.robots.codec import display_name

RENEW_S = 0.2
#: Beyond a step's own deadline: coming to rest, measuring, answering.
GRACE_S = 10.0
CALL_S = 5.0


class DriverClient:
    """A client of one robot's driver. Every call raises `RobotUnreachable` if no driver answers.

    >>> robot = DriverClient("quadruped")
    >>> async with robot.lease("me") as lease:
    ...     result = await robot.step(lease, Primitive(Op.TURN, Direction.LEFT, degrees=90), deadline_s=30)
    """

    def __init__(self, robot: str, socket: Path | None = None) -> None:
        self.robot = robot
        self.socket = socket or runtime_dir() / f"{robot}.sock"
        transport = httpx2.AsyncHTTPTransport(uds=str(self.socket), verify=False)  # no TLS on a local socket
        self._http = httpx2.AsyncClient(transport=transport, base_url="http://driver", timeout=CALL_S)
        self._renewing: dict[str, asyncio.Task[None]] = {}

    async def capabilities(self) -> Capabilities:
        return codec.decode_capabilities(await self._call("GET", "/capabilities"))

    async def state(self) -> RobotState:
        data = await self._call("GET", "/state")
        return codec.decode_state({k: v for k, v in data.items() if k not in ("lease", "busy")})

    async def holder(self) -> str | None:
        """The holder of the current lease."""
        lease = (await self._call("GET", "/state"))["lease"]
        return None if lease is None else str(lease["holder"])

    async def look(self) -> bytes:
        """Return a JPEG of the robot's own camera, also while it moves; needs no lease. Raises `RobotBusy` over the
        rate limit."""
        return (await self._ask("GET", "/look")).content

    @contextlib.asynccontextmanager
    async def lease(self, holder: str, since_s: float | None = None) -> AsyncIterator[str]:
        """Hold the lease, the right to move the robot, and renew it five times a second until the context ends.

        When this client requests a stop it no longer renews the lease: should the request be lost, the lease lapses,
        and the driver stops the robot within a second. A stop ends the lease; `step` then raises `LeaseLost`.

        `since_s` is when the command was accepted (`time.monotonic()` on this host; default now). Raises `LeaseLost` if
        a stop or halt came since then, and `RobotBusy`, which names the current holder.
        """
        lease = str((await self._call("POST", "/lease", {"holder": holder, "since_s": since_s}))["lease"])
        self._renewing[lease] = asyncio.create_task(self._renew(lease), name=f"lease of {self.robot}")
        try:
            yield lease
        finally:
            if (renewing := self._renewing.pop(lease, None)) is not None:
                renewing.cancel()
            with contextlib.suppress(RobotError):
                await asyncio.shield(self._call("DELETE", f"/lease/{lease}"))

    async def _renew(self, lease: str) -> None:
        """Renew until the lease is lost; the holder sees that when it calls `step`."""
        while True:
            await asyncio.sleep(RENEW_S)
            try:
                await self._call("PUT", f"/lease/{lease}", timeout_s=1.0)
            except LeaseLost:
                return
            except RobotError:
                continue  # the driver may be slow for a moment: the lease itself decides

    def _let_lapse(self) -> None:
        """Stop renewing this client's leases, so that motion ends even if a stop request is lost."""
        for renewing in self._renewing.values():
            renewing.cancel()
        self._renewing.clear()

    async def lost(self, lease: str) -> LeaseLost | None:
        """Return None while the lease is valid, else the `LeaseLost` with `why` it ended and `by` whom.

        Call this after a step that ended with `stop`, since its result does not say who stopped it.
        """
        try:
            await self._call("PUT", f"/lease/{lease}", timeout_s=1.0)
        except LeaseLost as e:
            return e
        if lease in self._renewing:
            return None
        await self._call("DELETE", f"/lease/{lease}", timeout_s=1.0)  # let lapse: asking must not keep it
        return LeaseLost("this client released the lease when it requested a stop")

    async def step(self, lease: str, primitive: Primitive, deadline_s: float) -> ActionResult:
        """Run a step until its end. A refusal or failure is a result. Raises `LeaseLost` without a valid lease."""
        body = {"lease": lease, "primitive": codec.encode(primitive), "deadline_s": deadline_s}
        return codec.decode_result(await self._call("POST", "/step", body, timeout_s=max(deadline_s, 0.0) + GRACE_S))

    async def stop(self, by: str, *, running_only: bool = False) -> StopResult:
        """Stop the robot now; needs no lease. Returns when the robot is at rest, after at most 3 s.

        It also ends commands that were accepted before and have no lease yet, unless `running_only` is set. This
        client's leases are no longer renewed.
        """
        self._let_lapse()
        body = {"by": by, "running_only": running_only}
        return codec.decode_stop(await self._call("POST", "/stop", body, timeout_s=CALL_S))

    async def halt(self, by: str) -> StopResult:
        """Stop, and refuse all motion until `release`, also after restarts. It ends leases as `stop` does."""
        self._let_lapse()
        return codec.decode_stop(await self._call("POST", "/halt", {"by": by}, timeout_s=CALL_S))

    async def release(self, by: str, since_s: float | None = None) -> Lock | None:
        """Unlock the robot on behalf of its owner. Return the removed lock, or None if it was not locked.

        `since_s` is when the release was requested (`time.monotonic()` on this host; default now). Raises `RobotError`
        if the robot was locked after that.
        """
        released = (await self._call("POST", "/release", {"by": by, "since_s": since_s}))["released"]
        return None if released is None else codec.decode_lock(released)

    async def home(self, by: str) -> Pose:
        """Set home to the robot's current pose, on behalf of its owner. Raises `RobotError` if it cannot be set."""
        return codec.decode_pose((await self._call("POST", "/home", {"by": by}))["home"])

    async def close(self) -> None:
        await self._http.aclose()

    async def __aenter__(self) -> DriverClient:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def _call(self, method: str, path: str, body: Any = None, timeout_s: float = CALL_S) -> Any:
        return (await self._ask(method, path, body, timeout_s)).json()

    async def _ask(self, method: str, path: str, body: Any = None, timeout_s: float = CALL_S) -> httpx2.Response:
        if self._http.is_closed:
            raise RobotUnreachable(f"this client of {self.robot!r} has been closed")
        try:
            answer = await self._http.request(method, path, json=body, timeout=timeout_s)
        except (httpx2.TransportError, OSError) as e:
            raise RobotUnreachable(
                f"no driver of {self.robot!r} answers at {self.socket} ({type(e).__name__}); "
                f"start one with: agentrob driver {self.robot}"
            ) from None
        if answer.is_success:
            return answer
        try:
            problem = answer.json()
            code, detail = str(problem["code"]), str(problem["detail"])
        except (ValueError, KeyError, TypeError):
            problem, code, detail = {}, "", f"the driver answered {answer.status_code}"
        if code == "lease_lost":
            raise LeaseLost(detail, str(problem.get("why", "lease_lapsed")), display_name(str(problem.get("by", ""))))
        raise (RobotBusy if code == "busy" else RobotError)(detail)


def run_plan(
    robot: str,
    plan: Plan,
    holder: str,
    *,
    socket: Path | None = None,
    deadline_s: float = 60.0,
    on_result: Callable[[ActionResult], None] = lambda _: None,
) -> tuple[ActionResult, ...]:
    """Run a plan from a script; blocks. After a step that is not done, the remaining steps are `skipped`.

    `deadline_s` applies to the whole plan. `on_result` is called with the result of each step. Raises `RobotError`.
    """
    return asyncio.run(_run_plan(robot, plan, holder, socket, deadline_s, on_result, time.monotonic()))


async def _run_plan(
    robot: str,
    plan: Plan,
    holder: str,
    socket: Path | None,
    deadline_s: float,
    on_result: Callable[[ActionResult], None],
    since_s: float,
) -> tuple[ActionResult, ...]:
    results: list[ActionResult] = []
    end_s = asyncio.get_running_loop().time() + deadline_s
    async with DriverClient(robot, socket) as client, client.lease(holder, since_s) as lease:
        for primitive in plan.steps:
            if results and not results[-1].ok:
                result = ActionResult(primitive, Outcome.SKIPPED, message="An earlier step was not done.")
            else:
                result = await client.step(lease, primitive, end_s - asyncio.get_running_loop().time())
            results.append(result)
            on_result(result)
    return tuple(results)
