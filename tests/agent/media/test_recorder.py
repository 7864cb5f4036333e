"""The recording of a command: its data and its animation, and that neither can delay or lose anything."""

from __future__ import annotations

import asyncio
import io
import json
import math
import os
import re
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from agentrob.agent.media import animation, film, recorder
from agentrob.agent.media.film import MANY, Film
from agentrob.agent.media.recorder import Recorder, prune
from agentrob.agent.media.track import clips, lines, samples
from agentrob.config.load import parse
from agentrob.config.robots import RecordingConfig, RobotConfig
from agentrob.errors import ConfigError, ForumError, RobotBusy, RobotError
from agentrob.forums.memory.forum import MemoryForum
from agentrob.forums.protocol import Forum
from agentrob.model import (
    Account,
    ActionResult,
    Command,
    CommandState,
    Direction,
    Op,
    Outcome,
    Plan,
    Post,
    Primitive,
    Report,
)
from agentrob.robots.fake import FakeRobot
from tests.agent.agent_scene import Driver, Scene, make_scene, robot_settings
from tests.waiting import until

DRAWS = True

MOVE = Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0, speed_mps=0.5)
TURN = Primitive(Op.TURN, Direction.LEFT, degrees=90)
ASIDE = Primitive(Op.MOVE, Direction.LEFT, distance_m=1.0, speed_mps=0.9)
WAVE = Primitive(Op.HELLO)


@pytest.fixture(scope="module")
def walked() -> tuple[ActionResult, ...]:
    """Return a fake robot's path in virtual time, with its times mapped to the real clock."""
    robot = FakeRobot(RobotConfig(model="fake", options={"time_scale": math.inf}))
    at_s, results = 1000.0, []
    for step in (MOVE, TURN, ASIDE):
        result = robot.step(step, lambda _: None)
        end_s = at_s + result.path[-1][0]
        results.append(replace(result, started_s=at_s, ended_s=end_s))
        at_s = end_s + 0.2
    return tuple(results)


def report(results: tuple[ActionResult, ...], post: str = "7") -> Report:
    command = Command(post, "3", "", Account("1", "alice"), "quadruped", "", "en", datetime.now(UTC), "t1")
    return Report(command, CommandState.DONE, plan=Plan(tuple(r.primitive for r in results)), results=results)


def jpeg(color: str = "red", dot: tuple[int, int] | None = None, size: tuple[int, int] = (640, 360)) -> bytes:
    picture = Image.new("RGB", size, color)
    if dot:
        picture.paste("white", (*dot, dot[0] + 40, dot[1] + 40))
    file = io.BytesIO()
    picture.save(file, "JPEG", quality=90)
    return file.getvalue()


# -------------------------------------------------------------------- data
def test_the_data_pairs_what_was_commanded_with_what_was_measured_at_each_moment(
    walked: tuple[ActionResult, ...],
) -> None:
    lines_read = list(lines(walked, post="7"))
    assert json.loads(json.dumps(lines_read)) == lines_read
    assert lines_read[0]["post"] == "7"
    times = [line["t"] for line in lines_read[1:]]
    assert times == sorted(times)
    moving = [line for line in lines_read if line.get("step") == 1 and "pose" in line]
    fastest = max(moving, key=lambda line: line["commanded"][0])
    assert fastest["commanded"][0] == pytest.approx(0.5)
    assert max(line["measured"][0] for line in moving) == pytest.approx(0.5, abs=0.05)
    turning = [line for line in lines_read if line.get("step") == 2 and "pose" in line]
    assert max(line["measured"][2] for line in turning) == pytest.approx(math.radians(45), abs=0.1)
    ends = [line for line in lines_read if line.get("event") == "end"]
    assert [end["outcome"] for end in ends] == ["done"] * 3


def test_velocities_are_in_the_frame_of_the_body(walked: tuple[ActionResult, ...]) -> None:
    """After the turn, "left" is backwards in the odometry's frame, and is still reported as left."""
    aside = [s for s in samples(walked) if s.step == 3]
    assert max(s.measured.left_mps for s in aside) > 0.25
    assert max(abs(s.measured.forward_mps) for s in aside) < 0.1
    assert aside[-1].pose.x_m < aside[0].pose.x_m - 0.9


def test_law_18_a_step_that_a_bound_held_down_is_reported_as_slower(walked: tuple[ActionResult, ...]) -> None:
    (clip,) = clips(walked)
    assert (clip.step, clip.asked_mps) == (3, 0.9)
    assert clip.commanded_mps == pytest.approx(0.3, abs=0.02)  # the fake's gait is slower sideways
    (event,) = (line for line in lines(walked) if line.get("event") == "clipped")
    assert event["commanded_mps"] == clip.commanded_mps


def test_a_short_step_that_never_reached_its_speed_was_not_held_down() -> None:
    robot = FakeRobot(RobotConfig(model="fake", options={"time_scale": math.inf}))
    short = robot.step(Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.12, speed_mps=0.5), lambda _: None)
    assert max(c[1] for c in short.commanded) < 0.45
    assert clips((short,)) == ()


# -------------------------------------------------------------------- animation
def test_without_a_camera_the_way_is_animated_on_a_map(walked: tuple[ActionResult, ...]) -> None:
    scene, pictures = recorder._scene(walked, Film())
    read, _ = animation.read_scene(io.BytesIO(animation.write_scene(scene, pictures)))
    assert read.steps == [[1.0, "m"], [90, "°"], [1.0, "m"]]
    webp = animation.draw(scene, pictures)
    assert webp is not None
    assert len(webp) <= animation.MAX_BYTES
    with Image.open(io.BytesIO(webp)) as picture:
        assert picture.format == "WEBP"
        assert picture.size == (640, 476)
        assert 8 <= picture.n_frames <= animation.MAX_FRAMES
        first = picture.convert("RGB")
        picture.seek(picture.n_frames - 1)
        assert picture.convert("RGB").tobytes() != first.tobytes()


def test_a_camera_s_pictures_are_shown_near_to_what_moves() -> None:
    """A small dot that moves through a large room is enlarged."""
    seen = [Image.open(io.BytesIO(jpeg("black", (300 + 8 * k, 150)))).convert("RGB") for k in range(6)]
    shown = animation._near(seen, (480, 270))
    bright, plain = (sum(picture.convert("L").histogram()[128:]) for picture in (shown[0], seen[0].resize((480, 270))))
    assert bright > 3 * plain
    still = animation._near([seen[0], seen[0]], (480, 270))
    assert len(still) == 2


def test_a_gesture_seen_by_a_camera_is_animated_without_a_way() -> None:
    seen = Film([(1000.0 + k, jpeg("blue", (100 + 20 * k, 100))) for k in range(4)])
    scene, pictures = recorder._scene((ActionResult(WAVE, Outcome.DONE, started_s=1000, ended_s=1004),), seen)
    webp = animation.draw(scene, pictures)
    assert webp is not None
    with Image.open(io.BytesIO(webp)) as picture:
        assert picture.size == (640, 360)


def test_noise_that_does_not_compress_still_fits(walked: tuple[ActionResult, ...]) -> None:
    noise = [Image.effect_noise((640, 360), 200).convert("RGB") for _ in range(3)]
    seen = Film([(1000.0 + 0.1 * k, _jpeg_of(noise[k % 3])) for k in range(48)])
    scene, pictures = recorder._scene(walked, seen)
    webp = animation.draw(replace(scene, seconds=10.0), pictures)
    assert webp is None or len(webp) <= animation.MAX_BYTES


def _jpeg_of(picture: Image.Image) -> bytes:
    file = io.BytesIO()
    picture.save(file, "JPEG", quality=95)
    return file.getvalue()


def test_a_film_stays_small_and_even_however_long_a_command_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    made, now_s = Film(), 0.0
    monkeypatch.setattr(film.time, "monotonic", lambda: now_s)
    for k in range(6000):  # a minute at 100 pictures a second
        now_s = k / 100
        made.add(b"%d" % k)
    assert MANY / 2 <= len(made.frames) <= MANY
    gaps = [b[0] - a[0] for a, b in zip(made.frames, made.frames[1:], strict=False)]
    assert max(gaps) < 2.1 * min(gaps)
    made.add(b"x" * (2**20 + 1))
    assert all(len(picture) < 10 for _, picture in made.frames)


async def test_a_drawing_process_that_fails_or_says_nonsense_gives_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    assert await recorder._drawn(b"{}\n") is None
    monkeypatch.setattr(recorder.sys, "executable", "/bin/echo")
    assert await recorder._drawn(b"whatever") is None


async def test_a_drawing_that_takes_too_long_ends_with_the_wait_for_it(
    walked: tuple[ActionResult, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    slow = tmp_path / "slow"
    slow.write_text(f"#!/bin/sh\necho $$ > {tmp_path}/pid\nexec sleep 60\n")
    slow.chmod(0o755)
    monkeypatch.setattr(recorder.sys, "executable", str(slow))
    monkeypatch.setattr(recorder, "DRAW_S", 0.3)
    monkeypatch.setattr(recorder, "LATE_S", 0.3)
    records = Recorder(tmp_path / "recordings", RecordingConfig())
    begun_s = time.monotonic()
    assert await records.animation(report(walked)) is None
    assert await records.late("7") is None
    assert time.monotonic() - begun_s < 5
    pid = int((tmp_path / "pid").read_text())
    async with asyncio.timeout(60):
        while Path(f"/proc/{pid}").exists():
            await asyncio.wait({asyncio.ensure_future(asyncio.to_thread(os.sched_yield))})
    assert records.file("7").exists(), "the data is kept all the same"


async def test_when_the_recorder_is_closed_no_drawing_is_left_not_even_one_that_was_given_up(
    walked: tuple[ActionResult, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    slow = tmp_path / "slow"
    slow.write_text(f"#!/bin/sh\necho $$ >> {tmp_path}/pids\nexec sleep 60\n")
    slow.chmod(0o755)
    monkeypatch.setattr(recorder.sys, "executable", str(slow))
    monkeypatch.setattr(recorder, "DRAW_S", 0.0)
    records = Recorder(tmp_path / "recordings", RecordingConfig())
    for post in ("7", "8"):
        walk = report(walked)
        assert await records.animation(replace(walk, command=replace(walk.command, post_id=post))) is None
    async with asyncio.timeout(60):
        await until(lambda: (tmp_path / "pids").exists() and len((tmp_path / "pids").read_text().split()) >= 2)
        records.forget("7")
        await records.close()
    assert not any(Path(f"/proc/{pid}").exists() for pid in (tmp_path / "pids").read_text().split())


async def test_a_disk_that_is_full_costs_only_the_recording(walked: tuple[ActionResult, ...], tmp_path: Path) -> None:
    blocked = tmp_path / "recordings"
    blocked.write_text("a file where the folder should be")
    assert await Recorder(blocked, RecordingConfig()).animation(report(walked)) is None


# -------------------------------------------------------------------- keeping
def test_what_is_old_or_too_much_goes_the_oldest_first(tmp_path: Path) -> None:
    for age, name in enumerate("abcde"):
        (tmp_path / name).write_bytes(b"x" * 2**19)
        os.utime(tmp_path / name, (time.time() - age * 86400,) * 2)
    prune(tmp_path, keep_days=3.5, keep_mb=100)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a", "b", "c", "d"]
    prune(tmp_path, keep_days=30, keep_mb=1)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a", "b"]
    prune(tmp_path, keep_days=0, keep_mb=0)
    assert list(tmp_path.iterdir()) == []


def test_many_small_files_count_as_what_they_take_on_the_disk(tmp_path: Path) -> None:
    for age in range(300):
        (tmp_path / f"{age:03}").write_bytes(b"x")
        os.utime(tmp_path / f"{age:03}", (time.time() - age,) * 2)
    prune(tmp_path, keep_days=30, keep_mb=1)
    assert sorted(p.name for p in tmp_path.iterdir()) == [f"{age:03}" for age in range(256)]


def test_a_wrong_view_says_what_would_be_valid() -> None:
    with pytest.raises(ConfigError, match="'auto', 'room', 'robot', 'path' or 'none'"):
        parse({"robots": {"spot": {"recording": {"view": "everything"}}}})


# -------------------------------------------------------------------- the whole
@pytest.fixture(scope="module")
def slow(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    made = Driver(tmp_path_factory.mktemp("slow"), robot_settings(options={"time_scale": 2}), name="quadruped")
    yield made
    made.end()


@asynccontextmanager
async def done(scene: Scene, text: str) -> AsyncIterator[tuple[Forum, str]]:
    async with scene.agent():
        post = await scene.post("alice", text)
        await scene.final(post)
        yield scene.world.sign_in("alice"), post.id


async def animated(scene: Scene, post_id: str) -> bytes:
    """Return the animation, which may come after the reply."""

    def found() -> bytes | None:
        replies = [p for p in scene.world.posts.values() if p.reply_to == post_id]
        shown = [scene.world.pictures[url] for p in replies for url in p.images]
        return next((data for data in shown if data.startswith(b"RIFF")), None)

    webp: bytes = await scene.until(found)
    (reply,) = (p for p in scene.world.posts.values() if p.reply_to == post_id)
    assert "a recording" in reply.raw
    return webp


async def test_a_reply_shows_the_animation_and_the_record_names_the_data(slow: Driver, tmp_path: Path) -> None:
    scene = make_scene(slow, tmp_path)
    async with done(scene, "@quadruped walk forward 0.8 m") as (_, post_id):
        webp = await animated(scene, post_id)
    with Image.open(io.BytesIO(webp)) as picture:
        assert picture.n_frames > 3
    record = json.loads((scene.folder / "agents/quadruped/records" / f"{post_id}.json").read_text())
    data = Path(record["recording"]).read_text().splitlines()
    assert len(data) > 10
    assert Path(record["recording"]).parent.stat().st_mode & 0o077 == 0, "nobody else on this machine may read it"


async def test_a_drawing_that_takes_long_does_not_delay_the_reply_and_follows_it(
    slow: Driver, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder, "DRAW_S", 0.0)
    scene = make_scene(slow, tmp_path)
    async with done(scene, "@quadruped walk forward 0.8 m") as (forum, post_id):
        (reply,) = (p for p in scene.world.posts.values() if p.reply_to == post_id)
        first = await forum.post(reply.id)
        assert len(first.images) == 1, "the path"
        assert "a recording" not in first.raw
        await animated(scene, post_id)
        later = await forum.post(reply.id)
    assert len(later.images) == 2
    assert later.card == first.card


class EndedByAnotherForum(MemoryForum):
    """A forum on which another agent of the same account wrote the end while this one drew."""

    looks = 0

    async def post(self, post_id: str) -> Post:
        found = await super().post(post_id)
        if found.card is None or found.card.state != "running":
            return found
        self.looks += 1
        return replace(found, card=replace(found.card, state="done", trace_id="of another"))


async def test_a_drawing_that_no_reply_will_show_is_given_up(
    slow: Driver, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder, "DRAW_S", 0.0)
    scene = make_scene(slow, tmp_path)
    forum = EndedByAnotherForum(scene.world, "quadruped")
    async with scene.agent(forum=forum) as agent:
        await scene.post("alice", "@quadruped walk forward 0.8 m")
        await scene.until(lambda: forum.looks)
        await scene.until(lambda: not agent.live_view.recorder._drawing)


class StillsOnlyForum(MemoryForum):
    """A forum that rejects animations."""

    async def edit(self, post_id: str, body: str, **more: Any) -> Post:
        if any(image.startswith(b"RIFF") for image in more.get("images", ())):
            raise ForumError("415: a JPEG or PNG file")
        return await super().edit(post_id, body, **more)


async def test_a_forum_that_takes_no_moving_pictures_gets_the_stills(slow: Driver, tmp_path: Path) -> None:
    scene = make_scene(slow, tmp_path)
    forum = StillsOnlyForum(scene.world, "quadruped")
    async with scene.agent(forum=forum):
        reply = await scene.final(await scene.post("alice", "@quadruped walk back 0.8 m"))
    assert reply.card is not None
    assert reply.card.state == "done"
    assert len(reply.images) == 1


async def test_the_robot_s_own_camera_is_looked_through_only_where_its_owner_says_so(
    slow: Driver, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scenes: list[bytes] = []
    drawn = recorder._drawn

    async def seen(scene: bytes) -> bytes | None:
        scenes.append(scene)
        return await drawn(scene)

    monkeypatch.setattr(recorder, "_drawn", seen)
    for view, expected in (("auto", 0), ("robot", 2)):
        scene = make_scene(slow, tmp_path / view, recording={"view": view})
        async with done(scene, "@quadruped walk forward 0.8 m"):
            pass
        frames = re.search(rb'"frames": (\[.*?\]\]|\[\])', scenes[-1])
        assert frames is not None
        assert len(json.loads(frames[1])) >= expected
        assert expected or json.loads(frames[1]) == []


async def test_a_camera_that_fails_loses_the_pictures_and_nothing_else(
    slow: Driver, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def broken(_: object) -> bytes:
        raise RobotError("the camera is dead")

    monkeypatch.setattr("agentrob.robots.driver.client.DriverClient.look", broken)
    scene = make_scene(slow, tmp_path, recording={"view": "robot"})
    async with done(scene, "@quadruped walk forward 0.8 m") as (_, post_id):
        assert await animated(scene, post_id)


async def test_law_11_a_look_needs_no_lease_moves_nothing_and_is_refused_when_too_often(slow: Driver) -> None:
    async with slow.client() as looker, slow.client() as other, other.lease("somebody else") as lease:
        step = asyncio.create_task(other.step(lease, MOVE, 20.0))
        picture = await looker.look()
        with pytest.raises(RobotBusy, match=r"every 0\.4 s"):
            await looker.look()
        assert picture.startswith(b"\xff\xd8")
        assert await looker.holder() == "somebody else"
        assert (await step).ok


async def test_law_15_a_stop_is_as_fast_while_the_camera_is_looked_through_and_a_drawing_runs(
    slow: Driver, tmp_path: Path
) -> None:
    scene = make_scene(slow, tmp_path, recording={"view": "robot"})
    async with scene.agent() as agent:
        await scene.final(await scene.post("alice", "@quadruped walk back 0.8 m"))  # it may still be drawn
        running = await scene.post("alice", "@quadruped walk forward 5 m")
        await scene.state(running, "running")
        await scene.until(
            lambda: agent.live_view.recorder._running and len(agent.live_view.recorder._running.frames) > 1
        )
        await scene.post("bob", "stop", running.topic_id)
        reply = await scene.final(running)
    assert reply.card is not None
    assert reply.card.state == "stopped"
    latency_ms = float(re.search(r"(\d+(\.\d+)?) ms", reply.raw)[1])  # type: ignore[index]
    assert latency_ms <= 50
