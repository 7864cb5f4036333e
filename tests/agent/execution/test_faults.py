"""How the reply reports faults: a fall, an empty battery, a blank picture, and a long outage of the forum."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.intake import event_stream
from agentrob.agent.reporting.report import measured
from agentrob.board.robots.command_view import _step
from agentrob.forums.memory.forum import MemoryForum
from agentrob.language.goal import Aim, Goal, Subgoal
from agentrob.minds.visual_loop.claims import contradiction
from agentrob.minds.visual_loop.tools import result_message
from agentrob.model import ActionResult, Direction, Op, Outcome, Post, Primitive
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene, robot_settings
from tests.waiting import until

FaultyScene = Callable[..., Scene]


@pytest.fixture
def faulty_scene(tmp_path: Path) -> Iterator[FaultyScene]:
    """Return a scene whose robot has these faults."""
    drivers: list[Driver] = []

    def make(time_scale: float = 10, **faults: Any) -> Scene:
        options = {"time_scale": time_scale, "faults": faults}
        drivers.append(Driver(tmp_path, robot_settings(options=options)))
        return make_scene(drivers[0], tmp_path)

    yield make
    for driver in drivers:
        driver.end()


async def run_command(scene: Scene, text: str) -> Post:
    return await scene.final(await scene.post("alice", text))


async def until_speed(scene: Scene, true: Callable[[float], bool]) -> None:
    """Wait until the robot's speed meets a condition."""
    async with scene.driver.client() as robot:
        await until(robot.state, lambda state: true((state.velocity_mps or (0.0, 0.0))[0]))


async def test_a_fall_on_the_way_is_reported_in_both_languages_and_nothing_moves_until_it_is_asked_to_stand(
    faulty_scene: FaultyScene,
) -> None:
    scene = faulty_scene(fallen=True, after_m=1.0)
    async with scene.agent():
        fell = await run_command(scene, "@quadruped walk forward 3 metres, then wave")
        assert fell.card is not None
        assert fell.card.state == "failed"
        assert "**Failed** at step 1." in fell.raw
        assert "The robot has fallen. It stays down until it is asked to stand up" in fell.raw
        assert "not begun" in fell.raw
        assert "agentrob home" not in fell.raw, "this one sets its home itself"
        again = await run_command(scene, "@quadruped 向前走 1 米")
        assert again.card is not None
        assert again.card.state == "refused"
        assert "我摔倒了，有人叫我站起来之前不会动。" in again.raw
        stood = await run_command(scene, "@quadruped stand up")
        assert stood.card is not None
        assert stood.card.state == "failed", "this one cannot get up, and does not claim to"
        assert "did not get up" in stood.raw


async def test_a_low_battery_is_reported_and_ends_a_command_between_its_steps(faulty_scene: FaultyScene) -> None:
    scene = faulty_scene(battery_percent=9, after_m=0.5)
    async with scene.agent():
        first = await run_command(scene, "@quadruped walk forward 1 metre, then turn left 90 degrees")
        assert first.card is not None
        assert first.card.state == "failed"
        assert "**Failed** at step 2." in first.raw
        assert "The battery is at 9 %, and below 15 % no motion begins" in first.raw
        again = await run_command(scene, "@quadruped 向前走 1 米")
        assert again.card is not None
        assert again.card.state == "refused"
        assert "电量过低，不能动作，请给我充电。" in again.raw
        assert "battery 9 %" in (await run_command(scene, "@quadruped status")).raw


async def test_a_frozen_robot_is_reported(faulty_scene: FaultyScene) -> None:
    scene = faulty_scene(frozen=True)
    async with scene.agent():
        for text, said in (
            ("@quadruped walk forward 1 metre", "it stopped making progress"),
            ("@quadruped 向前走 1 米", "收到了指令，但没有移动。"),
        ):
            reply = await run_command(scene, text)
            assert reply.card is not None
            assert reply.card.state == "failed"
            assert said in reply.raw


@pytest.mark.parametrize(
    ("fault", "why", "said"),
    [
        ({"stale": True}, "odometry_lost", ("unknown: odometry was lost", "未知：里程计丢失")),
        ({"jump_m": 1.0}, "odometry_jump", ("unknown: odometry jumped", "未知：里程计跳变")),
    ],
)
async def test_law_18_how_far_it_went_is_unknown_where_the_odometry_was_lost_or_jumped(
    faulty_scene: FaultyScene, fault: dict[str, Any], why: str, said: tuple[str, str]
) -> None:
    """The fault is named in the reply in both languages, in the record, on the command's page, and to a steering
    model."""
    scene = faulty_scene(**fault, after_m=0.5)
    async with scene.agent():
        reply = await run_command(scene, "@quadruped walk forward 2 metres")
        assert f"| 1 | walk forward 2 m | {said[0]} | stopped |" in reply.raw
        assert f"measured unknown: its {said[0].removeprefix('unknown: ')}" in reply.raw
        assert not re.search(r"measured -?\d", reply.raw)
        (record,) = (json.loads(path.read_text()) for path in scene.folder.rglob("records/*.json"))
        assert (record["steps"][0]["measured"], record["steps"][0]["unmeasured"]) == ({}, why)
        assert _step(record["steps"][0], None).measured == f"unknown: {why.replace('_', ' ')}"
    results = [ActionResult(Primitive(Op.MOVE, Direction.FORWARD, distance_m=2.0), Outcome.STOPPED, unmeasured=why)]
    assert said[1] in measured(results[0], "zh")
    assert f'"measured": "unknown: {why}"' in result_message(results[0], None, {})
    near = Goal((Subgoal(Aim.APPROACH, "ball"),))
    assert contradiction(near, "done", "I walked 5 m", results) == "", "nobody can deny what nobody measured"


async def test_law_5_after_ten_minutes_without_a_forum_only_what_is_fresh_moves_and_all_is_reported(
    faulty_scene: FaultyScene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The clocks of the forum and of this machine advance by ten minutes; the outage itself is short."""
    scene = faulty_scene(time_scale=1)
    world = scene.world

    monkeypatch.setattr(event_stream, "elapsed_s", lambda: time.monotonic() + world.clock_offset_s)
    async with scene.agent():
        running = await scene.post("alice", "@quadruped walk forward 5 metres")
        await scene.state(running, "running")
        await until_speed(scene, lambda mps: mps > 0.1)
        world.reachable = False
        topic = world.topics[running.topic_id]
        early = world.add_post(topic, "alice", "@quadruped turn left 90 degrees", "early", ())
        await until_speed(scene, lambda mps: mps == 0.0)  # the agent stopped it, because nobody else could have
        world.clock_offset_s += 600
        late = world.add_post(topic, "alice", "@quadruped turn right 45 degrees", "late", ())
        world.reachable = True
        ended, stale, done = [await scene.final(post) for post in (running, early, late)]
        assert [p.card.state if p.card else "" for p in (ended, stale, done)] == ["interrupted", "expired", "done"]
        assert "The forum was silent, so nobody could have stopped me. Asked 5 m, measured" in ended.raw
        assert "**Too old.**" in stale.raw
        assert all(len(scene.replies(post)) == 1 for post in (running, early, late))


async def test_law_5_a_post_right_after_the_first_start_is_fresh_however_slowly_the_forum_told_its_time(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked_s = 0.0

    class SlowForum(MemoryForum):
        """Four seconds pass before it reads its clock, none afterwards."""

        async def now(self) -> tuple[str, datetime]:
            nonlocal asked_s
            asked_s += 4.0
            return await super().now()

    monkeypatch.setattr(event_stream, "elapsed_s", lambda: time.monotonic() + asked_s)
    async with scene.agent(forum=SlowForum(scene.world, ROBOT)):
        post = await scene.post("alice", f"@{ROBOT} turn left 30 degrees")
        assert (await scene.final(post)).card.state == "done"
