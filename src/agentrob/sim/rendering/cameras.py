"""Renders pictures of the world on demand, on a thread of its own and from a copy of the pose.

Nothing is rendered without a request. Requests within a tenth of a second get the same picture.
"""

from __future__ import annotations

import io
import os
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import mujoco
import numpy as np
from PIL import Image

from agentrob.sim.rendering import gl_probe
from agentrob.sim.rendering.ray_camera import RayRenderer
from agentrob.sim.rendering.view import Picture, Renderer, View, place_cameras
from agentrob.sim.world import room
from agentrob.sim.world.legged import Array

Deliver = Callable[[bytes | None], None]
Shot = tuple[View, Array, Deliver]

SEVERAL_S = 0.5  # if other views were drawn within this time, several cameras are in use
SMOOTH_SAMPLES = 4
SLOW_S = 0.2  # if a shot took longer than this, the machine is busy, and the next one is not smoothed
FRESH_S = 0.07  # a younger picture is reused; ten requests a second with some jitter all get new ones
JPEG_QUALITY = 88
NICE = 5  # physics and drivers, which share the cores, are served first; at 10 a picture on a busy machine took seconds
LARGEST = (1280, 720)
SHADE_M = (0.34, 0.20, 0.004)


class GlRenderer:
    """MuJoCo's renderer on a GL context without a screen."""

    def __init__(self, model: Any, backend: str) -> None:
        self.name, self.smooth = backend, True
        self._model = model
        self._data = mujoco.MjData(model)
        self._gl = gl_probe.open_context(backend, *LARGEST)
        self._contexts: dict[bool, Any] = {}
        for self.smooth in (False, True):  # create both now: creating one later would delay the world
            self._context()
        self._scene = mujoco.MjvScene(model, maxgeom=1000)
        self._option = mujoco.MjvOption()
        free = model.jnt_bodyid[model.jnt_type == mujoco.mjtJoint.mjJNT_FREE.value]
        self._robots = [int(b) for b in free if b in model.body_parentid]  # a loose thing has no limbs

    def _context(self) -> Any:
        """The drawing context for `smooth` as it is now."""
        if self.smooth not in self._contexts:
            self._model.vis.quality.offsamples = SMOOTH_SAMPLES if self.smooth else 0
            context = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, context)
            self._contexts[self.smooth] = context
        return self._contexts[self.smooth]

    def draw(self, view: View, pose: Array) -> Picture:
        place_cameras(self._model, self._data, pose)
        self._option.geomgroup[:] = [g in view.groups for g in range(6)]
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(self._model, self._data, self._option, None, view.camera, everything, self._scene)
        self._add_shades()
        area, context = mujoco.MjrRect(0, 0, view.width, view.height), self._context()
        mujoco.mjr_restoreBuffer(context)  # the other one's may be bound
        mujoco.mjr_render(area, self._scene, context)
        picture = np.empty((view.height, view.width, 3), np.uint8)
        mujoco.mjr_readPixels(picture, None, area, context)
        return picture[::-1]

    def _add_shades(self) -> None:
        """Add a dark, transparent patch on the floor under each robot; real shadows triple the rendering time."""
        for body in self._robots:
            shade = self._scene.geoms[self._scene.ngeom]
            x, y, _ = self._data.xpos[body]
            rotation = self._data.xmat[body].reshape(3, 3)
            c, s = rotation[0, 0], rotation[1, 0]
            level = np.array([c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0])
            ellipsoid = mujoco.mjtGeom.mjGEOM_ELLIPSOID.value
            size, at = np.array(SHADE_M), np.array([x, y, 0.008])
            mujoco.mjv_initGeom(shade, ellipsoid, size, at, level, np.array(room.SHADE, np.float32))
            self._scene.ngeom += 1

    def close(self) -> None:
        for context in self._contexts.values():
            context.free()
        self._gl.free()


def choose_backend() -> str:
    """`egl`, `osmesa` or `ray`.

    `MUJOCO_GL=egl` or `osmesa` selects that backend if it works; `off` or `disable` selects `ray`, which loads no GL.
    Otherwise the first of `egl` and `osmesa` that works is used, else `ray`. (`MUJOCO_GL` is MuJoCo's own variable:
    with some other values, such as `ray`, `import mujoco` fails.)
    """
    wanted = os.environ.get("MUJOCO_GL", "").lower()
    if wanted in ("off", "disable", "disabled", "0", "false"):
        return "ray"
    tried = (wanted,) if wanted in gl_probe.BACKENDS else gl_probe.BACKENDS
    return next((b for b in tried if gl_probe.works(b)), "ray")


def open_renderer(model: Any, backend: str) -> Renderer:
    """Open the renderer for a backend; fall back to rays if that fails."""
    if backend != "ray":
        try:
            return GlRenderer(model, backend)
        except Exception:  # drivers fail in many ways; rays always work
            return RayRenderer(model)
    return RayRenderer(model)


def _lower_priority() -> None:
    """Lower the priority of this thread and of those it will start, such as a software renderer's."""
    if sys.platform == "linux":  # elsewhere a priority belongs to the whole process
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), os.getpriority(os.PRIO_PROCESS, 0) + NICE)


def _awaited(request: Callable[[Deliver], None], timeout_s: float) -> bytes | None:
    """Request a picture and wait for it."""
    there = threading.Event()
    got: list[bytes | None] = []

    def deliver(jpeg: bytes | None) -> None:
        got.append(jpeg)
        there.set()

    request(deliver)
    return got[0] if there.wait(timeout_s) else None


class Cameras:
    """Renders on request. `pose` returns a copy of the world's pose and is thread-safe.

    Edges are not smoothed while several cameras are in use: three at 10 pictures a second must leave CPU time for
    everything else on two cores.
    """

    def __init__(self, model: Any, views: Mapping[str, View], pose: Callable[[], Array]) -> None:
        self._model, self._views, self._pose = model, views, pose
        self._waiting: dict[str, list[Deliver]] = {}
        self._shots: deque[Shot] = deque()
        self._shot_s = 0.0
        self._newest: dict[str, tuple[float, bytes]] = {}
        self._wake = threading.Condition()
        self._closing = False
        self.backend = ""
        self.drawn = 0
        self.seconds = 0.0
        self.last_error = ""
        self.ready = threading.Event()
        self._thread = threading.Thread(target=self._run, name="cameras", daemon=True)
        self._thread.start()

    def request(self, view: str, deliver: Deliver) -> None:
        """Call `deliver(jpeg)` from the rendering thread, with None if rendering failed. Returns at once."""
        if view not in self._views:
            deliver(None)
            return
        with self._wake:
            self._waiting.setdefault(view, []).append(deliver)
            self._wake.notify()

    def jpeg(self, view: str, timeout_s: float = 3.0) -> bytes | None:
        """As `request`, but wait for the picture."""
        return _awaited(partial(self.request, view), timeout_s)

    def shoot(self, view: View, pose: Array, timeout_s: float) -> bytes | None:
        """A picture of a given pose of the world. The views that are shown live are rendered first."""

        def request(deliver: Deliver) -> None:
            with self._wake:
                self._shots.append((view, pose, deliver))
                self._wake.notify()

        return _awaited(request, timeout_s)

    def close(self) -> None:
        with self._wake:
            self._closing = True
            self._wake.notify()
        self._thread.join(1.0)

    # ------------------------------------------------------------------ the drawing thread
    def _run(self) -> None:
        _lower_priority()
        renderer = open_renderer(self._model, choose_backend())
        self.backend = renderer.name
        self.ready.set()
        while (work := self._next()) is not None:
            work(renderer)
        renderer.close()

    def _next(self) -> Callable[[Renderer], None] | None:
        """The next rendering: a live view, else a shot; None at the end."""
        with self._wake:
            while not (self._waiting or self._shots or self._closing):
                self._wake.wait()
            if self._closing:
                return None
            if not self._waiting:
                return partial(self._shot, *self._shots.popleft())
            view = next(iter(self._waiting))
            return partial(self._live, view, self._waiting.pop(view))

    def _shot(self, view: View, pose: Array, deliver: Deliver, renderer: Renderer) -> None:
        renderer.smooth = not self._in_use(but="") and self._shot_s < SLOW_S
        begun_s = time.monotonic()
        deliver(self._rendered(view, pose, renderer))
        self._shot_s = time.monotonic() - begun_s

    def _live(self, name: str, delivers: list[Deliver], renderer: Renderer) -> None:
        jpeg = self._fresh(name, renderer)
        for deliver in delivers:
            deliver(jpeg)

    def _fresh(self, name: str, renderer: Renderer) -> bytes | None:
        now = time.monotonic()
        if name in self._newest and now - self._newest[name][0] < FRESH_S:
            return self._newest[name][1]
        renderer.smooth = not self._in_use(but=name)
        jpeg = self._rendered(self._views[name], self._pose(), renderer)
        if jpeg is not None:
            self._newest[name] = (now, jpeg)
        return jpeg

    def _in_use(self, but: str) -> bool:
        """Whether another live view was rendered just now."""
        now = time.monotonic()
        return any(now - at < SEVERAL_S for name, (at, _) in self._newest.items() if name != but)

    def _rendered(self, view: View, pose: Array, renderer: Renderer) -> bytes | None:
        begun_s = time.monotonic()
        try:
            picture = renderer.draw(view, pose)
            buffer = io.BytesIO()
            Image.fromarray(picture).save(buffer, "JPEG", quality=JPEG_QUALITY)
        except Exception as e:  # the world must continue without pictures
            self.last_error = f"{type(e).__name__}: {e}"
            return None
        self.drawn += 1
        self.seconds += time.monotonic() - begun_s
        return buffer.getvalue()
