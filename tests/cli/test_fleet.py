"""`agentrob fleet` shows every robot of the forum."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from rich.console import Console
from typer.testing import CliRunner

from agentrob.cli.main import cli
from agentrob.model import FleetRobot
from agentrob.wiring.fleet import ago, table
from tests.board.running_board import RunningBoard, running_board

NOW = datetime(2026, 11, 23, 12, 0, tzinfo=UTC)


@pytest.fixture
def board(tmp_path: Path) -> Iterator[RunningBoard]:
    with running_board(tmp_path) as board:
        yield board


def test_it_reads_the_robots_of_the_forum(board: RunningBoard, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    card = {"state": "idle", "queue": 1, "worker": "lab-1", "failures": {"failed": 2}, "lag_ms": 31}
    with board.client("quadruped") as robot:
        robot.put("/robots/quadruped", json={"card": card}).raise_for_status()
    config = tmp_path / "agentrob.toml"
    config.write_text(f'[forum]\nurl = "{board.url}"\n')
    monkeypatch.setenv("AGENTROB_TOKEN", board.tokens["quadruped"])
    shown = CliRunner().invoke(cli, ["fleet", "--json", "--config", str(config)])
    assert shown.exit_code == 0, shown.output
    robot = {r["name"]: r for r in json.loads(shown.output)}["quadruped"]
    assert robot["served"]
    assert (robot["worker"], robot["failures"], robot["lag_ms"]) == ("lab-1", {"failed": 2}, 31)
    in_words = CliRunner().invoke(cli, ["fleet", "--config", str(config)], env={"COLUMNS": "200"}).output
    assert "quadruped" in in_words
    assert "failed 2" in in_words


def test_the_table_says_what_is_not_served_and_shows_cards_as_they_are() -> None:
    robots = (
        FleetRobot("rex", 2.0, "[red]lab[/red]", "0.2", "idle", 31.0, 1, 80.0, 40.2, NOW - timedelta(hours=2)),
        FleetRobot("ada", 90.0, state="idle", stop_at=NOW),
        FleetRobot("kim", None),
    )
    file = io.StringIO()
    Console(file=file, width=200).print(table(robots, NOW))
    rex, ada, kim = (
        next(line for line in file.getvalue().splitlines() if name in line) for name in ("rex", "ada", "kim")
    )
    assert "[red]lab[/red]" in rex
    assert "40 ms, 2 h ago" in rex
    assert "not served" in ada
    assert "not reached, 0 s ago" in ada
    assert "never" in kim


def test_ago() -> None:
    assert [ago(s) for s in (3.2, 120, 7200, 200_000, None)] == ["3 s ago", "2 min ago", "2 h ago", "2 d ago", "never"]
