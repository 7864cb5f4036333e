"""A card of any version, and of anybody, becomes one row of the fleet."""

from __future__ import annotations

import json
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.agent.reporting.activity import AgentActivity
from agentrob.model import StopResult, fleet_robot

NOW = datetime(2026, 11, 23, 12, 0, tzinfo=UTC)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=5,
)
FIELDS = ("worker", "version", "state", "lag_ms", "queue", "battery_percent", "stop_ms", "stop_at", "failures")


def test_it_reads_what_an_agent_publishes() -> None:
    activity = AgentActivity("lab-1", failures={"failed": 2})  # type: ignore[arg-type]
    activity.stopped(StopResult(latency_ms=31.2, confirmed=True))
    card = {"state": "idle", "queue": 2, "battery_percent": 81} | activity.card()
    robot = fleet_robot("rex", card, NOW, NOW)
    assert (robot.worker, robot.state_label, robot.queue, robot.stop_ms) == ("lab-1", "idle", 2, 31.2)
    assert robot.failures == (("failed", 2),)
    assert robot.stop_at == activity.stop_at


@pytest.mark.parametrize(("age_s", "served"), [(None, False), (14.0, True), (16.0, False)])
def test_a_robot_whose_card_is_old_is_not_served(age_s: float | None, served: bool) -> None:
    seen_at = None if age_s is None else NOW - timedelta(seconds=age_s)
    robot = fleet_robot("rex", {"state": "idle"}, seen_at, NOW)
    assert robot.served is served
    assert robot.state_label == ("idle" if served else "not served")


@given(st.fixed_dictionaries({}, optional=dict.fromkeys(FIELDS, JSON)))
def test_no_card_breaks_it(card: dict[str, Any]) -> None:
    robot = fleet_robot("rex", card, NOW, NOW)
    json.dumps(robot.as_data(), allow_nan=False)
    assert len(robot.worker) <= 64
