"""Every benchmark of understanding runs with a small load and prints figures."""

from __future__ import annotations

import re

import pytest

from tests.benchmarks.small import READING, run

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]


@pytest.mark.parametrize("name", READING)
def test_a_benchmark_of_understanding_runs_and_prints_figures(name: str) -> None:
    printed = run(name)
    assert re.search(r"\d", printed) or "absent" in printed
