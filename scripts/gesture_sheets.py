"""Make contact sheets of all gestures of both simulated robots, eight pictures each.

.venv/bin/python scripts/gesture_sheets.py [go2|g1] [NAME ...]

Writes docs/images/gestures-*.png. The robots' services play the gestures in full physics. The camera has the direction
of the room's overview, but is closer. For each gesture it prints the duration, how upright the body stayed and how far
it moved.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from PIL import Image, ImageDraw

from agentrob.sim.bodies.g1 import G1
from agentrob.sim.bodies.g1_gestures import GESTURES, RELEASE
from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.event_log import EventLog
from agentrob.sim.rendering.cameras import choose_backend, open_renderer
from agentrob.sim.rendering.view import View
from agentrob.sim.services import g1_sport, go2_sport
from agentrob.sim.world.legged import Array
from agentrob.sim.world.room import ROOM_GROUP
from agentrob.sim.world.scene import OPEN_FLOOR, Start, load
from agentrob.sim.world.world import PERIOD_S, ROBOT_GROUP, World

FOLDER = Path(__file__).parents[1] / "docs/images"
PICTURES, SIDE_PX, COLOURS = 8, 240, 96
FACING = Start(0.0, 0.0, -1.9)  # towards the camera, half turned
LIMIT_S = 30.0
GO2 = {
    "hello": go2_sport.HELLO,
    "heart": go2_sport.HEART,
    "stretch": go2_sport.STRETCH,
    "sit": go2_sport.SIT,
    "backflip": go2_sport.BACK_FLIP,
}
ACTIONS = {gesture.name.replace(" ", "-"): id_ for id_, gesture in GESTURES.items()}


@dataclass
class Stage:
    """One robot alone on the floor. `calls` returns the calls of a gesture; each is answered before the next."""

    world: World
    body: Any
    service: Any
    calls: Callable[[str], list[Callable[[Callable[..., None]], None]]]
    distance_m: float
    height_m: float

    def play(self, name: str) -> list[Array]:
        """The poses of the whole model, one per period, from beginning to end."""
        self.world.reset()
        self.service.reset()
        poses: list[Array] = []
        for call in self.calls(name):
            codes: list[int] = []
            call(lambda code, *_, codes=codes: codes.append(code))
            while not codes and len(poses) * PERIOD_S < LIMIT_S:
                self.service.tick()
                self.world.tick()
                poses.append(self.world.pose)
            if codes != [0]:
                raise SystemExit(f"{self.body.name} {name}: answered {codes}")
        return poses


def stage(robot: str) -> Stage:
    if robot == "go2":
        go2 = Go2(start=FACING)
        world = World([go2], OPEN_FLOOR)
        service = go2_sport.Sport(go2, lambda: world.time_s, EventLog())
        return Stage(world, go2, service, lambda n: [lambda answer: service.call(GO2[n], {}, answer)], 1.35, 0.22)
    g1 = G1(start=FACING)
    world = World([g1], OPEN_FLOOR)
    arm = g1_sport.G1Sport(g1, lambda: world.time_s, EventLog())

    def calls(name: str) -> list[Callable[[Callable[..., None]], None]]:
        wanted = [ACTIONS[name], *([RELEASE] if GESTURES[ACTIONS[name]].holds else [])]
        return [lambda answer, i=i: arm.call_arm(g1_sport.EXECUTE_ACTION, {"data": i}, answer) for i in wanted]

    return Stage(world, g1, arm, calls, 2.35, 0.72)


def near(stage: Stage, name: str) -> View:
    """A view from the direction of the room's overview camera, a little lower; further away for the backflip."""
    flies = name == "backflip"
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    overview = load("room").camera
    assert overview is not None
    dx, dy, _ = np.array(overview.to_m) - np.array(overview.at_m)
    camera.azimuth, camera.elevation = float(np.degrees(np.arctan2(dy, dx))), -15.0
    camera.lookat[:] = [FACING.x_m, FACING.y_m, stage.height_m + (0.28 if flies else 0.0)]
    camera.distance = stage.distance_m * (1.6 if flies else 1.0)
    return View(SIDE_PX, SIDE_PX, (ROOM_GROUP, ROBOT_GROUP), camera)


def sheet(stage: Stage, name: str, renderer: Any) -> None:
    poses = stage.play(name)
    chosen = np.linspace(0.06, 0.94, PICTURES) * (len(poses) - 1)
    picture = Image.new("RGB", (SIDE_PX * PICTURES // 2, SIDE_PX * 2))
    for k, index in enumerate(chosen.round().astype(int)):
        frame = Image.fromarray(np.ascontiguousarray(renderer.draw(near(stage, name), poses[index])))
        ImageDraw.Draw(frame).text((6, 4), f"{index * PERIOD_S:.1f} s", fill=(20, 20, 20))
        picture.paste(frame, (SIDE_PX * (k % (PICTURES // 2)), SIDE_PX * (k // (PICTURES // 2))))
    path = FOLDER / f"gestures-{stage.body.name}-{name}.png"
    picture.quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)
    moved_cm = 100 * float(np.hypot(*(stage.body.xy_m - [FACING.x_m, FACING.y_m])))
    root = stage.body.root_q + 3
    upright = min(1 - 2 * (pose[root + 1] ** 2 + pose[root + 2] ** 2) for pose in poses)
    sys.stdout.write(
        f"{stage.body.name} {name}: {len(poses) * PERIOD_S:.1f} s, least upright {upright:.3f}, "
        f"at the end {stage.body.upright:.3f} and {moved_cm:.0f} cm from its place, "
        f"{path.stat().st_size / 1000:.0f} kB\n"
    )


def main() -> None:
    words = sys.argv[1:]
    robots = {"go2": list(GO2), "g1": list(ACTIONS)}
    FOLDER.mkdir(parents=True, exist_ok=True)
    for robot in [words.pop(0)] if words else robots:
        shown = stage(robot)
        renderer = open_renderer(shown.world.model, choose_backend())
        for name in words or robots[robot]:
            sheet(shown, name, renderer)
        renderer.close()


if __name__ == "__main__":
    main()
