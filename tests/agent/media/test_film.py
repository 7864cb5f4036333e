"""Recordings from a camera that keeps the past: no picture of a quick gesture is missing, and no reply waits."""

from __future__ import annotations

import asyncio
import http.server
import io
import threading
import time
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest
from PIL import Image

from agentrob.agent.media import animation, film
from agentrob.agent.media.recorder import Recorder
from agentrob.config.robots import RecordingConfig
from agentrob.model import ActionResult, Op, Outcome, Primitive
from tests.agent.agent_scene import Driver, make_scene, robot_settings
from tests.agent.media.test_recorder import animated, done, report

DRAWS = True
#: As long as the simulated Go2's backflip.
FLIP_S = 1.6


class PastCamera:
    """A camera that keeps the past: a white bar moves to the right by 360 pixels a second, from `begin_s` on."""

    def __init__(self) -> None:
        self.begin_s, self.asked, self.broken = time.monotonic(), 0, False
        camera = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                camera.asked += 1
                ago_s = float(parse_qs(urlsplit(self.path).query)["ago_s"][0])
                jpeg = camera.picture(time.monotonic() - ago_s)
                self.send_response(404 if camera.broken else 200)
                self.send_header("Content-Length", str(len(jpeg)))
                self.end_headers()
                self.wfile.write(jpeg)

            def log_message(self, *_: object) -> None:
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self.server.server_address[1]}/film/go2.jpg"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def picture(self, at_s: float) -> bytes:
        left = round(min(600.0, max(0.0, 360 * (at_s - self.begin_s))))
        picture, file = Image.new("RGB", (640, 360), "black"), io.BytesIO()
        picture.paste("white", (left, 0, left + 40, 360))
        picture.save(file, "JPEG", quality=95)
        return file.getvalue()


@pytest.fixture
def camera() -> Iterator[PastCamera]:
    made = PastCamera()
    yield made
    made.server.shutdown()
    made.server.server_close()


def flip(begin_s: float) -> ActionResult:
    return ActionResult(Primitive(Op.BACKFLIP), Outcome.DONE, started_s=begin_s, ended_s=begin_s + FLIP_S)


async def test_a_backflip_has_at_least_24_different_frames_at_real_speed_and_loops(
    camera: PastCamera, tmp_path: Path
) -> None:
    recorder = Recorder(tmp_path, RecordingConfig(camera=camera.url))
    told = report((flip(camera.begin_s - FLIP_S),))
    camera.begin_s -= FLIP_S
    assert await recorder.animation(told) is None, "the report does not wait"
    webp = await recorder.late("7")
    assert webp is not None
    with Image.open(io.BytesIO(webp)) as picture:
        assert picture.size == (640, 360)
        assert picture.info["loop"] == 0, "for ever"
        bars, shown_ms = [], []
        for number in range(picture.n_frames):
            picture.seek(number)
            box = picture.convert("L").point(lambda level: 255 * (level > 128)).getbbox()
            bars.append(box[0] if box else -1)
            shown_ms.append(picture.info["duration"])
    assert len(set(bars)) >= 24
    assert bars == sorted(bars)
    assert 0.9 * FLIP_S < sum(shown_ms[:-1]) / 1000 < 1.1 * FLIP_S


async def test_where_a_reply_cannot_be_edited_it_waits_for_its_recording(camera: PastCamera, tmp_path: Path) -> None:
    recorder = Recorder(tmp_path, RecordingConfig(camera=camera.url))
    assert await recorder.animation(report((flip(camera.begin_s),)), once=True)


async def test_nothing_is_rendered_while_the_robot_moves_again(camera: PastCamera, tmp_path: Path) -> None:
    recorder = Recorder(tmp_path, RecordingConfig(camera=camera.url))
    with recorder.filming("8"):
        late = asyncio.create_task(recorder.animation(report((flip(camera.begin_s),)), once=True))
        await asyncio.wait({late}, timeout=3 * film.REST_S)
        assert camera.asked == 0
    assert await late or await recorder.late("7")
    assert camera.asked > 24


async def test_a_camera_that_is_slow_leaves_out_pictures_evenly(
    camera: PastCamera, monkeypatch: pytest.MonkeyPatch
) -> None:
    for taken in range(2, 64):
        numbers = sorted(film.coarse_first(64)[:taken])
        gaps = [after - before for before, after in pairwise([*numbers, 64])]
        assert max(gaps) <= 2 * min(gaps)
    monkeypatch.setattr(film, "FETCH_S", 0.0)
    assert len((await film.past(camera.url, camera.begin_s, camera.begin_s + 3.2, 64)).frames) < 64


async def test_a_camera_that_knows_nothing_is_asked_a_few_times_only(camera: PastCamera) -> None:
    camera.broken = True
    assert (await film.past(camera.url, camera.begin_s, camera.begin_s + 2, 40)).frames == []
    assert camera.asked == film.TRIES


def test_pictures_of_a_camera_that_follows_the_robot_are_shown_whole(camera: PastCamera) -> None:
    left = Image.new("RGB", (640, 360), "black")
    left.paste("white", (0, 0, 20, 360))
    moved = left.copy()
    moved.paste("white", (300, 160, 340, 200))
    jpegs = []
    for picture in (left, moved):
        file = io.BytesIO()
        picture.save(file, "JPEG")
        jpegs.append(file.getvalue())
    frames = [(0.0, len(jpegs[0])), (0.5, len(jpegs[1]))]
    scene = animation.Scene(1.0, [], frames=frames, follows=True)
    (*_, last) = animation._images(scene, jpegs, 8)
    assert last.convert("L").getpixel((5, 180)) > 200, "its edge is there"


def test_what_is_too_large_gets_fewer_frames_and_a_smaller_picture() -> None:
    noise = [Image.effect_noise((640, 360), 120).convert("RGB") for _ in range(24)]
    jpegs = []
    for picture in noise:
        file = io.BytesIO()
        picture.save(file, "JPEG", quality=90)
        jpegs.append(file.getvalue())
    frames = [(0.05 * n, len(jpeg)) for n, jpeg in enumerate(jpegs)]
    scene = animation.Scene(1.2, [], frames=frames, follows=True, most_bytes=350_000)
    webp = animation.draw(scene, jpegs)
    assert webp is not None
    assert len(webp) <= 350_000
    with Image.open(io.BytesIO(webp)) as picture:
        assert picture.width < 640 or picture.n_frames < 24


@pytest.fixture(scope="module")
def slow(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    made = Driver(tmp_path_factory.mktemp("slow"), robot_settings(options={"time_scale": 2}), name="quadruped")
    yield made
    made.end()


async def test_the_report_comes_first_and_its_recording_follows_by_one_edit(
    slow: Driver, camera: PastCamera, tmp_path: Path
) -> None:
    scene = make_scene(slow, tmp_path, recording={"camera": camera.url})
    async with done(scene, "@quadruped walk forward 0.8 m") as (forum, post_id):
        (reply,) = (p for p in scene.world.posts.values() if p.reply_to == post_id)
        first = await forum.post(reply.id)
        assert len(first.images) == 1, "the path"
        await animated(scene, post_id)
        later = await forum.post(reply.id)
    assert camera.asked >= 8
    assert len(later.images) == 2
    assert (later.card, later.version) == (first.card, first.version + 1)
