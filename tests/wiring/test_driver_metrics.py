"""A driver's metrics are read over its socket at each scrape."""

from __future__ import annotations

from pathlib import Path

import pytest
from prometheus_client import CollectorRegistry, generate_latest

from agentrob.wiring.driver_metrics import DriverCollector
from tests.agent.agent_scene import ROBOT, Driver, robot_settings


def test_it_tells_the_robots_state_and_whether_the_driver_answers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("AGENTROB_RUNTIME", str(tmp_path))
    (tmp_path / "agentrob").mkdir()
    registry = CollectorRegistry()
    registry.register(DriverCollector(ROBOT))
    assert f'agentrob_driver_up{{robot="{ROBOT}"}} 0.0' in generate_latest(registry).decode()
    driver = Driver(tmp_path / "agentrob", robot_settings())
    try:
        lines = generate_latest(registry).decode().splitlines()
    finally:
        driver.end()
    assert f'agentrob_driver_up{{robot="{ROBOT}"}} 1.0' in lines
    assert f'agentrob_driver_halted{{robot="{ROBOT}"}} 0.0' in lines
    assert any(line.startswith("agentrob_driver_battery_percent{") for line in lines)
