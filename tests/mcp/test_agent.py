"""An agent uses the forum over MCP instead of the forum's own API, by configuration alone."""

from __future__ import annotations

import asyncio
import os
import re
import subprocess
import sys
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest
from mcp.client.client import Client
from structlog.testing import capture_logs

from agentrob.config.load import Config
from agentrob.forums.memory.forum import MemoryForum
from agentrob.mcp.adapter import McpForum
from agentrob.mcp.client import ForumClient
from agentrob.mcp.forum.identity import Rights
from agentrob.model import AccountKind, Role
from agentrob.process.child import Child, terminate_all
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene, robot_settings
from tests.mcp.forum.inside import ALL, client_of, server_of
from tests.mcp.running_mcp import McpSetup
from tests.waiting import until

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples/mcp_photo.py"
CLIENT_PAGE = ROOT / "docs/agents/client.md"


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    made = Driver(tmp_path_factory.mktemp("driver"), robot_settings(options={"time_scale": 3}), name="toolbound")
    yield made
    made.end()


@asynccontextmanager
async def agent_on_mcp(
    driver: Driver, folder: Path, approval: tuple[str, ...] = (), **world: Any
) -> AsyncIterator[Scene]:
    """Run an agent that, as in production, learns the forum's features only with its first request."""
    scene = make_scene(driver, folder, MemoryForum.world(**world), poll_s=0.5, approval={"classes": approval})
    server, accounts = server_of(scene.world, ROBOT, Rights(True, ALL))
    forum = McpForum.from_client(ForumClient(lambda: Client(server.engine, cache=None)))
    try:
        async with scene.agent(forum=forum):
            yield scene
    finally:
        await server.close()
        await accounts.close()


@pytest.mark.parametrize("world", [{}, {"live": False}, {"max_edits": 0}], ids=str)
async def test_a_post_moves_the_robot_and_is_answered_on_any_kind_of_forum(
    driver: Driver, tmp_path: Path, world: dict[str, Any]
) -> None:
    async with agent_on_mcp(driver, tmp_path, **world) as scene:
        post = await scene.post("alice", f"@{ROBOT} turn left 20 degrees and take a photo")
        reply = await scene.final(post)
    assert reply.card is not None
    assert reply.card.state == "done"
    assert reply.images
    assert reply.raw.startswith(f"> [agent_type=robot agent_id={ROBOT} status=done")


@pytest.mark.parametrize("world", [{"live": False}, {"max_edits": 0}], ids=str)
async def test_law_7_a_command_with_a_preview_is_carried_out_and_ends_after_its_approval(
    driver: Driver, tmp_path: Path, world: dict[str, Any]
) -> None:
    async with agent_on_mcp(driver, tmp_path, ("move",), **world) as scene:
        scene.person("carol", Role.MODERATOR)
        post = await scene.post("alice", f"@{ROBOT} walk forward 0.3 m")
        shown = await scene.until(lambda: next((p for p in scene.replies(post) if "nothing moved" in p.raw), None))
        assert len(shown.images) == 1
        await scene.post("carol", f"@{ROBOT} approve", topic=post.topic_id, reply_to=shown.id)
        done = await scene.until(lambda: next((p for p in scene.replies(post) if "and measured: " in p.raw), None))
    assert done.card is not None
    assert done.card.state == "done", done.raw


@pytest.mark.parametrize("live", [True, False])
async def test_law_13_and_16_a_stop_is_heard_through_mcp_by_push_and_by_polling(
    driver: Driver, tmp_path: Path, live: bool
) -> None:
    async with agent_on_mcp(driver, tmp_path, live=live) as scene:
        post = await scene.post("alice", f"@{ROBOT} walk forward 5 m")
        await scene.state(post, "running")
        await scene.post("bob", f"@{ROBOT} stop")
        reply = await scene.final(post)
    assert reply.card is not None
    assert reply.card.state == "stopped"


async def test_law_16_a_forum_behind_mcp_that_falls_silent_stops_the_robot(driver: Driver, tmp_path: Path) -> None:
    async with agent_on_mcp(driver, tmp_path) as scene:
        post = await scene.post("alice", f"@{ROBOT} walk forward 5 m and walk backward 5 m")
        await scene.state(post, "running")
        scene.world.reachable = False
        async with driver.client() as client:
            await until(client.holder, lambda holder: holder is None)
        scene.world.reachable = True
        reply = await scene.final(post)
    assert reply.card is not None
    assert reply.card.state == "interrupted"


async def test_the_trace_id_of_the_asking_agent_is_in_the_robot_agents_log(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path)
    scene.person("planner", kind=AccountKind.COMMANDING_AGENT)
    with capture_logs() as logs:
        async with scene.agent(), client_of(scene.world, "planner") as client:
            wrote = await client.create_topic("robots", "A photo", f"@{ROBOT} take a photo")
            await scene.final(scene.world.posts[wrote.post.id])
    assert wrote.post.agent is not None
    assert wrote.post.agent.trace_id in [line.get("asked_in") for line in logs]


@pytest.mark.slow
def test_agent_run_uses_mcp_by_configuration_alone(setup: McpSetup, tmp_path: Path) -> None:
    """Board, MCP server over HTTP, driver and agent are separate processes."""
    setup.user("quadruped", write=True)
    facts = {
        "data": str(tmp_path / "data"),
        "robots": {
            "quadruped": robot_settings(options={"time_scale": 2}).model_dump(mode="json", exclude_defaults=True)
        },
    }
    children: list[Child] = []
    with setup.http() as url:
        config = Config.model_validate(facts | {"forum": {"kind": "mcp", "url": url}})
        config.write(tmp_path / "agent.toml")
        env = {"AGENTROB_TOKEN": "mcp-token-for-user-quadruped", "AGENTROB_RUNTIME": str(tmp_path)}
        try:
            for name, words in (("driver", ["driver"]), ("agent", ["agent", "run"])):
                arguments = [*words, "quadruped", "-c", str(tmp_path / "agent.toml")]
                children.append(Child(name, arguments, tmp_path / f"{name}.log", {**os.environ, **env}))
                children[-1].wait_ready()
            asker = setup.board.client("op")
            asked = {"board_id": "robots", "title": "Turn", "body": "@quadruped turn left 30 degrees"}
            topic = asker.post("/topics", json=asked).raise_for_status().json()["topic"]["id"]
            said = asyncio.run(_ended(asker, topic))
            shown = ask_for_a_photo(setup, tmp_path / "photo.jpg")
            (tmp_path / "transcript.txt").write_text(shown)
            printed = run_the_example_of_the_client_page(setup)
        finally:
            terminate_all(children)
    assert said[1]["author"]["name"] == "quadruped"
    assert said[1]["card"]["state"] == "done"
    assert "quadruped, robot_agent [done] (robot, status done" in shown
    assert "planner, commanding_agent (commanding, status asking, trace " in shown
    assert (tmp_path / "photo.jpg").read_bytes()[:2] == b"\xff\xd8"
    assert "quadruped **Done:** took a photo." in printed.replace("\n\n", " ")


def ask_for_a_photo(setup: McpSetup, picture: Path) -> str:
    """Run the example, an agent with its own stdio server; return its output."""
    config = setup.folder / "asker.toml"
    config.write_text(f'[forum]\nurl = "{setup.board.url}"\n')
    setup.board.add("planner", kind=AccountKind.COMMANDING_AGENT, role=Role.OPERATOR)
    command = [sys.executable, str(EXAMPLE), str(config), str(picture)]
    ended = subprocess.run(
        command, env=setup.environment("planner"), capture_output=True, text=True, timeout=100, check=False
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return ended.stdout


def run_the_example_of_the_client_page(setup: McpSetup) -> str:
    """Run it in a folder whose configuration names the forum, as the planner; return its output."""
    blocks = re.findall(r"^```python\n(.*?)^```", CLIENT_PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
    (code,) = [block for block in blocks if "ForumClient" in block]
    (setup.folder / "agentrob.toml").write_text(f'[forum]\nurl = "{setup.board.url}"\n')
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    ended = subprocess.run(
        [sys.executable, "-c", code], cwd=setup.folder, env={**setup.environment("planner"), "PATH": path},
        capture_output=True, text=True, timeout=100, check=False,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return ended.stdout


async def _ended(asker: Any, topic: str) -> list[Any]:
    """Wait until the robot's reply is final; return the posts of the topic."""
    async with asyncio.timeout(60):
        while True:
            said: list[Any] = asker.get(f"/topics/{topic}/posts").json()["items"]
            if len(said) > 1 and (said[1]["card"] or {}).get("state") in ("done", "failed", "refused", "interrupted"):
                return said
            await asyncio.sleep(0.2)
