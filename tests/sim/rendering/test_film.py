"""Pictures of the past by a camera that follows a robot."""

import io
import time

import numpy as np
import pytest
from PIL import Image

from agentrob.sim.rendering import film
from agentrob.sim.rendering.cameras import Cameras
from agentrob.sim.rendering.film import Film, PoseHistory
from agentrob.sim.rendering.view import follow_view, overview

pytestmark = pytest.mark.sim


@pytest.fixture
def filming(room_bench):
    world = room_bench.world
    cameras = Cameras(world.model, {"overview": overview(world.model)}, lambda: world.pose)
    assert cameras.ready.wait(60)
    yield Film(world.model, {robot.name: robot for robot in world.robots}, cameras)
    cameras.close()


def test_only_the_last_two_minutes_are_known():
    history = PoseHistory()
    for tick in range(10_000):
        history.add(0.02 * tick, np.array([float(tick)]))
    assert history.around(0.02 * 9999 - film.KEEP_S - 1, 1.0) is None
    assert history.around(0.02 * 9999 + 60, 1.0) is None
    pose, near = history.around(0.02 * 9000, 1.0)
    assert pose == [9000.0]
    assert len(near) == 51
    assert near.mean() == pytest.approx(9000.0)


def test_poses_that_come_faster_than_any_film_are_thinned_out():
    history = PoseHistory()
    for tick in range(1000):
        history.add(0.001 * tick, np.array([float(tick)]))
    _, near = history.around(0.5, 1.0)
    assert 40 <= len(near) <= 60


def test_a_picture_shows_the_robot_where_it_was_and_not_where_it_is(filming, room_bench):
    world, robot = room_bench.world, room_bench.world.robots[0]
    before = world.pose.copy()
    filming.note(before)
    time_s = time.monotonic()
    after = before.copy()
    after[robot.root_q] += 1.0
    filming._history.add(time_s + 30.0, after)
    jpeg = filming.picture(robot.name, time.monotonic() - time_s)
    assert jpeg is not None
    with Image.open(io.BytesIO(jpeg)) as picture:
        assert picture.size == (640, 360)
        assert np.asarray(picture).std() > 20
    assert filming.picture("spot", 0.0) is None
    assert filming.picture(robot.name, 600.0) is None
    assert filming.picture(robot.name, float("nan")) is None


def test_the_camera_looks_at_the_robot_wherever_it_went_and_from_the_open_side_of_the_room(room_bench):
    model, robot = room_bench.world.model, room_bench.world.robots[0]
    for at in ((0.0, 0.0), (1.5, -1.0)):
        camera = follow_view(model, robot.build.height_m, np.array(at)).camera
        assert tuple(camera.lookat[:2]) == at
        assert 1.5 < camera.distance < 4.0
        assert 0 < camera.azimuth < 90, "the walls at the back and on the right are not drawn"
