"""A worker that does not know that it lost its robot: it tries to move it with its old fencing number, and without one.

Run as `python late_worker.py ROBOT FACTS`, with the robot's settings, the database's id and the number as JSON; prints
what the driver answered. It imports little, because it is started in the middle of a test.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys

from agentrob.config.robots import RobotConfig
from agentrob.errors import RobotError
from agentrob.model import Direction, FencingToken, Op, Primitive
from agentrob.robots.driver.remote import driver_client

NEAR = Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.3)


async def tries(robot: str, settings: RobotConfig, fence: FencingToken | None) -> str:
    """Return the error by which the driver refuses a motion, or `moved`."""
    async with driver_client(robot, settings) as client:
        try:
            if fence is not None:
                with contextlib.suppress(RobotError):
                    await client.fence(fence)
            async with client.lease("late") as lease:
                await client.step(lease, NEAR, 10)
                return "moved"
        except RobotError as e:
            return type(e).__name__


async def main(robot: str, settings: RobotConfig, fence: FencingToken) -> dict[str, str]:
    return {"number": await tries(robot, settings, fence), "none": await tries(robot, settings, None)}


if __name__ == "__main__":
    given, store, number = json.loads(sys.argv[2])
    answers = asyncio.run(main(sys.argv[1], RobotConfig.model_validate(given), FencingToken(store, number)))
    print(json.dumps(answers))  # noqa: T201
