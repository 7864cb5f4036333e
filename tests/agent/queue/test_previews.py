"""Previews by an agent: no robot is told anything; a stop, a crash and a restart; what an approval is bound to."""

from __future__ import annotations

import gzip
import json
import os
import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.media.pictures import Picture
from agentrob.board.robots.replays import final_map
from agentrob.config.robots import RobotConfig
from agentrob.forums.memory.forum import MemoryForum
from agentrob.forums.protocol import PoseViewers
from agentrob.model import Direction, Op, Primitive, Role
from agentrob.robots import fake
from agentrob.robots.driver.process import run_driver
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene, robot_settings, set_home

DRAWS = True
PREVIEW = f"@{ROBOT} preview walk forward 1 metre, turn left and wave"
#: How long a preview may take here, where other tests use the processors.
PATIENT_S = 300.0
#: Several seconds of processor time.
LONG = f"@{ROBOT} preview walk forward 2 m, walk backward 2 m, walk forward 2 m"


def run_with_ledger(name: str, settings: RobotConfig, socket: Path, folder: Path) -> None:
    """Run a driver whose robot writes down everything that it is told; the main function of its process."""
    ledger = folder / "told.jsonl"

    class Told(fake.FakeRobot):
        def step(self, primitive: Any, watch: Any) -> Any:
            self._write("step")
            return super().step(primitive, watch)

        def command(self, velocity: Any) -> None:
            self._write("command")
            super().command(velocity)

        def stop(self) -> Any:
            self._write("stop")
            return super().stop()

        def _write(self, what: str) -> None:
            with ledger.open("a") as file:
                file.write(f"{what}\n")

    fake.FakeRobot = Told  # type: ignore[misc]  (in this process only, which finds the robot by its entry point)
    run_driver(name, settings, socket, folder)


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("driver")


@pytest.fixture(scope="module")
def driver(told: Path) -> Iterator[Driver]:
    made = Driver(told, robot_settings(), run=run_with_ledger)
    yield made
    made.end()


@pytest.fixture(autouse=True)
async def _at_home(driver: Driver) -> None:
    """Each test begins at the robot's home, which is in the middle of the room, wherever the last one left it."""
    await set_home(driver, "a test")


def simulated(driver: Driver, folder: Path, **more: Any) -> Scene:
    """A scene whose agent takes the fake robot for a Go2 in the shipped room."""
    scene = make_scene(driver, folder, model="go2", rehearsal={"world": "room", "limit_s": PATIENT_S}, **more)
    scene.person("carol", Role.MODERATOR)
    scene.limit_s = PATIENT_S
    return scene


def ledger(told: Path) -> list[str]:
    path = told / "told.jsonl"
    return path.read_text().split() if path.exists() else []


def rehearsing() -> list[str]:
    """The processes of previews that this process has started."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):  # it has ended meanwhile
            parent = int((folder / "stat").read_text().rsplit(")", 1)[1].split()[1])
            if parent == os.getpid() and "agentrob.rehearsal" in (folder / "cmdline").read_text():
                found.append(folder.name)
    return found


async def test_a_preview_answers_with_figures_and_a_picture_and_tells_the_robot_nothing(
    driver: Driver, told: Path, tmp_path: Path
) -> None:
    scene = simulated(driver, tmp_path)
    async with scene.agent():
        before = ledger(told)
        post = await scene.post("alice", PREVIEW)
        final = await scene.final(post)
        assert final.card.state == "answered", final.raw
        assert "**Preview: nothing moved.**" in final.raw
        assert "runs in the simulator, with noise, from where I stand now" in final.raw
        assert "Duration: " in final.raw
        assert "Least distance: " in final.raw
        assert "the paths of the preview" in final.raw
        assert [scene.world.pictures[name][:4] for name in final.images] == [b"\x89PNG"]
        assert ledger(told) == before  # neither a step nor a velocity, nor even a stop
        record = json.loads((scene.folder / f"agents/{ROBOT}/records/{post.id}.json").read_text())
        assert record["preview"]["basis"] == "simulation"
        assert record["steps"] == []
        walked = await scene.final(await scene.post("alice", f"@{ROBOT} walk forward 0.2 m"))
        assert walked.card.state == "done"
        assert "command" in ledger(told)[len(before) :]  # the ledger would have noticed


async def test_law_14_a_stop_ends_a_preview_and_its_process(driver: Driver, tmp_path: Path) -> None:
    scene = simulated(driver, tmp_path)
    async with scene.agent():
        post = await scene.post("alice", LONG)
        await scene.until(rehearsing)
        await scene.post("bob", "stop", topic=post.topic_id)
        final = await scene.final(post)
        assert final.card.state == "cancelled", final.raw
        await scene.until(lambda: not rehearsing())


async def test_a_preview_whose_simulation_fails_says_so(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path, model="go2", rehearsal={"world": "nowhere"})
    async with scene.agent():
        final = await scene.final(await scene.post("alice", PREVIEW))
        assert final.card.state == "answered"
        assert "The simulation ended with an error. This preview is made of geometry and limits only" in final.raw


async def test_a_preview_that_a_restart_interrupts_is_answered_once(driver: Driver, tmp_path: Path) -> None:
    scene = simulated(driver, tmp_path)
    async with scene.agent():
        post = await scene.post("alice", LONG)
        await scene.until(rehearsing)
    assert not rehearsing()
    async with scene.agent():
        final = await scene.final(post)
        assert final.card.state == "answered", final.raw
        assert "**Preview: nothing moved.**" in final.raw
    assert len(scene.replies(post)) == 1


async def test_previews_count_as_commands_for_the_rate_limit(driver: Driver, tmp_path: Path) -> None:
    rates = {"commands_per_hour": 1, "cooldown_s": 0, "waiting": 0}
    scene = make_scene(driver, tmp_path, rates=rates)
    async with scene.agent():
        first = await scene.final(await scene.post("alice", PREVIEW))
        second = await scene.final(await scene.post("alice", PREVIEW))
        assert (first.card.state, second.card.state) == ("answered", "refused"), second.raw


async def test_previews_of_one_robot_are_made_one_at_a_time(driver: Driver, tmp_path: Path) -> None:
    scene, most = simulated(driver, tmp_path), 0

    def ended() -> bool:
        nonlocal most
        most = max(most, len(rehearsing()))
        cards = [reply.card for post in posts for reply in scene.replies(post)]
        return len(cards) == 2 and all(card and card.state == "answered" for card in cards)

    async with scene.agent():
        posts = [await scene.post("alice", f"@{ROBOT} preview walk {way} 0.3 m") for way in ("forward", "backward")]
        await scene.until(ended)
    assert most == 1


# -------------------------------------------------------------------- approvals
def asks(driver: Driver, folder: Path, **more: Any) -> Scene:
    return simulated(driver, folder, approval={"classes": ["move"]}, **more)


@pytest.mark.parametrize(
    ("text", "yes", "expected"),
    [
        (
            "walk forward 0.5 m",
            "approve",
            ["Waits for approval", "**Preview: nothing moved.**", "bound to this preview"],
        ),
        ("向前走0.5米", "批准", ["等待批准", "**预演：没有任何动作。**", "与这次预演"]),
    ],
)
async def test_law_7_an_approval_is_bound_to_the_preview_that_was_shown(
    driver: Driver, tmp_path: Path, text: str, yes: str, expected: list[str]
) -> None:
    scene = asks(driver, tmp_path)
    async with scene.agent():
        post = await scene.post("alice", f"@{ROBOT} {text}")
        shown = await scene.until(
            lambda: next((p for p in scene.replies(post) if all(words in p.raw for words in expected)), None)
        )
        assert shown.card.state == "waiting"
        await scene.post("carol", f"@{ROBOT} {yes}", topic=post.topic_id)
        final = await scene.final(post)
        assert final.card.state == "done", final.raw
        record = json.loads((scene.folder / f"agents/{ROBOT}/records/{post.id}.json").read_text())
        assert record["approval"]["preview"] == record["preview"]["hash"]
        assert record["approval"]["preview"][:12] in shown.raw


async def test_law_7_a_walk_from_another_place_than_the_approved_preview_is_refused(
    driver: Driver, tmp_path: Path
) -> None:
    scene = asks(driver, tmp_path)
    async with scene.agent() as agent:
        post = await scene.post("alice", f"@{ROBOT} walk forward 0.5 m")
        await scene.until(lambda: next((p for p in scene.replies(post) if "bound to this preview" in p.raw), None))
        async with agent.driver.lease("a person at its machine") as lease:
            moved = await agent.driver.step(lease, Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.6), 20.0)
            assert moved.ok
        await scene.post("carol", f"@{ROBOT} approve", topic=post.topic_id)
        final = await scene.final(post)
        assert final.card.state == "refused", final.raw
        assert "from where the approved preview begins" in final.raw


async def test_an_approval_that_comes_before_the_preview_is_bound_to_the_post_alone(
    driver: Driver, tmp_path: Path
) -> None:
    scene = asks(driver, tmp_path)
    async with scene.agent():
        post = await scene.post("alice", LONG.replace("preview ", ""))
        await scene.until(rehearsing)
        await scene.post("carol", f"@{ROBOT} approve", topic=post.topic_id)
        final = await scene.final(post)
        assert final.card.state == "done", final.raw
        record = json.loads((scene.folder / f"agents/{ROBOT}/records/{post.id}.json").read_text())
        assert record["approval"]["preview"] == ""
        assert "preview" not in record


def test_the_picture_of_a_preview_has_a_kind_of_its_own() -> None:
    assert Picture("preview", b"").attached


# -------------------------------------------------------------------- replay, and beside what was measured
class ForumWithReplays(MemoryForum):
    """A forum that replays commands."""

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene.world, ROBOT)
        self.replays: dict[str, bytes] = {}

    async def publish_pose(self, robot: str, frame: dict[str, Any]) -> PoseViewers:
        return PoseViewers(0, 1.0, False)

    async def publish_geometry(self, robot: str, geometry: bytes) -> str:
        return "f" * 32

    async def publish_replay(self, post_id: str, replay: bytes) -> None:
        self.replays[post_id] = replay


async def test_the_page_of_a_preview_replays_a_run(driver: Driver, tmp_path: Path) -> None:
    scene = simulated(driver, tmp_path, map={"geometry": "none"})
    forum = ForumWithReplays(scene)
    async with scene.agent(forum=forum):
        post = await scene.post("alice", f"@{ROBOT} preview walk forward 0.5 m and turn left")
        await scene.final(post)
        replay = await scene.until(lambda: forum.replays.get(post.id))
    shown = final_map(replay)
    assert shown is not None
    assert shown.measured
    assert [words for _, words in json.loads(gzip.decompress(replay))["steps"]] == [
        "walk forward 0.5 m",
        "turn left 90°",
    ]


async def test_the_report_shows_the_preview_beside_what_was_measured(driver: Driver, tmp_path: Path) -> None:
    scene = asks(driver, tmp_path)
    async with scene.agent():
        post = await scene.post("alice", f"@{ROBOT} walk forward 0.5 m")
        await scene.until(lambda: next((p for p in scene.replies(post) if "bound to this preview" in p.raw), None))
        await scene.post("carol", f"@{ROBOT} approve", topic=post.topic_id)
        final = await scene.final(post)
        assert "Preview and measured: " in final.raw
        apart = re.search(r"It ended (\d\.\d\d) m from where the preview did", final.raw)
        assert apart
        assert float(apart[1]) < 0.2
        assert "the paths of the preview" in final.raw
