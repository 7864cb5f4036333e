"""Client of a robot's driver, used by the agent, `agentrob drive` and scripts."""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from collections.abc import AsyncIterator, Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import httpx2

from agentrob.config.load import runtime_dir
from agentrob.errors import LeaseLost, RobotError
from agentrob.model import (
    ActionResult,
    Capabilities,
    FencingToken,
    Hindrance,
    Lock,
    Outcome,
    Plan,
    Pose,
    Posture,
    Primitive,
    RobotState,
    StopResult,
)
from agentrob.robots import codec
from agentrob.robots.driver.connection import CALL_S, DriverAddress, DriverConnection, OtherBoot

RENEW_S = 0.2
RENEWAL_S = 3.0
#: Beyond a step's own deadline: coming to rest, measuring, answering.
GRACE_S = 10.0
#: Renewals that are not answered yet; more would not help.
RENEWALS = 8
#: A command that counts from a stop of this client says so by a time this soon after the stop's `ended_s`.
AFTER_STOP_S = 1e-6


class DriverClient:
    """A client of one robot's driver, at a Unix socket of this machine or (`agentrob.robots.driver.remote`) elsewhere.

    All times are of this host's monotonic clock. Every call raises `RobotUnreachable` if no driver answers.

    >>> robot = DriverClient("quadruped")
    >>> async with robot.lease("me") as lease:
    ...     result = await robot.step(lease, Primitive(Op.TURN, Direction.LEFT, degrees=90), deadline_s=30)
    """

    def __init__(self, robot: str, socket: Path | None = None, address: DriverAddress | None = None) -> None:
        self.robot = robot
        self.address = address or DriverAddress(socket or runtime_dir() / f"{robot}.sock")
        self._connection = DriverConnection(robot, self.address)
        self._renewing: dict[str, asyncio.Task[None]] = {}
        #: Of our last stop: when it was done, by our clock and by the driver's, and when we heard of it.
        self._own_stop, self._stop_heard_s = (-math.inf, -math.inf), math.inf
        self._fence: FencingToken | None = None

    async def capabilities(self) -> Capabilities:
        return codec.decode_capabilities(await self._call("GET", "/capabilities"))

    async def state(self) -> RobotState:
        data = await self._call("GET", "/state")
        return codec.decode_state({k: v for k, v in data.items() if k not in ("lease", "busy")})

    async def posture(self, *, joints: bool = True) -> Posture:
        """How the robot holds its body now, with its pose in the frame of its home."""
        return codec.decode_posture(await self._call("GET", "/pose" if joints else "/pose?joints=0"))

    async def holder(self) -> str | None:
        """The holder of the current lease."""
        lease = (await self._call("GET", "/state"))["lease"]
        return None if lease is None else str(lease["holder"])

    async def look(self) -> bytes:
        """Return a JPEG of the robot's own camera, also while it moves; needs no lease. Raises `RobotBusy` over the
        rate limit."""
        return (await self._ask("GET", "/look")).content

    async def fence(self, fence: FencingToken) -> None:
        """Lock out workers with smaller fencing numbers; every later `lease` of this client carries this one.

        Raises `Fenced` if another worker has taken the robot since, and `RobotError` if the driver cannot keep it.
        """
        self._fence = fence
        await self._call("POST", "/fence", asdict(fence))

    @contextlib.asynccontextmanager
    async def lease(self, holder: str, since_s: float | None = None) -> AsyncIterator[str]:
        """Hold the lease, the right to move the robot, and renew it five times a second until the context ends.

        When this client requests a stop it no longer renews the lease: should the request be lost, the lease lapses,
        and the driver stops the robot within a second. A stop ends the lease; `step` then raises `LeaseLost`.

        `since_s` is when the command was accepted (`time.monotonic()` on this host; default now), or the `ended_s` of a
        stop of this client, for a command that counts from that stop on. Raises `LeaseLost` if a stop or halt came
        since then, `Fenced` if another worker has taken the robot, and `RobotBusy`, which names the
        current holder.
        """
        body = {"holder": holder, "fence": self._fence and asdict(self._fence)}
        lease = str((await self._call_since("/lease", body, since_s))["lease"])
        self._renewing[lease] = asyncio.create_task(self._renew(lease), name=f"lease of {self.robot}")
        try:
            yield lease
        finally:
            if (renewing := self._renewing.pop(lease, None)) is not None:
                renewing.cancel()
            with contextlib.suppress(RobotError):
                await asyncio.shield(self._call("DELETE", f"/lease/{lease}"))

    async def _renew(self, lease: str) -> None:
        """Renew until the lease is lost; the holder sees that when it calls `step`.

        A renewal does not wait for the answer to the last one, which may have been lost on the way.
        """
        lost, asked = asyncio.Event(), set[asyncio.Task[None]]()

        async def renew() -> None:
            try:
                await self._call("PUT", f"/lease/{lease}", self._sent(), timeout_s=RENEWAL_S)
            except LeaseLost:
                lost.set()
            except RobotError:
                pass  # the driver may be slow for a moment: the lease itself decides

        while not lost.is_set():
            await asyncio.sleep(RENEW_S)
            if len(asked) < RENEWALS:
                asked.add(renewal := asyncio.create_task(renew()))
                renewal.add_done_callback(asked.discard)

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
            timeout_s = RENEWAL_S if self.address.remote else 1.0
            await self._call("PUT", f"/lease/{lease}", self._sent(), timeout_s=timeout_s)
        except LeaseLost as e:
            return e
        if lease in self._renewing:
            return None
        await self._call("DELETE", f"/lease/{lease}", timeout_s=1.0)  # let lapse: asking must not keep it
        return LeaseLost("this client released the lease when it requested a stop")

    async def enter_room(self, steps: Sequence[Primitive]) -> Hindrance | None:
        """Get the zone that these steps need in the shared room, if the robot shares one; they must begin within some
        seconds. Return why not; asking again every second keeps the robot's place among those that wait."""
        body = {"steps": [codec.encode(step) for step in steps]}
        hindrance = (await self._call("POST", "/room", body))["hindrance"]
        return None if hindrance is None else codec.decode_hindrance(hindrance)

    async def step(self, lease: str, primitive: Primitive, deadline_s: float) -> ActionResult:
        """Run a step until its end. A refusal or failure is a result. Raises `LeaseLost` without a valid lease."""
        body = {"lease": lease, "primitive": codec.encode(primitive), "deadline_s": deadline_s}
        answer = await self._call("POST", "/step", body, timeout_s=max(deadline_s, 0.0) + GRACE_S)
        result = codec.decode_result(answer)
        result = replace(result, primitive=replace(result.primitive, declared=primitive.declared))
        return self._result_here(result) if self.address.remote else result

    async def stop(self, by: str, *, running_only: bool = False) -> StopResult:
        """Stop the robot now; needs no lease. Returns when the robot is at rest, after at most 3 s.

        It also ends commands that were accepted before and have no lease yet, unless `running_only` is set. This
        client's leases are no longer renewed.
        """
        self._let_lapse()
        return await self._stop("/stop", {"by": by, "running_only": running_only}, ends_waiting=not running_only)

    async def halt(self, by: str) -> StopResult:
        """Stop, and refuse all motion until `release`, also after restarts. It ends leases as `stop` does."""
        self._let_lapse()
        return await self._stop("/halt", {"by": by})

    async def _stop(self, path: str, body: dict[str, Any], ends_waiting: bool = True) -> StopResult:
        asked_s = self._connection.now_s()
        result = codec.decode_stop(await self._call("POST", path, body))
        if not self.address.remote:
            return result
        heard_s = self._connection.now_s()
        here = await self._here(result, asked_s)
        if ends_waiting:
            self._stop_heard_s = heard_s
            ours_s, theirs_s = self._own_stop
            self._own_stop = (max(ours_s, here.ended_s), max(theirs_s, result.ended_s))
        return here

    async def release(self, by: str, since_s: float | None = None) -> Lock | None:
        """Unlock the robot on behalf of its owner. Return the removed lock, or None if it was not locked.

        `since_s` is when the release was requested (`time.monotonic()` on this host; default now). Raises `RobotError`
        if the robot was locked after that.
        """
        released = (await self._call_since("/release", {"by": by}, since_s))["released"]
        return None if released is None else codec.decode_lock(released)

    async def home(self, by: str) -> Pose:
        """Set home to the robot's current pose, on behalf of its owner. Raises `RobotError` if it cannot be set."""
        return codec.decode_pose((await self._call("POST", "/home", {"by": by}))["home"])

    async def close(self) -> None:
        await self._connection.close()

    async def __aenter__(self) -> DriverClient:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def _call(self, method: str, path: str, body: Any = None, timeout_s: float = CALL_S) -> Any:
        return (await self._ask(method, path, body, timeout_s)).json()

    async def _ask(self, method: str, path: str, body: Any = None, timeout_s: float = CALL_S) -> httpx2.Response:
        return await self._connection.ask(method, path, body, timeout_s)

    # ------------------------------------------------------------------ the clock of another host
    def _sent(self) -> dict[str, Any]:
        """When a renewal is sent, by the driver's clock and at the earliest: one that arrives late extends the lease
        less."""
        now_s, clock = self._connection.now_s(), self._connection.clock
        if not self.address.remote:
            return {"sent_s": now_s}
        return {"sent_s": clock.earliest_there(now_s, now_s), "boot": clock.boot} if clock.known else {}

    async def _call_since(self, path: str, body: dict[str, Any], since_s: float | None) -> Any:
        """Call with `since_s`, converted to the clock of the driver's host."""
        if not self.address.remote:
            return await self._call("POST", path, {**body, "since_s": since_s})
        since_s = self._connection.now_s() if since_s is None else since_s
        if not self._connection.clock.known:
            await self._connection.measure_clock()
        try:
            return await self._call_since_there(path, body, since_s)
        except OtherBoot:
            await self._connection.measure_clock()
            return await self._call_since_there(path, body, since_s)

    async def _call_since_there(self, path: str, body: dict[str, Any], since_s: float) -> Any:
        body = {**body, "since_s": self._since_there(since_s), "boot": self._connection.clock.boot}
        return await self._call("POST", path, body)

    def _since_there(self, since_s: float) -> float:
        """When a command was accepted, by the driver's clock and at the earliest: a stop that may have come after it
        ends it. A command that counts from our own stop, or came when we had heard of it, is surely later than that."""
        there_s = self._connection.clock.earliest_there(since_s, self._connection.now_s())
        ours_s, theirs_s = self._own_stop
        after = 0 < since_s - ours_s <= AFTER_STOP_S or since_s >= self._stop_heard_s
        return max(there_s, math.nextafter(theirs_s, math.inf)) if after else there_s

    async def _here(self, result: StopResult, asked_s: float) -> StopResult:
        """A stop by our clock: its way to the driver counts as latency, and it ended what was accepted before it."""
        connection, clock = self._connection, self._connection.clock
        now_s = connection.now_s()
        if not clock.known:
            with contextlib.suppress(RobotError):
                await connection.measure_clock()
        ended_s, latest_s = asked_s, now_s
        if clock.known:
            ended_s = min(max(clock.earliest_here(result.ended_s, connection.now_s()), asked_s), now_s)
            latest_s = min(max(clock.latest_here(result.ended_s, connection.now_s()), asked_s), now_s)
        latency_ms = result.latency_ms + 1000 * (latest_s - asked_s)
        return replace(result, ended_s=ended_s, latency_ms=round(latency_ms, 3))

    def _result_here(self, result: ActionResult) -> ActionResult:
        """The result of a step by our clock, at the earliest."""
        clock, now_s = self._connection.clock, self._connection.now_s()
        if not clock.known or not result.started_s:
            return result
        started_s, ended_s = (clock.earliest_here(t, now_s) for t in (result.started_s, result.ended_s))
        return replace(result, started_s=started_s, ended_s=ended_s)


def run_plan(
    robot: str,
    plan: Plan,
    holder: str,
    *,
    socket: Path | None = None,
    client: DriverClient | None = None,
    deadline_s: float = 60.0,
    on_result: Callable[[ActionResult], None] = lambda _: None,
) -> tuple[ActionResult, ...]:
    """Run a plan from a script; blocks. After a step that is not done, the remaining steps are `skipped`.

    `client` is used, and closed, instead of one for `socket`. `deadline_s` applies to the whole plan. `on_result` is
    called with the result of each step. Raises `RobotError`.
    """
    client = client or DriverClient(robot, socket)
    return asyncio.run(_run_plan(client, plan, holder, deadline_s, on_result, time.monotonic()))


async def _run_plan(
    client: DriverClient,
    plan: Plan,
    holder: str,
    deadline_s: float,
    on_result: Callable[[ActionResult], None],
    since_s: float,
) -> tuple[ActionResult, ...]:
    results: list[ActionResult] = []
    end_s = asyncio.get_running_loop().time() + deadline_s
    async with client, client.lease(holder, since_s) as lease:
        for primitive in plan.steps:
            if results and not results[-1].ok:
                result = ActionResult(primitive, Outcome.SKIPPED, message="An earlier step was not done.")
            else:
                result = await client.step(lease, primitive, end_s - asyncio.get_running_loop().time())
            results.append(result)
            on_result(result)
    return tuple(results)
