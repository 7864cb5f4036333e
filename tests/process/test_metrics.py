"""Metrics are offered on an address of their own."""

from __future__ import annotations

import urllib.request

import pytest
from prometheus_client import CollectorRegistry, Counter

from agentrob.config.load import parse
from agentrob.errors import ConfigError
from agentrob.process.metrics import new_registry, serving_metrics


def test_they_are_offered_while_the_block_runs() -> None:
    registry = CollectorRegistry()
    Counter("agentrob_things", "Things.", registry=registry).inc(3)
    with serving_metrics(registry, "127.0.0.1:0") as url:
        with urllib.request.urlopen(f"{url}/metrics", timeout=10) as answer:
            assert b"agentrob_things_total 3.0" in answer.read()
        with (
            pytest.raises(ConfigError, match="cannot be offered"),
            serving_metrics(registry, url.removeprefix("http://")),
        ):
            pass
    with pytest.raises(OSError, match="refused"):
        urllib.request.urlopen(f"{url}/metrics", timeout=10)


def test_a_process_tells_its_memory() -> None:
    names = {family.name for family in new_registry().collect()}
    assert "process_resident_memory_bytes" in names


@pytest.mark.parametrize("table", ["worker", "board"])
def test_they_are_for_this_machine_unless_said_otherwise(table: str) -> None:
    with pytest.raises(ConfigError, match="allow_remote_metrics"):
        parse({table: {"metrics": "0.0.0.0:9470"}})
    with pytest.raises(ConfigError, match="host:port"):
        parse({table: {"metrics": "9470"}})
    parse({table: {"metrics": "0.0.0.0:9470", "allow_remote_metrics": True}})
    parse({table: {"metrics": "127.0.0.1:9470"}})
