"""The Prometheus metrics of a driver, read over its own socket at each scrape, as any client reads."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator

from prometheus_client.core import GaugeMetricFamily
from prometheus_client.registry import Collector

from agentrob.errors import RobotError
from agentrob.model import RobotState
from agentrob.robots.driver.client import DriverClient

#: How long a scrape waits for the driver.
ASK_S = 2.0
_HELP = {
    "agentrob_driver_up": "1 while the driver answers.",
    "agentrob_driver_state_age_seconds": "The age of the newest state of the robot.",
    "agentrob_driver_halted": "1 while the robot is locked by an emergency stop.",
    "agentrob_driver_homed": "1 while the robot has a home.",
    "agentrob_driver_battery_percent": "The robot's battery.",
}


class DriverCollector(Collector):
    """Reads the state of one robot from its driver."""

    def __init__(self, robot: str) -> None:
        self._robot = robot

    def describe(self) -> Iterator[GaugeMetricFamily]:
        """The metrics without values: nothing is asked of the driver."""
        for name, text in _HELP.items():
            yield GaugeMetricFamily(name, text, labels=["robot"])

    def collect(self) -> Iterator[GaugeMetricFamily]:
        state = asyncio.run(self._state())
        values: dict[str, float | None] = {"agentrob_driver_up": float(state is not None)}
        if state is not None:
            values |= {
                "agentrob_driver_state_age_seconds": state.age_s,
                "agentrob_driver_halted": float(state.halted),
                "agentrob_driver_homed": float(state.homed),
                "agentrob_driver_battery_percent": state.battery_percent,
            }
        for family in self.describe():
            if (value := values.get(family.name)) is not None:
                family.add_metric([self._robot], value)
            yield family

    async def _state(self) -> RobotState | None:
        try:
            async with asyncio.timeout(ASK_S), DriverClient(self._robot) as driver:
                return await driver.state()
        except (RobotError, TimeoutError):
            return None
