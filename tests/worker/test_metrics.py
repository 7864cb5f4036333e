"""A worker's metrics, without names of people or texts of posts."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

from prometheus_client import generate_latest

from agentrob.model import Account, Command, CommandState, Report, Role, StopResult
from agentrob.worker.metrics import WorkerMetrics
from tests.agent.agent_scene import ROBOT, Driver, make_scene


def exposed(metrics: WorkerMetrics) -> list[str]:
    return generate_latest(metrics.registry).decode().splitlines()


def test_it_counts_restarts_takeovers_and_failures_of_the_journal() -> None:
    metrics = WorkerMetrics()
    for happened in (metrics.restarted, metrics.taken_over, metrics.journal_failed):
        happened("rex")
    lines = exposed(metrics)
    for name in ("agent_restarts", "takeovers", "journal_errors"):
        assert f'agentrob_{name}_total{{robot="rex"}} 1.0' in lines


def test_a_stop_without_a_driver_has_no_latency() -> None:
    metrics = WorkerMetrics()
    metrics.stopped("rex", StopResult(latency_ms=30.0, confirmed=True))
    metrics.stopped("rex", None)
    lines = exposed(metrics)
    assert 'agentrob_stops_total{reached="false",robot="rex"} 1.0' in lines
    assert 'agentrob_stop_seconds_count{robot="rex"} 1.0' in lines
    assert 'agentrob_stop_seconds_sum{robot="rex"} 0.03' in lines


def test_people_and_their_words_are_in_no_label() -> None:
    metrics = WorkerMetrics()
    author = Account("1", "secretive", role=Role.OPERATOR)
    command = Command("4711", "1", "", author, "rex", "my words", "en", datetime.now(UTC), "trace-1")
    metrics.agents.ended(Report(command, CommandState.FAILED, message="my reply", timings_ms={"seen": 20.0}))
    text = "\n".join(exposed(metrics))
    assert 'agentrob_commands_total{robot="rex",status="failed"} 1.0' in text
    assert not any(word in text for word in ("secretive", "words", "reply", "4711", "trace-1"))


async def test_an_agent_is_watched_while_it_is_served(driver: Driver, tmp_path: Path) -> None:
    metrics = WorkerMetrics()
    scene = make_scene(driver, tmp_path)
    async with scene.agent(**metrics.hooks(ROBOT)) as agent:
        metrics.serve(agent)
        await scene.final(await scene.post("alice", f"@{ROBOT} walk 0.2 m"))
        await scene.post("alice", f"@{ROBOT} stop")
        wanted = {f'agentrob_queue_length{{robot="{ROBOT}"}} 0.0', "agentrob_robots_served 1.0"} | {
            f'agentrob_{name}_seconds_count{{robot="{ROBOT}"}} 1.0'
            for name in ("stop", "command_seen", "command_first_motion", "command")
        }
        await scene.until(lambda: wanted <= set(exposed(metrics)))  # an end is counted after it is posted
    metrics.left(ROBOT)
    assert "agentrob_robots_served 0.0" in exposed(metrics)
    assert not any(line.startswith("agentrob_queue_length{") for line in exposed(metrics))
