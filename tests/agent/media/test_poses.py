"""Poses of a robot: sent while somebody watches, kept for the replay of a command, and never in the way."""

from __future__ import annotations

import asyncio
import gzip
import json
import math
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from itertools import accumulate
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.media.pose_files import MOST, PoseFiles, PoseLines
from agentrob.agent.media.poses import PoseSampler, has_moved
from agentrob.agent.media.replay import MOST_BYTES, PoseLog, PoseSample, encoded
from agentrob.agent.media.room_map import RoomMap
from agentrob.config.map import MapConfig, MapThing
from agentrob.config.robots import FenceConfig, RobotConfig
from agentrob.errors import ForumUnreachable
from agentrob.forums.protocol import PoseViewers
from agentrob.model import Direction, Op, Pose, Posture, Primitive
from tests.robots.driver_scene import Drivers
from tests.waiting import until

WALK = Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.4)
ROOM = RobotConfig(
    fence=FenceConfig(x_min_m=-1, x_max_m=3, y_min_m=-2, y_max_m=2),
    map=MapConfig(room="lab", home_at_m=(1.0, 2.0), home_facing_deg=90, things=(MapThing(at_m=(1, 1), radius_m=0.2),)),
)


class Pages:
    """A forum that shows poses; `viewers` are its viewers, `fails` makes it refuse."""

    def __init__(self) -> None:
        self.frames: list[dict[str, Any]] = []
        self.viewers, self.fails = 1, False
        self.slow = asyncio.Event()
        self.slow.set()

    async def publish_pose(self, robot: str, frame: dict[str, Any]) -> PoseViewers:
        await self.slow.wait()
        if self.fails:
            raise ForumUnreachable("not now")
        self.frames.append(frame)
        return PoseViewers(self.viewers, 0.0, True)

    async def publish_geometry(self, robot: str, geometry: bytes) -> str:
        raise AssertionError("not asked for")

    async def publish_replay(self, post_id: str, replay: bytes) -> None:
        raise AssertionError("not asked for")


@pytest.fixture
def drivers(tmp_path: Path) -> Iterator[Drivers]:
    found = Drivers(tmp_path)
    yield found
    found.close()


@asynccontextmanager
async def streaming(drivers: Drivers, pages: Pages, folder: Path) -> AsyncIterator[tuple[PoseSampler, Any]]:
    name, _ = drivers.start()
    async with drivers.client(name) as driver:
        stream = PoseSampler(pages, driver, name, RoomMap(name, ROOM), PoseFiles(folder), shaped=lambda: True)
        running = asyncio.create_task(stream.run())
        try:
            yield stream, driver
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)


async def test_poses_are_sent_only_while_somebody_watches(drivers: Drivers, tmp_path: Path) -> None:
    pages = Pages()
    async with streaming(drivers, pages, tmp_path) as (stream, driver):
        await until(lambda: not stream._wanted.is_set())
        assert not pages.frames
        stream.watch()
        await until(lambda: len(pages.frames) >= 3)
        assert pages.frames[0]["pose"] == pytest.approx([1, 2, math.pi / 2], abs=0.01), "at home in the room"
        pages.viewers = 0
        sent = len(pages.frames)
        await until(lambda: not stream._watched)
        assert len(pages.frames) <= sent + 2
        assert driver is not None


async def test_a_slow_forum_gets_the_newest_pose_and_the_others_are_dropped(drivers: Drivers, tmp_path: Path) -> None:
    pages = Pages()
    async with streaming(drivers, pages, tmp_path) as (stream, driver):
        stream.watch()
        await until(lambda: len(pages.frames) >= 1)
        pages.slow.clear()
        with stream.recording("7", [WALK]):
            async with driver.lease("me") as lease:
                result = await asyncio.wait_for(driver.step(lease, WALK, 30), 60)
        assert result.ok, "the walk does not wait for the forum"
        sampled = len(stream._logs["7"].samples)
        sent = len(pages.frames)
        pages.slow.set()
        await until(lambda: len(pages.frames) >= sent + 2)
        assert sampled > 10
        assert len(pages.frames) < sampled


class SlowDriver:
    """Each posture waits until `gives` is raised."""

    def __init__(self) -> None:
        self.gives = asyncio.Semaphore(0)

    async def posture(self, *, joints: bool = True) -> Posture:
        await self.gives.acquire()
        return Posture(0.0, Pose(0, 0, 0))


async def test_the_plan_of_a_command_is_sent_although_a_pose_from_before_it_was_sent_after_it_began(
    tmp_path: Path,
) -> None:
    pages, driver = Pages(), SlowDriver()
    stream = PoseSampler(pages, driver, "rex", RoomMap("rex", ROOM), PoseFiles(tmp_path), shaped=lambda: True)
    running = asyncio.create_task(stream.run())
    stream.watch()
    pages.slow.clear()
    driver.gives.release()
    await until(lambda: stream._newest is not None)
    await until(lambda: not stream._fresh.is_set())  # the first pose is on its way to the forum
    driver.gives.release()
    await until(stream._fresh.is_set)
    with stream.recording("7", [WALK]):
        pages.slow.set()
        await until(lambda: len(pages.frames) == 2)
        assert not any("plan" in frame for frame in pages.frames)
        driver.gives.release()
        await until(lambda: len(pages.frames) == 3)
        assert len(pages.frames[-1]["plan"]) > 1
        driver.gives.release()
        await until(lambda: len(pages.frames) == 4)
        assert "plan" not in pages.frames[-1], "once is enough"
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)


async def test_a_forum_that_fails_ends_the_sending_until_it_is_told_of_viewers_again(
    drivers: Drivers, tmp_path: Path
) -> None:
    pages = Pages()
    async with streaming(drivers, pages, tmp_path) as (stream, _):
        pages.fails = True
        stream.watch()
        await until(lambda: not stream._watched)
        pages.fails = False
        stream.watch()
        await until(lambda: len(pages.frames) >= 2)


async def test_the_replay_of_a_command_holds_its_plan_steps_and_poses(drivers: Drivers, tmp_path: Path) -> None:
    pages = Pages()
    async with streaming(drivers, pages, tmp_path) as (stream, driver):
        with stream.recording("7", [WALK]):
            await until(lambda: bool(stream._logs["7"].samples))
            async with driver.lease("me") as lease:
                stream.begin_step(WALK)
                assert (await driver.step(lease, WALK, 30)).ok
        await until(lambda: stream._running is None)
        replay = await stream.replay("7", "f" * 32)
        assert list(tmp_path.glob("7.jsonl"))
        await stream.forget("7")
        assert await stream.replay("7", "") == b""
        assert not list(tmp_path.glob("7.jsonl"))
    assert not pages.frames, "nobody watched"
    assert len(replay) < 3000
    told = json.loads(gzip.decompress(replay))
    assert told["plan"] == [[1.0, 2.0], [1.0, pytest.approx(2.4, abs=0.01)]]
    assert told["steps"][0][1] == "walk forward 0.4 m"
    assert told["geometry"] == "f" * 32
    x, y, _ = ([mm / 1000 for mm in accumulate(channel)] for channel in told["pose"])
    assert (x[0], y[0]) == pytest.approx((1, 2), abs=0.02)
    assert (x[-1], y[-1]) == pytest.approx((1, 2.4), abs=0.1)
    assert len(told["t"]) == len(x)
    assert told["map"]["fence"][0] == [3.0, 1.0]


async def test_the_replay_survives_the_agent_that_took_it(drivers: Drivers, tmp_path: Path) -> None:
    pages = Pages()
    async with streaming(drivers, pages, tmp_path) as (stream, driver):
        with stream.recording("7", [WALK]):
            await until(lambda: bool(stream._logs["7"].samples))
            async with driver.lease("me") as lease:
                stream.begin_step(WALK)
                assert (await driver.step(lease, WALK, 30)).ok
        await stream.written()
        before = json.loads(gzip.decompress(await stream.replay("7", "f" * 32)))
    with (tmp_path / "7.jsonl").open("a") as file:
        file.write('{"at":1,"pose":[0.1')  # the line that was being written
    name, _ = drivers.start("second")
    async with drivers.client(name) as driver:
        later = PoseSampler(
            pages, driver, "quadruped", RoomMap("quadruped", ROOM), PoseFiles(tmp_path), shaped=lambda: True
        )
        assert await later.left() == ["7"]
        after = json.loads(gzip.decompress(await later.replay("7", "f" * 32)))
    assert (after["plan"], after["steps"]) == (before["plan"], before["steps"])
    count = len(after["t"])
    assert count > 10
    assert after["t"] == before["t"][:count]
    assert [channel[:count] for channel in before["pose"]] == after["pose"]


def test_only_so_many_files_of_poses_are_kept(tmp_path: Path) -> None:
    files = PoseFiles(tmp_path)
    for n in range(MOST + 20):
        log = PoseLog()
        log.add(PoseSample(float(n), Pose(0, 0, 0), Posture(0.0)))
        files.append(str(n), PoseLines(log).take())
        assert len(files.left()) <= MOST
    assert files.read("0") is None
    assert files.read(str(MOST + 19)) is not None
    files.forget(str(MOST + 19))
    assert files.read(str(MOST + 19)) is None


async def test_a_disk_that_is_full_costs_a_replay_after_a_restart_and_nothing_else(
    drivers: Drivers, tmp_path: Path
) -> None:
    folder = tmp_path / "poses"
    folder.write_text("a file where the folder should be")
    async with streaming(drivers, Pages(), folder) as (stream, _):
        with stream.recording("7", [WALK]):
            await until(lambda: len(stream._logs["7"].samples) > 2)
        await stream.written()
        assert await stream.replay("7", "")


def test_a_long_replay_of_many_joints_keeps_fewer_poses() -> None:
    log = PoseLog()
    for n in range(1200):
        angles = tuple(math.sin(n / 3 + k) + math.sin(n * k * 1.7) / 50 for k in range(29))
        posture = Posture(0.0, height_m=0.8, tilt=(1.0, 0.0, 0.0, 0.0), joints_rad=angles)
        log.add(PoseSample(n / 10, Pose(n / 100, 0.0, 0.0), posture))
    replay = encoded(log, robot="humanoid")
    assert len(replay) <= MOST_BYTES
    told = json.loads(gzip.decompress(replay))
    assert sum(told["t"]) > 110_000, "it still shows the whole command"
    assert len(told["body"]) == 1 + 4 + 29
    assert encoded(PoseLog(), robot="humanoid") == b""


def test_joint_angles_that_are_missing_for_a_moment_stay_as_they_were() -> None:
    log, known = PoseLog(), Posture(0.0, height_m=0.3, tilt=(1.0, 0.0, 0.0, 0.0), joints_rad=(0.5,))
    for n, posture in enumerate((Posture(0.0), known, Posture(0.0))):
        log.add(PoseSample(float(n), Pose(0, 0, 0), posture))
    told = json.loads(gzip.decompress(encoded(log)))
    assert [list(accumulate(channel)) for channel in told["body"]][-1] == [500, 500, 500]


def test_a_robot_that_sways_has_not_moved() -> None:
    assert has_moved(None, Pose(0, 0, 0))
    assert not has_moved(Pose(0, 0, math.pi), Pose(0.02, 0.02, -math.pi + 0.05))
    assert has_moved(Pose(0, 0, 0), Pose(0, 0, 0.2))
    assert has_moved(Pose(0, 0, 0), Pose(0.1, 0, 0))
