"""The robot's card tells which process serves the robot, how fast it answers, and what failed."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path

from agentrob import __version__
from agentrob.agent.reporting.activity import LATEST, AgentActivity
from agentrob.model import Account, Command, CommandState, Report, Role, StopResult
from tests.agent.agent_scene import ROBOT, Driver, make_scene

COMMAND = Command("1", "1", "", Account("1", "alice", role=Role.OPERATOR), ROBOT, "", "en", datetime.now(UTC), "t")


def test_it_counts_failures_by_kind_and_shows_the_median_latency_of_the_last_commands() -> None:
    activity = AgentActivity("lab-1")
    for _ in range(LATEST):
        activity.ended(Report(COMMAND, CommandState.DONE, timings_ms={"seen": 5000.0}))
    for seen_ms in (10.0, 30.0, 90.0) * 10:
        activity.ended(Report(COMMAND, CommandState.FAILED, timings_ms={"seen": seen_ms}))
    activity.ended(Report(COMMAND, CommandState.INTERRUPTED))
    card = activity.card()
    assert card["failures"] == {"failed": 30, "interrupted": 1}
    assert card["lag_ms"] == 30
    assert json.loads(json.dumps(card)) == card


def test_a_stop_that_reached_no_driver_has_no_latency() -> None:
    activity = AgentActivity("lab-1")
    assert (activity.card()["stop_ms"], activity.card()["stop_at"]) == (None, None)
    activity.stopped(StopResult(latency_ms=12.34, confirmed=True))
    assert activity.card()["stop_ms"] == 12.3
    activity.stopped(None)
    assert activity.card()["stop_ms"] is None
    assert activity.card()["stop_at"] is not None


async def test_the_card_of_a_robot_tells_its_worker_and_what_happened(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path)
    stops: list[StopResult | None] = []
    async with scene.agent(worker="lab-1", on_stop=stops.append):
        await scene.final(await scene.post("alice", f"@{ROBOT} wave"))
        refused = await scene.final(await scene.post("bob", f"@{ROBOT} wave"))
        assert refused.card is not None
        assert refused.card.state == "refused"
        await scene.post("alice", f"@{ROBOT} stop")
        cards = scene.world.robots
        card = await scene.until(lambda: (c := cards.get(ROBOT, {})).get("stop_ms") and c["failures"] and c)
    assert (card["worker"], card["version"]) == ("lab-1", __version__)
    assert card["failures"] == {"refused": 1}
    assert card["lag_ms"] >= 0
    assert datetime.fromisoformat(card["since"]) <= datetime.fromisoformat(card["stop_at"]) <= datetime.now(UTC)
    assert len(stops) == 1


async def test_an_error_in_counting_a_stop_does_not_keep_it_from_being_answered(driver: Driver, tmp_path: Path) -> None:
    def fail(_: StopResult | None) -> None:
        raise ValueError("a defect")

    scene = make_scene(driver, tmp_path)
    async with scene.agent(on_stop=fail):
        post = await scene.post("alice", f"@{ROBOT} stop")
        await scene.until(lambda: scene.replies(post))
