"""scripts/nodebb prepares a NodeBB for a robot (against a recording); the configuration in docs/forum/nodebb.md is
valid."""

from __future__ import annotations

import asyncio
import os
import re
import sys
import tomllib
from pathlib import Path

from agentrob.config import load
from agentrob.forums.nodebb.settings import NodeBBOptions
from agentrob.model import AccountKind, Role
from tests.forums.nodebb.nodebb_world import ADMIN, NodeBBWorld

ROOT = Path(__file__).parents[3]
GUIDE = (ROOT / "docs/forum/nodebb.md").read_text(encoding="utf-8")


def test_the_configuration_of_the_guide_is_one() -> None:
    (text,) = re.findall(r"^```toml\n(.*?)^```", GUIDE, re.MULTILINE | re.DOTALL)
    forum = load.parse(tomllib.loads(text)).forum
    assert (forum.kind, NodeBBOptions.of(forum.options).operators) == ("nodebb", ("robot-operators",))


async def _run(nodebb: NodeBBWorld, *more: str) -> tuple[int, str, str]:
    script = await asyncio.create_subprocess_exec(
        sys.executable, str(ROOT / "scripts/nodebb"), nodebb.url, "--robot", "rover", *more,
        env={**os.environ, "AGENTROB_NODEBB_ADMIN": ADMIN}, stdout=-1, stderr=-1,
    )  # fmt: skip
    async with asyncio.timeout(60):
        out, err = await script.communicate()
    return script.returncode or 0, out.decode(), err.decode()


async def test_the_script_makes_a_nodebb_ready_for_a_robot(nodebb: NodeBBWorld) -> None:
    await nodebb.forget("rover")
    alice = await nodebb.sign_in("alice")
    code, told, _ = await _run(nodebb, "--operator", "alice")
    assert code == 0
    forum = load.parse(tomllib.loads(told)).forum
    (secret,) = re.findall(r"AGENTROB_TOKEN='([^']+)'", told)
    robot = nodebb.at(nodebb.url, secret)
    assert (await robot.me()).kind is AccountKind.ROBOT_AGENT
    assert (forum.kind, forum.options["operators"]) == ("nodebb", ["robot-operators"])
    assert (await alice.me()).role is Role.OPERATOR
    code, again, _ = await _run(nodebb)
    assert (code, "THE PASSWORD THAT IT HAS" in again) == (0, True), "an account that is there keeps its password"
    code, _, said = await _run(nodebb, "--operator", "nobody-at-all")
    assert (code, said) == (1, "nodebb: the forum has no account nobody-at-all; sign it up first\n")
