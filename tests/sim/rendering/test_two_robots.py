"""Cameras of two robots and the room at the same time are rendered fast, a single camera with antialiasing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from agentrob.sim.bodies.g1 import G1
from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.rendering import cameras, ray_camera
from agentrob.sim.rendering.cameras import Cameras, open_renderer
from agentrob.sim.rendering.view import front_view, overview
from agentrob.sim.world.world import World

pytestmark = pytest.mark.sim


@pytest.fixture(scope="module")
def world() -> World:
    return World([Go2(), G1()])


class RecordingRenderer:
    """Draws nothing and records its calls."""

    name = "noting"
    smooth = True

    def __init__(self) -> None:
        self.asked: list[tuple[int, bool]] = []

    def draw(self, view: Any, _: Any) -> Any:
        self.asked.append((view.width, self.smooth))
        return np.zeros((view.height, view.width, 3), np.uint8)

    def close(self) -> None:
        pass


def test_several_cameras_at_once_are_drawn_without_smoothing(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    renderer = RecordingRenderer()
    monkeypatch.setattr(cameras, "open_renderer", lambda *_: renderer)
    monkeypatch.setattr(cameras, "FRESH_S", 0.0)
    views = {"go2": front_view(world.model, "go2"), "room": overview(world.model)}
    shown = Cameras(world.model, views, lambda: world.pose)
    try:
        assert shown.ready.wait(60), "no way of drawing was found"
        for _ in range(2):
            assert shown.jpeg("room")
        assert renderer.asked == [(800, True)] * 2
        for _ in range(2):
            assert shown.jpeg("go2")
            assert shown.jpeg("room")
        assert renderer.asked[2:] == [(640, False), (800, False)] * 2
    finally:
        shown.close()


def test_both_ways_show_the_same_room_as_it_is_now(world: World) -> None:
    renderer = open_renderer(world.model, cameras.choose_backend())
    view = overview(world.model)

    def drawn(smooth: bool, pose: Any) -> Any:
        renderer.smooth = smooth
        return renderer.draw(view, pose).astype(int)

    def differ(a: Any, b: Any) -> float:
        return float((np.abs(a - b).sum(axis=2) > 60).mean())

    there, gone = world.pose, world.pose.copy()
    gone[world.robots[1].root_q] += 100.0
    smooth, plain, smooth_gone, plain_gone, again = (
        drawn(*way) for way in ((True, there), (False, there), (True, gone), (False, gone), (True, there))
    )
    renderer.close()
    assert differ(smooth, plain) < 0.02
    assert np.array_equal(smooth, again)
    assert differ(smooth, smooth_gone) > 0.003, "the G1 is in the picture, and then it is not"
    assert differ(plain, plain_gone) > 0.003
    assert differ(smooth_gone, plain_gone) < 0.02


def test_rays_show_the_other_robot_too(world: World) -> None:
    renderer = ray_camera.RayRenderer(world.model)
    seen = renderer.draw(front_view(world.model, "go2"), world.pose).astype(int)
    away = world.pose.copy()
    away[world.robots[1].root_q] += 100.0
    gone = renderer.draw(front_view(world.model, "go2"), away).astype(int)
    assert (np.abs(seen - gone).sum(axis=2) > 60).mean() > 0.01, "one percent of the picture is the G1"
