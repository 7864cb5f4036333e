"""Drive a robot like its owner and print the result: `drive_robot.py CONFIG ROBOT TEXT`; its driver must be running."""

import asyncio
import json
import sys
import time
from pathlib import Path

from agentrob import robot_command_driver
from agentrob.config import load
from agentrob.errors import RobotError
from agentrob.model import RobotState
from agentrob.robots.driver.client import DriverClient

LIMIT_S = 60.0


async def set_home(name: str) -> RobotState:
    """Set the robot's home to its current position; return its state."""
    async with DriverClient(name) as client:
        end_s = time.monotonic() + LIMIT_S
        while True:
            try:
                await client.home("owner")
                return await client.state()
            except RobotError:  # no state yet, or it was not seen standing still
                if time.monotonic() > end_s:
                    raise
                await asyncio.sleep(0.1)


settings, name, text = load.load(Path(sys.argv[1])), sys.argv[2], sys.argv[3]
state = asyncio.run(set_home(name))
driven = robot_command_driver(text, name, config=settings)
steps = [result.as_data() | {"picture": len(result.image or b"")} for result in driven.results]
facts = {"status": driven.status, "message": driven.message, "steps": steps, "battery": state.battery_percent}
print(json.dumps(facts))  # noqa: T201
