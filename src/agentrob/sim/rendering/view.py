"""Camera views of the world, and the renderer protocol."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import mujoco
import numpy as np
from numpy.typing import NDArray

from agentrob.sim.world import room
from agentrob.sim.world.legged import Array
from agentrob.sim.world.world import ROBOT_GROUP

Picture = NDArray[np.uint8]  # (height, width, 3)


@dataclass(frozen=True, slots=True)
class View:
    """One camera: size of its picture, the geom groups it sees, and its pose in MuJoCo's terms."""

    width: int
    height: int
    groups: tuple[int, ...]
    camera: Any


def front_view(model: Any, robot: str) -> View:
    """The view of the camera in a robot's nose: 640x480, like the real Go2's `GetImageSample`."""
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
    camera.fixedcamid = model.camera(f"{robot}/front").id
    return View(640, 480, (room.ROOM_GROUP, room.NEAR_WALL_GROUP, ROBOT_GROUP), camera)


def overview(model: Any) -> View:
    """The whole room from above a corner, without the two near walls."""
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
    camera.fixedcamid = model.camera("overview").id
    return View(800, 450, (room.ROOM_GROUP, ROBOT_GROUP), camera)


class Renderer(Protocol):
    """Draws views of one model; used from one thread only. `smooth` edges, if supported, take twice the time."""

    name: str
    smooth: bool

    def draw(self, view: View, pose: Array) -> Picture: ...

    def close(self) -> None: ...


def place_cameras(model: Any, data: Any, pose: Array) -> None:
    """Put a world's pose (nq + 3,) into data far enough for drawing."""
    data.qpos[:] = pose[: model.nq]
    data.mocap_pos[:] = pose[model.nq :].reshape(data.mocap_pos.shape)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_camlight(model, data)
