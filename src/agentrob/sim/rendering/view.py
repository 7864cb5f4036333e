"""Camera views of the world, and the renderer protocol."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import mujoco
import numpy as np
from numpy.typing import NDArray

from agentrob.sim.world import room
from agentrob.sim.world.legged import Array
from agentrob.sim.world.world import ROBOT_GROUP

#: The camera that follows a robot: its picture, how far away it is (metres, and heights of the body), how far it looks
#: down.
FOLLOW_PX, FOLLOW_M, FOLLOW_HEIGHTS, FOLLOW_DEG = (640, 360), 1.5, 1.7, -24.0

Picture = NDArray[np.uint8]  # (height, width, 3)


@dataclass(frozen=True, slots=True)
class View:
    """One camera: size of its picture, the geom groups it sees, and its pose in MuJoCo's terms, fixed or free."""

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


def follow_view(model: Any, height_m: float, at_m: Array) -> View:
    """A robot that stands at `at_m` (x, y), from the direction of the room's camera, which no near wall hides."""
    overview = model.camera("overview").id
    ahead = -np.asarray(model.cam_mat0[overview]).reshape(3, 3)[:, 2]
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = (*at_m, height_m)
    camera.distance = FOLLOW_M + FOLLOW_HEIGHTS * height_m
    camera.azimuth = math.degrees(math.atan2(ahead[1], ahead[0]))
    camera.elevation = FOLLOW_DEG
    return View(*FOLLOW_PX, (room.ROOM_GROUP, ROBOT_GROUP), camera)


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
