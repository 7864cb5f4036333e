"""The dashboard shows metrics that exist, and the compose file runs commands that exist."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from prometheus_client import CollectorRegistry
from starlette.applications import Starlette

from agentrob.board.metrics import BoardMetrics
from agentrob.config.load import Config, load
from agentrob.process.listen import parse_listen
from agentrob.process.metrics import RequestMetrics
from agentrob.wiring.driver_metrics import DriverCollector
from agentrob.worker.metrics import WorkerMetrics
from tests.deploy.command_line import parse_command

DEPLOY = Path(__file__).parents[2] / "deploy"
METRIC = re.compile(r"\b(?:agentrob|process)_\w+")
SUFFIXES = {"counter": ("_total",), "histogram": ("_bucket", "_count", "_sum"), "gauge": ("",)}


@pytest.fixture(scope="module")
def compose() -> dict[str, Any]:
    return yaml.safe_load((DEPLOY / "compose.yaml").read_text())  # type: ignore[no-any-return]


@pytest.fixture(scope="module")
def config() -> Config:
    return load(DEPLOY / "agentrob.toml")


def exported() -> set[str]:
    """The names of all samples that board, workers and drivers offer."""
    board, worker = BoardMetrics().registry, WorkerMetrics().registry
    RequestMetrics(Starlette(), board)
    driver = CollectorRegistry()
    families = [*board.collect(), *worker.collect(), *driver.collect(), *DriverCollector("rex").describe()]
    return {family.name + suffix for family in families for suffix in SUFFIXES[family.type]}


def test_every_metric_of_the_dashboard_is_exported() -> None:
    dashboard = json.loads((DEPLOY / "grafana/agentrob.json").read_text())
    shown = {name for p in dashboard["panels"] for t in p["targets"] for name in METRIC.findall(t["expr"])}
    assert len(shown) > 15
    assert shown - exported() == set()


def test_every_metric_of_ours_is_on_the_dashboard() -> None:
    text = (DEPLOY / "grafana/agentrob.json").read_text()
    ours = {re.sub(r"_(bucket|count|sum|total)$", "", name) for name in exported() if name.startswith("agentrob_")}
    assert {name for name in ours if name not in text} == set()


def commands(compose: dict[str, Any]) -> Iterator[list[str]]:
    for service in compose["services"].values():
        if (command := service.get("command", [""]))[0] == "agentrob":
            yield command[1:]
    yield json.loads(re.findall(r"^CMD (.*)$", (DEPLOY / "Dockerfile").read_text(), re.M)[-1])[1:]


def test_every_command_of_the_compose_file_parses(compose: dict[str, Any]) -> None:
    found = list(commands(compose))
    assert len(found) == 7
    for arguments in found:
        parse_command(arguments)
    with pytest.raises(Exception, match="No such option"):
        parse_command(["agent", "run", "--everything"])


def test_the_configuration_serves_what_prometheus_scrapes(compose: dict[str, Any], config: Config) -> None:
    scraped = yaml.safe_load((DEPLOY / "prometheus.yml").read_text())["scrape_configs"]
    targets = {t for job in scraped for static in job["static_configs"] for t in static["targets"]}
    workers = [s["command"] for name, s in compose["services"].items() if name.startswith("worker-")]
    ports = {command[command.index("--metrics") + 1] for command in workers}
    ports |= {robot.metrics for robot in config.robots.values()}
    offered = {f"room:{parse_listen(listen)[1]}" for listen in ports}
    assert targets == offered | {f"board:{parse_listen(config.board.metrics)[1]}"}


def test_every_robot_has_a_driver_and_a_token(compose: dict[str, Any], config: Config) -> None:
    for robot in config.robots:
        assert compose["services"][f"driver-{robot}"]["command"][:3] == ["agentrob", "driver", robot]
        assert f"AGENTROB_TOKEN_{robot.upper()}" in compose["services"]["worker-1"]["environment"]


def test_the_files_that_the_compose_file_mounts_exist(compose: dict[str, Any]) -> None:
    mounts = [m for service in compose["services"].values() for m in service.get("volumes", ())]
    files = {mount.partition(":")[0] for mount in mounts if mount.startswith("./")}
    assert files
    assert all((DEPLOY / file).exists() for file in files)
