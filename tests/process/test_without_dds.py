"""On a machine for which Cyclone DDS has no wheel, everything works but robots on DDS, whose error says why."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

#: Runs `agentrob` where the packages cyclonedds and unitree_sdk2py are not installed.
WITHOUT = """
import sys

class NotInstalled:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("cyclonedds", "unitree_sdk2py"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, NotInstalled())
sys.argv = ["agentrob", *sys.argv[1:]]
from agentrob.cli.main import main
main()
"""


def agentrob(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", WITHOUT, *words]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=100, check=False)


@pytest.mark.parametrize("words", [("driver", "rex"), ("doctor", "rex"), ("sim", "--robot", "go2")])
def test_a_robot_on_dds_is_refused_in_one_line(tmp_path: Path, words: tuple[str, ...]) -> None:
    (tmp_path / "agentrob.toml").write_text(
        'data = "./data"\n[robots.rex]\nmodel = "go2"\ninterface = "lo"\ndomain = 227\n'
    )
    done = agentrob(tmp_path, *words)
    assert done.returncode == 1, done.stdout
    assert "Traceback" not in done.stderr
    assert "robots on DDS need the package cyclonedds, which has no wheel for" in done.stderr.splitlines()[-1]
    assert "docs/forum/deploy.md" in done.stderr


def test_a_forum_and_a_plan_need_no_dds(tmp_path: Path) -> None:
    assert agentrob(tmp_path, "init", "--admin", "chief", "--data", "./data").returncode == 0
    assert agentrob(tmp_path, "board", "account", "list").stdout == "chief\thuman\tadmin\n"
    assert "direction=forward distance_m=1.0" in agentrob(tmp_path, "plan", "walk forward 1 m").stdout
    modules = "agentrob.board.server, agentrob.agent.agent, agentrob.worker.worker, agentrob.robots.driver.process"
    script = WITHOUT.partition("sys.argv")[0] + f"import {modules}\nprint('cyclonedds' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=100, check=True)
    assert done.stdout == "False\n"
