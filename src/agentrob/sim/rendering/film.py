"""Pictures of a robot as it moved up to two minutes ago, by a camera that follows it.

The world only notes its poses. A picture is rendered when it is asked for, usually after a command, so that however
quick a motion was, no picture of it is missing, and rendering takes no time from the physics while a robot moves.
"""

from __future__ import annotations

import bisect
import math
import threading
import time
from collections import deque
from collections.abc import Mapping
from typing import Any

import numpy as np

from agentrob.sim.rendering.cameras import Cameras
from agentrob.sim.rendering.view import follow_view
from agentrob.sim.world.legged import Array, Legged

#: How long poses are kept, and the shortest interval between two of them.
KEEP_S, EVERY_S = 120.0, 0.018
#: The camera follows the mean position over this time around a moment: a gait sways, the camera does not.
STEADY_S = 1.2
#: How long one picture may take to render.
LIMIT_S = 5.0


class PoseHistory:
    """The poses of a world in the last `KEEP_S`. One thread adds, any thread reads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._poses: deque[tuple[float, Array]] = deque()

    def add(self, at_s: float, pose: Array) -> None:
        """Note the pose of a monotonic time, which may not be changed later."""
        with self._lock:
            if self._poses and at_s - self._poses[-1][0] < EVERY_S:
                return
            self._poses.append((at_s, pose))
            while at_s - self._poses[0][0] > KEEP_S:
                self._poses.popleft()

    def around(self, at_s: float, within_s: float) -> tuple[Array, Array] | None:
        """The pose at a time, and all poses within half of `within_s` of it (n, nq + 3); None if it is not known."""
        with self._lock:
            poses = list(self._poses)
        if not poses or not poses[0][0] <= at_s <= poses[-1][0] + STEADY_S:
            return None
        times = [time_s for time_s, _ in poses]
        first = bisect.bisect_left(times, at_s - within_s / 2)
        last = max(first + 1, bisect.bisect_right(times, at_s + within_s / 2))
        at = min(bisect.bisect_left(times, at_s), len(poses) - 1)
        first = min(first, at)
        return poses[at][1], np.array([pose for _, pose in poses[first:last]])


class Film:
    """The pictures of one world's robots. `note` is called by the world's thread, `picture` by any."""

    def __init__(self, model: Any, robots: Mapping[str, Legged], cameras: Cameras) -> None:
        self._model, self._robots, self._cameras = model, robots, cameras
        self._history = PoseHistory()

    def note(self, pose: Array) -> None:
        self._history.add(time.monotonic(), pose)

    def picture(self, robot: str, ago_s: float) -> bytes | None:
        """The JPEG of a robot `ago_s` seconds ago; None if that is too long ago, or rendering failed. Waits for it."""
        body = self._robots.get(robot)
        if body is None or not math.isfinite(ago_s):
            return None
        found = self._history.around(time.monotonic() - ago_s, STEADY_S)
        if found is None:
            return None
        pose, near = found
        at_m = near[:, body.root_q : body.root_q + 2].mean(axis=0)
        return self._cameras.shoot(follow_view(self._model, body.build.height_m, at_m), pose, LIMIT_S)
