"""An agent that is ready has imported what it needs: an import, even in a thread, would delay a stop."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from tests.agent.agent_scene import Driver, robot_settings

#: A whole command with its pictures in a separate process; prints what was imported after the agent was ready.
SCRIPT = """
import asyncio, sys
from pathlib import Path
from tests.agent.agent_scene import Driver, Scene, robot_settings
from agentrob.forums.memory.forum import MemoryForum
from agentrob.robots.driver.client import DriverClient

class Running(Driver):
    def __init__(self, socket):
        self.name, self.socket = "quadruped", Path(socket)

async def main():
    scene = Scene(MemoryForum.world(), Running(sys.argv[1]), Path(sys.argv[2]), robot_settings())
    scene.person("alice")
    async with scene.agent():
        known = set(sys.modules)
        for text in ("walk forward 1 m, then take a photo", "前进一千零五厘米", "walk a hundred and five centimetres"):
            await scene.final(await scene.post("alice", "@quadruped " + text))
        print("\\n".join(sorted(set(sys.modules) - known)))

asyncio.run(main())
"""


def test_law_15_no_library_is_first_imported_while_an_agent_serves(tmp_path: Path) -> None:
    driver = Driver(tmp_path, robot_settings())
    (tmp_path / "agent").mkdir()
    try:
        ended = subprocess.run(
            [sys.executable, "-c", SCRIPT, str(driver.socket), str(tmp_path / "agent")],
            capture_output=True, text=True, timeout=100, env=dict(os.environ), check=False,
        )  # fmt: skip
    finally:
        driver.end()
    assert ended.returncode == 0, ended.stderr[-3000:]
    late = {name.partition(".")[0] for name in ended.stdout.split()} - sys.stdlib_module_names
    assert not late, ended.stdout
