"""A camera without any GL library: one ray per pixel, flat colours shaded by the angle of the surface."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
from PIL import Image

from agentrob.sim.rendering.view import Picture, View, place_cameras
from agentrob.sim.world.legged import Array
from agentrob.sim.world.world import FIRST_ROBOT_GROUP, ROBOT_GROUP

SHRINK = 2  # rays per picture: a quarter of its pixels
SKY: Array = np.array([0.66, 0.73, 0.82])
SUN: Array = np.array([-0.35, -0.25, 1.0]) / math.sqrt(0.35**2 + 0.25**2 + 1.0)
FAR_M = 30.0


class RayRenderer:
    """Slower and plainer than GL, without any dependency."""

    name = "ray"
    smooth = False

    def __init__(self, model: Any) -> None:
        self._model = model
        self._data = mujoco.MjData(model)
        texture = model.texture("floor").id
        begin, count = model.tex_adr[texture], model.tex_width[texture] * model.tex_height[texture]
        picture = model.tex_data[begin : begin + 3 * count].reshape(-1, 3)
        self._floor_rgb: Array = picture.mean(axis=0) / 255  # its pattern is not drawn

    def draw(self, view: View, pose: Array) -> Picture:
        place_cameras(self._model, self._data, pose)
        origin, rays = self._rays(view)
        own = self._carrier(view)
        count = len(rays)
        groups = np.array([g in self._groups(view) for g in range(6)], np.uint8)
        hit, distance = np.full(count, -1, np.int32), np.zeros(count)
        normal = np.zeros((count, 3))
        mujoco.mj_multiRay(
            self._model,
            self._data,
            origin,
            rays.ravel(),
            groups,
            True,
            own,
            hit,
            distance,
            normal.ravel(),
            count,
            FAR_M,
        )
        return self._colour(view, hit, distance, normal)

    def close(self) -> None:
        """Does nothing; this renderer holds no resources."""

    def _carrier(self, view: View) -> int:
        """The body that carries the camera, or -1. It is not drawn, since the camera is inside its shapes."""
        if view.camera.type == mujoco.mjtCamera.mjCAMERA_FREE.value:
            return -1
        body = int(self._model.cam_bodyid[view.camera.fixedcamid])
        return body if body > 0 else -1

    def _groups(self, view: View) -> set[int]:
        """The geom groups to draw. A robot's camera sees other robots' simple shapes: meshes take ten times as long."""
        if self._carrier(view) < 0:
            return set(view.groups)
        return {g for g in view.groups if g != ROBOT_GROUP} | set(range(FIRST_ROBOT_GROUP, 6))

    def _rays(self, view: View) -> tuple[Array, Array]:
        """Origin (3,) and unit directions (n, 3) in the world."""
        origin, axes, fovy_deg = self._placed(view.camera)
        width, height = view.width // SHRINK, view.height // SHRINK
        focal = 0.5 * height / math.tan(math.radians(fovy_deg) / 2)
        x, y = np.meshgrid(np.arange(width) - width / 2 + 0.5, height / 2 - 0.5 - np.arange(height))
        rays = np.stack([x / focal, y / focal, -np.ones_like(x)], axis=-1).reshape(-1, 3)
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        return origin, rays @ axes.T

    def _placed(self, camera: Any) -> tuple[Array, Array, float]:
        """Where a camera is (3,), its axes (3, 3: to the right, up, back), and its vertical field of view."""
        if camera.type != mujoco.mjtCamera.mjCAMERA_FREE.value:
            number = camera.fixedcamid
            axes = self._data.cam_xmat[number].reshape(3, 3)
            return self._data.cam_xpos[number].copy(), axes, float(self._model.cam_fovy[number])
        azimuth, elevation = math.radians(camera.azimuth), math.radians(camera.elevation)
        ahead = np.array(
            [math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth), math.sin(elevation)]
        )
        right = np.array([math.sin(azimuth), -math.cos(azimuth), 0.0])
        axes = np.stack([right, np.cross(right, ahead), -ahead], axis=1)
        return camera.lookat - camera.distance * ahead, axes, float(self._model.vis.global_.fovy)

    def _colour(self, view: View, hit: Any, distance: Array, normal: Array) -> Picture:
        model = self._model
        geom = np.maximum(hit, 0)
        material = model.geom_matid[geom]
        rgb = np.where((material >= 0)[:, None], model.mat_rgba[material, :3], model.geom_rgba[geom, :3])
        alpha = np.where(material >= 0, 1.0, model.geom_rgba[geom, 3])[:, None]
        rgb = rgb * alpha + self._floor_rgb * (1 - alpha)  # what is see-through lies on the floor
        floor = model.geom("floor").id
        rgb = np.where((geom == floor)[:, None], self._floor_rgb, rgb)
        light = 0.62 + 0.38 * np.clip(normal @ SUN, 0, 1)
        shade = light * np.clip(1.1 - distance / 25, 0.5, 1)
        rgb = np.where((hit >= 0)[:, None], rgb * shade[:, None], SKY)
        small = (np.clip(rgb, 0, 1) * 255).astype(np.uint8)
        image = Image.fromarray(small.reshape(view.height // SHRINK, view.width // SHRINK, 3))
        return np.asarray(image.resize((view.width, view.height), Image.Resampling.BILINEAR))
