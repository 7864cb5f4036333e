"""The simulated base in the demo: it answers a post, and its room is on its map."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from agentrob_ros2.simulated_base import ROOM
from agentrob_ros2.simulator import SCENE

from agentrob.wiring import app

AGENTROB = Path(sys.executable).with_name("agentrob")


def test_its_room_is_on_its_map_and_in_its_scene() -> None:
    settings = app.simulated_robot("ros2-sim", 41)
    assert [thing.name for thing in settings.map.things] == [one.name for one in ROOM]
    assert settings.map.size_m == (8.0, 8.0)
    assert all(one.name in SCENE for one in ROOM)


@pytest.mark.slow
@pytest.mark.sim
def test_it_answers_a_post_in_the_demo(tmp_path: Path) -> None:
    data = tmp_path / "demo"
    post = ["--post", "@ros2-sim 前进1米，然后左转90度", "--json"]
    done = subprocess.run(
        [AGENTROB, "demo", "--data", data, "--robot", "ros2-sim", *post],
        env={**os.environ, "AGENTROB_DATA": str(tmp_path)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    answer = json.loads(done.stdout)
    assert answer["status"] == "done"
    assert "完成" in answer["reply_markdown"]
    assert "measured" not in answer["reply_markdown"]
