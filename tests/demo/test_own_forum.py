"""docs/forum/own-forum.md, followed to the letter: from an empty folder to a forum of one's own with a moving robot."""

from __future__ import annotations

import asyncio
import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from agentrob.config.load import Config
from agentrob.model import Post
from agentrob.sim.domains import PrivateDomain
from agentrob.wiring import app
from tests.host_numbers import free_port

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/forum/own-forum.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```sh\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
LIMIT_S = 100


@pytest.mark.sim
@pytest.mark.slow
def test_the_commands_of_the_page_lead_to_a_walking_robot(tmp_path: Path) -> None:
    setup, *blocks = BLOCKS
    assert setup == "make setup\n. .venv/bin/activate\n", "what the tests run in already"
    domain, port = PrivateDomain(), free_port()
    script = "".join(blocks).replace("8099", str(port)).replace("domain = 1", f"domain = {domain.number}")
    script = script.replace("go2=1", f"go2={domain.number}")
    env = {**os.environ, "HOME": str(tmp_path), "XDG_RUNTIME_DIR": str(tmp_path)}
    env["PATH"] = f"{Path(sys.executable).parent}:{env['PATH']}"
    shell = subprocess.Popen(
        ["bash", "-e"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=env, start_new_session=True
    )
    try:
        assert shell.stdin
        assert shell.stdout
        shell.stdin.write(script + "\necho all done\n")
        shell.stdin.close()
        said = []
        while not said or said[-1] not in ("all done\n", ""):
            said.append(shell.stdout.readline())
        assert said[-1] == "all done\n", "".join(said)
        assert f"http://127.0.0.1:{port}/password/" in "".join(said), "the link that sets the admin's password"
        topic = next(json.loads(line)["topic"]["id"] for line in said if line.startswith('{"topic"'))
        token = (tmp_path / "my-robots/chief.token").read_text().strip()
        config = app.load(tmp_path / "my-robots/agentrob.toml")
        report = asyncio.run(final_report(config, token, topic))
    finally:
        os.killpg(shell.pid, signal.SIGTERM)
        shell.wait(60)
        domain.close()
    assert report.card
    assert report.card.state == "done", report.raw
    assert "walk forward 1 m" in report.raw
    assert report.images


async def final_report(config: Config, token: str, topic_id: str) -> Post:
    """Wait for the robot's post with a final state in this topic; return it."""
    states = {"done", "failed", "refused", "asks_back", "expired", "interrupted"}
    forum = app.make_forum(config, token)
    try:
        async with asyncio.timeout(LIMIT_S):
            async for event in forum.stream("0"):
                post = event.post
                if post and post.topic_id == topic_id and post.card and post.card.state in states:
                    return post
    finally:
        await forum.close()
    raise AssertionError("the forum ended the stream")


def test_the_first_page_says_where_the_command_is() -> None:
    """`make setup` only creates `.venv/bin/agentrob`; the other pages write `agentrob`."""
    assert ".venv/bin/activate" in (ROOT / "docs/start/index.md").read_text(encoding="utf-8")
