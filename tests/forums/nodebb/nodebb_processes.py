"""Run a driver and an agent as processes on a NodeBB, from a configuration file alone."""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path

from agentrob.model import Post
from tests.agent.agent_scene import FINAL, ROBOT
from tests.forums.nodebb.nodebb_world import GROUPS, NodeBBWorld

_CONFIG = """
data = "{data}"

[forum]
kind = "nodebb"
url = "{url}"

[forum.options]
operators = {operators}
moderators = {moderators}
robot_agents = {robot_agents}
"""

_ROBOT = """
[robots.{robot}]
model = "fake"
domain = {domain}
simulated = true
home_on_start = true
owner = "alice"
fence = {{ x_min_m = -1000.0, x_max_m = 1000.0, y_min_m = -1000.0, y_max_m = 1000.0 }}
rates = {{ cooldown_s = 0 }}
approval = {{ classes = ["gesture"] }}
options = {{ room = [-1000, 1000, -1000, 1000] }}
"""


@contextmanager
def running_robot(world: NodeBBWorld, secret: str, folder: Path) -> Iterator[Path]:
    """Start the driver and agent of a fake robot from a configuration file, as its owner would."""
    with running_robots(world, {ROBOT: secret}, folder) as config:
        yield config


@contextmanager
def running_robots(world: NodeBBWorld, secrets: Mapping[str, str], folder: Path) -> Iterator[Path]:
    """Start the drivers and agents of fake robots, each an agent of its own, by their secrets on the forum."""
    config, domain = folder / "agentrob.toml", int(os.environ["AGENTROB_TEST_DOMAIN"])
    names = {k: json.dumps(GROUPS[k]) for k in ("operators", "moderators", "robot_agents")}
    robots = [_ROBOT.format(robot=robot, domain=domain ^ number) for number, robot in enumerate(secrets)]
    config.write_text(_CONFIG.format(data=folder / "data", url=world.url, **names) + "".join(robots))
    with ExitStack() as stack:
        for robot, secret in secrets.items():
            env = {**os.environ, "AGENTROB_TOKEN": secret, "AGENTROB_RUNTIME": str(folder)}
            for what in (("driver",), ("agent", "run")):
                stack.enter_context(_process(what, robot, config, env, folder))
        yield config


@contextmanager
def _process(what: tuple[str, ...], robot: str, config: Path, env: dict[str, str], folder: Path) -> Iterator[None]:
    command = [sys.executable, "-m", "agentrob", *what, robot, "--config", str(config)]
    said = folder / f"{robot}-{what[0]}.log"
    with said.open("w") as log:
        process = subprocess.Popen(command, env=env, stdout=subprocess.PIPE, stderr=log, text=True)
        assert process.stdout is not None
        try:
            assert json.loads(process.stdout.readline() or "{}").get("ready"), said.read_text()
            yield
        finally:
            process.terminate()
            process.wait(60)
            process.stdout.close()


async def final(world: NodeBBWorld, post: Post, limit_s: float = 60.0) -> Post:
    """Return the robot's final reply to a post, as any account can read it."""
    reader = world.forums[0]
    async with asyncio.timeout(limit_s):
        while True:
            for reply in (await reader.posts(post.topic_id)).items:
                if reply.reply_to == post.id and reply.card and reply.card.state in FINAL:
                    return reply
            await asyncio.sleep(0.3)


async def answer(world: NodeBBWorld, post: Post, limit_s: float = 60.0) -> Post:
    """Return the robot's reply to a post that is not a command."""
    reader = world.forums[0]
    async with asyncio.timeout(limit_s):
        while True:
            for reply in (await reader.posts(post.topic_id)).items:
                if reply.reply_to == post.id and reply.author.name == ROBOT:
                    return reply
            await asyncio.sleep(0.3)


async def state(world: NodeBBWorld, post: Post, wanted: str, limit_s: float = 60.0) -> float:
    """Wait until the robot's status shows a state; return when, in monotonic seconds."""
    reader = world.forums[0]
    async with asyncio.timeout(limit_s):
        while True:
            replies = (await reader.posts(post.topic_id)).items
            if any(r.reply_to == post.id and r.card and r.card.state == wanted for r in replies):
                return time.monotonic()
            await asyncio.sleep(0.1)


async def replies_to(world: NodeBBWorld, post: Post) -> list[Post]:
    """Return the replies to a post, as any account can read them."""
    return [p for p in (await world.forums[0].posts(post.topic_id)).items if p.reply_to == post.id]
