"""The simulated arm in the demo and for `agentrob drive`: posts in both languages, its map, and its camera."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from agentrob_so101.arm import So101
from agentrob_so101.simulator import SCENE
from PIL import Image
from so101_world import WorldProcess

from agentrob.robots.control.picture_check import picture_problem
from agentrob.wiring import app

AGENTROB = Path(sys.executable).with_name("agentrob")


def run(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    env = {**os.environ, "AGENTROB_DATA": str(folder)}
    return subprocess.run(
        [AGENTROB, *words], env=env, cwd=folder, capture_output=True, text=True, timeout=300, check=False
    )


#: Runs `agentrob` where MuJoCo is not installed.
WITHOUT_MUJOCO = """
import sys

class NotInstalled:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "mujoco":
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, NotInstalled())
sys.argv = ["agentrob", *sys.argv[1:]]
from agentrob.cli.main import main
main()
"""


def test_without_mujoco_one_line_says_what_to_install(tmp_path: Path) -> None:
    for words in (("drive", "so101", "wave"), ("demo", "--robot", "so101", "--no-browser", "--data", str(tmp_path))):
        done = subprocess.run(
            [sys.executable, "-c", WITHOUT_MUJOCO, *words], capture_output=True, text=True, timeout=100, check=False
        )
        assert done.returncode == 1
        assert "Traceback" not in done.stderr
        said = "a simulated SO-101 needs the simulator: pip install 'agentrob-so101[sim]' (it lacks mujoco)"
        assert said in done.stderr.splitlines()[-1]


def test_its_table_is_on_its_map_and_in_its_scene() -> None:
    settings = app.simulated_robot("so101", 41)
    assert [thing.name for thing in settings.map.things] == ["table", "red cube"]
    assert "red cube" in SCENE
    assert settings.map.geometry == "none"


@pytest.mark.sim
def test_it_does_not_walk_and_says_what_it_can_do(tmp_path: Path) -> None:
    for text, words in (("walk 1 m", "This robot cannot do this"), ("前进1米", "这台机器人不会：向前走1米")):
        refused = run(tmp_path, "drive", "so101", text)
        assert refused.returncode != 0
        assert words in refused.stdout + refused.stderr


@pytest.mark.sim
def test_its_camera_shows_the_arm_and_the_red_cube_also_without_gl(tmp_path: Path) -> None:
    for gl in ("", "off"):
        world = WorldProcess(tmp_path, **({"MUJOCO_GL": gl} if gl else {}))
        robot = So101(world.settings())
        try:
            jpeg = robot.look()
        finally:
            robot.close()
            world.close()
        assert picture_problem(jpeg) is None
        picture = Image.open(io.BytesIO(jpeg)).convert("RGB")
        assert picture.size == (640, 480)
        red, green, blue = np.moveaxis(np.asarray(picture), 2, 0)
        assert ((red > 110) & (green < 70) & (blue < 70)).sum() > 100, "the cube"
        assert ((red > 130) & (green > 100) & (blue < 70)).sum() > 500, "the arm"


@pytest.mark.slow
@pytest.mark.sim
@pytest.mark.parametrize(
    ("post", "done"), [("@so101 wave, then point left", "pointed left"), ("@so101 挥挥手", "完成")]
)
def test_it_answers_a_post_in_the_demo(tmp_path: Path, post: str, done: str) -> None:
    said = run(tmp_path, "demo", "--data", str(tmp_path / "demo"), "--robot", "so101", "--post", post, "--json")
    assert said.returncode == 0, said.stdout + said.stderr
    answer = json.loads(said.stdout)
    assert answer["status"] == "done"
    assert done in answer["reply_markdown"]
