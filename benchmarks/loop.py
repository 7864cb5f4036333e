"""Measure our own share of the time of one turn when a model steers a robot by its camera.

    python benchmarks/loop.py [--turns 100] [--camera 640x480]

The model is a server on loopback, in its own process, that answers immediately; the robot is a fake one in its driver
process, with a camera of 640 x 480 like the simulated Go2's (scaling down pictures beyond 1024 pixels counts as ours).
A turn is a question with two pictures, the check of the call, of post, rights, limits and mandate, a step and a picture
through the driver, and the returned result. Times are wall times without the model's own time, measured by the
server, and without that of the robot and its camera, measured where the driver calls them
(including the guard's checks during a step). The rest of the driver is counted.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from instruments.loopback_model import HEAD, loopback_model, row, served_s

from agentrob.agent.execution.execute import ExecutionHooks
from agentrob.agent.execution.visual import run_visual_task
from agentrob.agent.intake.authorization import CommandTerms, permission
from agentrob.agent.understanding.visual_goal import visual_task_of
from agentrob.config.minds import MindConfig
from agentrob.config.robots import LookConfig
from agentrob.forums.memory.forum import MemoryForum
from agentrob.language.goal import Aim, Goal, Subgoal
from agentrob.minds.llm.chat import Answer, Message, ModelReply, Tool
from agentrob.minds.llm.fallback import FallbackModel
from agentrob.minds.llm.model import ConfiguredModel
from agentrob.model import ActionResult, Command, Primitive, Role
from agentrob.robots.driver.client import DriverClient

CALLED = """
side = ["left", "right"]
def called(body):
    side.reverse()
    return "act_turn", {"direction": side[0], "degrees": 5, "look": True}
"""
DRIVER = """
import io, json, sys
from pathlib import Path
from PIL import Image
from agentrob.config.robots import RobotConfig
from agentrob.robots.driver.process import run_driver
from agentrob.robots.fake import FakeRobot
out = io.BytesIO()
width, height = map(int, sys.argv.pop().split("x"))
Image.effect_noise((width // 8, height // 8), 40).resize((width, height)).convert("RGB").save(out, "JPEG", quality=80)
FakeRobot._picture = lambda self: out.getvalue()
name, settings, socket, data = sys.argv[1:]
run_driver(name, RobotConfig.model_validate(json.loads(settings)), Path(socket), Path(data))
"""
ROBOT = "quadruped"
SETTINGS = {
    "model": "fake", "simulated": True, "home_on_start": True, "domain": 1 + os.getpid() % 230,
    "options": {"time_scale": "inf"}, "fence": {"x_min_m": -90, "x_max_m": 90, "y_min_m": -90, "y_max_m": 90},
}  # fmt: skip


class TimedDriver(DriverClient):
    """Counts the seconds that the robot and its camera took, as measured in the driver's process. The transfer both
    ways, the guard before and after, and the transfer of the picture count as ours."""

    spent_s = 0.0

    async def step(self, lease: str, primitive: Primitive, deadline_s: float) -> ActionResult:
        result = await super().step(lease, primitive, deadline_s)
        self.spent_s += result.duration_s
        return result


class Began(NamedTuple):
    """When a question began, and the time that the robot and this process had used until then."""

    at_s: float
    robot_s: float
    cpu_s: float


class TimedEyes(FallbackModel):
    """Records when each question to the model begins; a turn is the time from one to the next."""

    def __init__(self, model: ConfiguredModel, driver: TimedDriver) -> None:
        super().__init__([model])
        self.began: list[Began] = []
        self._driver = driver

    async def turn(
        self, system_prompt: str, conversation: Sequence[Message], tools: Sequence[Tool], spent: Any = ()
    ) -> Answer[ModelReply]:
        self.began.append(Began(time.perf_counter(), self._driver.spent_s, time.process_time()))
        return await super().turn(system_prompt, conversation, tools, spent)


async def _measure(port: int, turns: int, socket: Path, folder: Path) -> tuple[list[float], list[float]]:
    """Seconds of our own in each turn (still including the server's time), and processor seconds of this process."""
    world = MemoryForum.world()
    author = world.sign_in("alice", role=Role.OPERATOR)
    post = (await author.create_topic("robots", "A topic", f"@{ROBOT} turn towards the door", key="k")).post
    command = Command(
        post.id, post.topic_id, post.content_hash, post.author, ROBOT, post.raw, "en", datetime.now(UTC), "trace"
    )
    config = MindConfig(provider="compatible", model="m", base_url=f"http://127.0.0.1:{port}/v1")
    most = config.limits.model_copy(update={"day_tokens": 0, "command_tokens": 0})
    model = ConfiguredModel("bench", config.model_copy(update={"limits": most}), folder / "minds.sqlite")
    await model.prepare()
    found: list[float] = []
    cpu: list[float] = []
    async with TimedDriver(ROBOT, socket) as driver:
        capabilities = await driver.capabilities()
        while len(found) < turns:
            eyes = TimedEyes(model, driver)
            visual_task = visual_task_of(
                Goal((Subgoal(Aim.FACE, "door"),)), eyes, capabilities, LookConfig(pictures=20), "en"
            )
            hooks = _hooks(driver, partial(permission, author, driver, command, CommandTerms()))
            await run_visual_task(driver, command, visual_task, hooks)
            pairs = zip(eyes.began[1:-1], eyes.began[2:-1], strict=False)  # the first turns open connections
            for a, b in pairs:
                found.append((b.at_s - a.at_s) - (b.robot_s - a.robot_s))
                cpu.append(b.cpu_s - a.cpu_s)
    await model.close()
    return found, cpu


def _hooks(driver: DriverClient, permit: Any) -> ExecutionHooks:
    async def since() -> float:
        return time.monotonic()

    async def alive() -> bool:
        return True

    return ExecutionHooks(
        since=since, permit=permit, ended=lambda: None, alive=alive, silent=lambda: False, stop=driver.stop,
        on_step=lambda *_: None,
    )  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--turns", type=int, default=100)
    parser.add_argument("--camera", default="640x480")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        socket = folder / "robot.sock"
        started = [sys.executable, "-c", DRIVER, ROBOT, json.dumps(SETTINGS), str(socket), name, given.camera]
        with loopback_model(CALLED) as port:
            driver = subprocess.Popen(started, stdout=subprocess.PIPE, text=True)
            try:
                assert driver.stdout is not None
                assert driver.stdout.readline()
                seconds, cpu = asyncio.run(_measure(port, given.turns, socket, folder))
                model_s = statistics.median(served_s(port))
            finally:
                driver.terminate()
                driver.wait()
    print(HEAD)
    print(row("our own part of a turn of the loop", [s - model_s for s in seconds]))
    print(row("of this on the agent's processor", cpu))


if __name__ == "__main__":
    main()
