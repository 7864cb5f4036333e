"""Pictures on demand: rendered with GL if available, otherwise by ray casting."""

import io
import os
import sys
import threading

import numpy as np
import pytest
from PIL import Image

from agentrob.sim.rendering import cameras
from agentrob.sim.rendering.cameras import Cameras
from agentrob.sim.rendering.ray_camera import RayRenderer
from agentrob.sim.rendering.view import front_view, overview

pytestmark = pytest.mark.sim


@pytest.fixture
def views(room_bench):
    model = room_bench.world.model
    return {"go2/front": front_view(model, "go2"), "overview": overview(model)}


@pytest.fixture
def looking(room_bench, views):
    there = Cameras(room_bench.world.model, views, lambda: room_bench.world.pose)
    assert there.ready.wait(60)
    yield there
    there.close()


def picture(jpeg):
    image = Image.open(io.BytesIO(jpeg))
    assert image.format == "JPEG"
    return np.asarray(image).astype(int)


def share(pixels, wanted):
    """Return the share of the pixels in which the wanted channel dominates."""
    others = [c for c in range(3) if c != wanted]
    return float((pixels[:, :, wanted] > 1.6 * pixels[:, :, others].max(axis=2)).mean())


def test_the_front_picture_is_vga_and_shows_the_red_ball_and_the_blue_box(looking):
    jpeg = looking.jpeg("go2/front")
    assert jpeg is not None
    pixels = picture(jpeg)
    assert pixels.shape == (480, 640, 3)
    assert pixels.std() > 20
    assert share(pixels, 0) > 0.001
    assert share(pixels, 2) > 0.005


def test_nobody_looks_nothing_is_drawn(looking, room_bench):
    room_bench.run(1.0)
    assert looking.drawn == 0


def test_drawing_yields_the_cores_to_physics_and_drivers(looking):
    own = os.getpriority(os.PRIO_PROCESS, 0)
    (drawing,) = [thread.native_id for thread in threading.enumerate() if thread.name == "cameras"]
    assert (os.getpriority(os.PRIO_PROCESS, drawing) > own) == (sys.platform == "linux")


def test_many_who_ask_at_once_get_the_same_picture(looking):
    got, enough = [], threading.Semaphore(0)

    def deliver(jpeg):
        got.append(jpeg)
        enough.release()

    for _ in range(20):
        looking.request("overview", deliver)
    for _ in range(20):
        assert enough.acquire(timeout=60)
    assert None not in got
    assert looking.drawn <= 3


def test_a_later_picture_shows_the_later_pose(looking, room_bench):
    before = looking.jpeg("overview")
    drawn = looking.drawn
    room_bench.walk(2.0, x=0.6)
    while looking.drawn == drawn:
        after = looking.jpeg("overview")
    assert before is not None
    assert after is not None
    assert np.abs(picture(before) - picture(after)).mean() > 0.3


def test_an_unknown_camera_gives_no_picture(looking):
    assert looking.jpeg("nowhere") is None


def test_a_picture_that_cannot_be_drawn_is_said_and_later_ones_are_drawn(room_bench, views):
    poses = [room_bench.world.pose, np.zeros(3)]
    looking = Cameras(room_bench.world.model, views, poses.pop)
    try:
        assert looking.jpeg("overview", timeout_s=30) is None
        assert "broadcast" in looking.last_error
        assert looking.jpeg("overview") is not None
    finally:
        looking.close()


@pytest.mark.parametrize("view", ["go2/front", "overview"])
def test_rays_see_what_gl_sees(room_bench, views, view):
    model, pose = room_bench.world.model, room_bench.world.pose
    pixels = RayRenderer(model).draw(views[view], pose).astype(int)
    assert pixels.shape == (views[view].height, views[view].width, 3)
    assert pixels.std() > 20
    assert share(pixels, 0) > 0.0005
    assert share(pixels, 2) > 0.003


def test_without_gl_the_cameras_fall_back_to_rays(room_bench, views, monkeypatch):
    monkeypatch.setattr(cameras.gl_probe, "BACKENDS", ("no_such_gl",))
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    looking = Cameras(room_bench.world.model, views, lambda: room_bench.world.pose)
    try:
        jpeg = looking.jpeg("go2/front", timeout_s=30)
        assert looking.backend == "ray"
        assert jpeg is not None
        assert picture(jpeg).shape == (480, 640, 3)
    finally:
        looking.close()


@pytest.mark.parametrize("value", ["off", "disable", "disabled"])
def test_mujoco_gl_can_forbid_gl(monkeypatch, value):
    monkeypatch.setenv("MUJOCO_GL", value)
    assert cameras.choose_backend() == "ray"
