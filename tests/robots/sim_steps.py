"""Steps for tests to run on a robot, and checks of their results."""

from __future__ import annotations

import asyncio

from agentrob.model import ActionResult, Direction, Op, Outcome, Primitive
from agentrob.robots.driver.client import DriverClient
from tests.robots.sim_scene import Sample, SimScene, apart_m

FAR, METRE, NEAR = (Primitive(Op.MOVE, Direction.FORWARD, distance_m=d) for d in (2.0, 1.0, 0.3))
#: From a stop to standing still: the body coasts for about 0.4 s; the rest is for busy machines.
REST_LIMIT_S = 1.5
#: A standing body sways less than this.
UNMOVED_M = 0.03


async def do(robot: DriverClient, primitive: Primitive) -> ActionResult:
    async with robot.lease("tester") as lease:
        return await robot.step(lease, primitive, 30)


async def assert_movable(robot: DriverClient) -> None:
    """Check that it can be moved again."""
    result = await do(robot, NEAR)
    assert result.ok, (result.reason, result.message)


class LeasedStep:
    """Run a step with a lease that is renewed; its result, and where it really began."""

    def __init__(
        self, place: SimScene, robot: DriverClient, primitive: Primitive = FAR, deadline_s: float = 30.0
    ) -> None:
        self.place, self.robot, self.primitive, self.deadline_s = place, robot, primitive, deadline_s
        self.start = place.truth.now
        self.step: asyncio.Task[ActionResult] | None = None

    async def __aenter__(self) -> LeasedStep:
        self._context = self.robot.lease("walker")
        lease = await self._context.__aenter__()
        self.step = asyncio.create_task(self.robot.step(lease, self.primitive, self.deadline_s))
        return self

    async def __aexit__(self, *_: object) -> None:
        assert self.step is not None
        await asyncio.gather(self.step, return_exceptions=True)
        await self._context.__aexit__(None, None, None)

    async def under_way(self, distance_m: float = 0.4) -> Sample:
        """Wait until it has really gone this far. Fails with the step's result if the step ends first."""
        assert self.step is not None
        step = self.step

        def gone(now: Sample) -> bool:
            there = apart_m(now, self.start) > distance_m
            assert there or not step.done(), f"ended before it had gone {distance_m} m: {step.result()}"
            return there

        return await self.place.truth.until(gone)

    async def result(self) -> ActionResult:
        assert self.step is not None
        return await self.step


async def refused(place: SimScene, robot: DriverClient, primitive: Primitive, reason: str) -> ActionResult:
    """Check that a step is refused for this reason and that the robot does not move."""
    start = place.truth.now
    async with robot.lease("walker") as lease:
        result = await robot.step(lease, primitive, 30)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, reason), result.message
    now = await place.truth.until(lambda sample: sample.time_s > start.time_s + 0.3)
    assert apart_m(now, start) < UNMOVED_M
    return result
