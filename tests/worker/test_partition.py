"""Two workers that cannot see each other never move one robot twice: links between network namespaces are cut."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections import Counter
from typing import Any

import pytest

from agentrob.robots.driver.lease import TTL_S

pytestmark = pytest.mark.slow
#: By when the robot of a worker that lost the database stands; by when another worker has it.
LOST_S, TAKEN_S = 6.0, 15.0
#: By when a worker tells the end of a command whose driver it cannot reach.
TOLD_S = 30.0
#: Until a robot whose lease lapsed stands, on a busy machine.
REST_S = 1.0
LOST_DATABASE = ("database", "database and forum")


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The scene's report. Without root it runs in a user namespace of its own, under the same user id, because
    PostgreSQL refuses to run as root."""
    mine = ["--user", "--map-current-user", "--keep-caps"] if os.getuid() else []
    folder = tmp_path_factory.mktemp("partition")
    scene = ["unshare", *mine, "--net", sys.executable, "-m", "tests.worker.partition_scene", str(folder)]
    done = subprocess.run(scene, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    return json.loads(done.stdout)  # type: ignore[no-any-return]


def begun(command: dict[str, Any]) -> int:
    return sum(step["what"] == "begun" for step in command["steps"])


@pytest.mark.parametrize("lost", LOST_DATABASE)
def test_law_11_a_worker_that_loses_the_database_stops_its_robot_and_another_takes_over(
    found: dict[str, Any], lost: str
) -> None:
    case = found[lost]
    assert case["rest_s"] < LOST_S
    assert case["rest_s"] < case["taken_s"] < TAKEN_S, "it stands before another worker gets it"
    assert case["walk"]["states"] == ["interrupted"], "one final reply, and a true one"
    assert begun(case["walk"]) == 1
    for command in (case["wave"], case["again"]):
        assert (command["states"], begun(command)) == (["done"], 1)


@pytest.mark.parametrize("lost", LOST_DATABASE)
def test_law_11_the_driver_refuses_the_worker_that_lost_the_robot(found: dict[str, Any], lost: str) -> None:
    case = found[lost]
    assert case["late"] == {"number": "Fenced", "none": "Fenced"}
    assert case["new_numbers"]
    assert set(case["new_numbers"]) == {max(case["new_numbers"])}
    assert min(case["new_numbers"]) > case["old_number"]


def test_law_11_a_worker_that_loses_the_driver_keeps_the_robot_which_stops_by_the_lease(found: dict[str, Any]) -> None:
    case = found["driver"]
    assert case["rest_s"] < TTL_S + REST_S
    assert case["told_s"] < TOLD_S, "its worker does not wait for the time limit of the step"
    assert case["walk"]["states"] == ["interrupted"]
    assert len(case["wave"]["states"]) == 1
    assert begun(case["walk"]) == 1
    assert begun(case["wave"]) == (case["wave"]["states"] == ["done"])
    assert case["again"]["states"] == ["done"], "it moves again once the driver can be reached"
    numbers = {step["number"] for name in ("walk", "wave", "again") for step in case[name]["steps"]}
    assert len(numbers) == 1, "no other worker took over"


def test_law_6_no_command_reached_the_robot_twice_and_no_two_workers_moved_it_by_turns(found: dict[str, Any]) -> None:
    ledger = found["ledger"]
    counted = Counter(line["holder"] for line in ledger if line["what"] == "begun")
    assert counted
    assert set(counted.values()) == {1}
    numbers = [line["number"] for line in ledger if line["what"] == "begun"]
    assert numbers == sorted(numbers), "after a takeover only the newest worker moves it"
    moving = 0
    for line in ledger:
        moving += {"leased": 0, "begun": 1, "ended": -1}[line["what"]]
        assert moving in (0, 1), "the next step begins after the last one has ended"
    assert moving == 0
