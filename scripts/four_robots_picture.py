"""Make the picture of four kinds of robots in one room, for the README.

    .venv/bin/python scripts/four_robots_picture.py

Writes docs/images/four-robots.webp. A Go2 and a G1 stand in the demo's room as their walking policies keep them; an
SO-101 arm and a Reachy Mini stand on its table. Reachy Mini's model is in its maker's package, which
`scripts/reachy-mini-daemon` installs.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from agentrob_so101.kinematics import MODEL as SO101
from agentrob_so101.kinematics import so101
from agentrob_so101.pose import ArmPose
from PIL import Image

from agentrob.sim.bodies.g1 import G1
from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.rendering.cameras import choose_backend, open_renderer
from agentrob.sim.rendering.view import View
from agentrob.sim.world.room import ROOM_GROUP
from agentrob.sim.world.scene import Start, load
from agentrob.sim.world.world import ROBOT_GROUP, World, specification

ROOT = Path(__file__).parents[1]
REACHY_MINI = "lib/python3.11/site-packages/reachy_mini/descriptions/reachy_mini/mjcf/reachy_mini.xml"
FILE = ROOT / "docs/images/four-robots.webp"
SIZE_PX, DRAWN_PX, QUALITY = (960, 540), (1280, 720), 80
#: Where the arm and Reachy Mini stand: x, y, height (m) and facing (degrees); the room's table is 0.72 m high.
ARM_AT, REACHY_AT = (0.95, -2.35, 0.72, 170.0), (1.0, -2.72, 0.72, 205.0)
GO2_AT, G1_AT = Start(0.3, -1.2, math.radians(240)), Start(1.0, -1.3, math.radians(210))
WAVES = ArmPose(20.0, -10.0, -20.0, -50.0, 0.0, 40.0)
#: The camera: what it looks at, its distance (m), azimuth and elevation (degrees).
LOOK_AT, DISTANCE_M, AZIMUTH_DEG, ELEVATION_DEG = (0.75, -1.85, 0.62), 2.2, 33.0, -14.0


def main() -> None:
    robots, scene = (Go2(start=GO2_AT), G1(start=G1_AT)), load("room")
    world = World(robots, scene)  # until they stand still
    spec = specification(robots, scene)
    _put(spec, SO101, "arm", ARM_AT)
    _put(spec, ROOT / ".venv-reachy-mini" / REACHY_MINI, "reachy", REACHY_AT)
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos[: world.model.nq] = world.data.qpos  # what is attached comes after the room's own robots
    for name, angle in so101().radians(WAVES).items():
        data.joint(f"arm/{name}").qpos[0] = angle
    renderer = open_renderer(model, choose_backend())
    picture = renderer.draw(_view(), np.concatenate([data.qpos, world.data.mocap_pos.ravel()]))
    renderer.close()
    image = Image.fromarray(np.ascontiguousarray(picture)).resize(SIZE_PX, Image.Resampling.LANCZOS)
    image.save(FILE, quality=QUALITY, method=6)
    sys.stdout.write(f"{FILE.relative_to(ROOT)}: {FILE.stat().st_size / 1000:.0f} kB\n")


def _put(spec: Any, model: Path, name: str, at: tuple[float, float, float, float]) -> None:
    """Attach a robot's model to the room."""
    child = mujoco.MjSpec.from_file(str(model))
    half_rad = math.radians(at[3]) / 2
    frame = spec.worldbody.add_frame(pos=at[:3], quat=(math.cos(half_rad), 0.0, 0.0, math.sin(half_rad)))
    spec.attach(child, prefix=f"{name}/", frame=frame)


def _view() -> View:
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = LOOK_AT
    camera.distance, camera.azimuth, camera.elevation = DISTANCE_M, AZIMUTH_DEG, ELEVATION_DEG
    return View(*DRAWN_PX, (ROOM_GROUP, ROBOT_GROUP), camera)


if __name__ == "__main__":
    main()
