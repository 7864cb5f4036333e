"""A double of LeRobot's SO-101 follower, with the interface of its documentation: what is sent is reached at the speed
of the servos, and kept. Its bus takes one call at a time."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from agentrob_so101.operations import HOME_POSE
from agentrob_so101.pose import NAMES, SUFFIX

SERVO_DPS = 250.0


@dataclass
class SO101FollowerConfig:
    port: str
    id: str | None = None
    calibration_dir: Path | None = None
    use_degrees: bool = False
    max_relative_target: float | None = None
    disable_torque_on_disconnect: bool = True


class SO101Follower:
    """`broken` is what the bus raises, if anything; `lose` is how many calls fail before the next one. `sent` are the
    actions, with the time of each."""

    calibrated = True
    plugged_in = True

    def __init__(self, config: SO101FollowerConfig) -> None:
        self.config = config
        self.broken: Exception | None = None
        self.lose = 0
        self.sent: list[tuple[float, dict[str, float]]] = []
        self.is_connected = False
        self._at = dict(zip(NAMES, HOME_POSE, strict=True))
        self._goal = dict(self._at)
        self._moved_s = time.monotonic()
        self._bus = threading.Lock()

    @property
    def is_calibrated(self) -> bool:
        return self.calibrated

    @property
    def observation_features(self) -> dict[str, type]:
        return {name + SUFFIX: float for name in NAMES}

    @property
    def action_features(self) -> dict[str, type]:
        return self.observation_features

    def connect(self, calibrate: bool = True) -> None:
        assert not calibrate, "it would ask questions on the terminal"
        if not self.plugged_in:
            raise ConnectionError(f"Could not connect on port '{self.config.port}'")
        self.is_connected = True

    def get_observation(self) -> dict[str, Any]:
        return self._on_the_bus(lambda: {name + SUFFIX: np.float64(value) for name, value in self._at.items()})

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        def send() -> dict[str, Any]:
            most = self.config.max_relative_target
            for name in NAMES:
                asked = float(action[name + SUFFIX])
                near = self._at[name]
                self._goal[name] = asked if most is None else max(near - most, min(near + most, asked))
            self.sent.append((time.monotonic(), {name + SUFFIX: self._goal[name] for name in NAMES}))
            return self.sent[-1][1]

        return self._on_the_bus(send)

    def disconnect(self) -> None:
        self.is_connected = False

    def _on_the_bus(self, call: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        assert self.is_connected, "it is not connected"
        assert self._bus.acquire(blocking=False), "two calls at once: the bus of the servos takes one"
        try:
            if self.broken is not None:
                raise self.broken
            if self.lose:
                self.lose -= 1
                raise ConnectionError("Incorrect status packet!")
            now_s = time.monotonic()
            most, self._moved_s = SERVO_DPS * (now_s - self._moved_s), now_s
            for name, goal in self._goal.items():
                self._at[name] += max(-most, min(most, goal - self._at[name]))
            return call()
        finally:
            self._bus.release()


@dataclass
class OpenCVCameraConfig:
    index_or_path: int | Path
    fps: int
    width: int
    height: int


class OpenCVCamera:
    def __init__(self, config: OpenCVCameraConfig) -> None:
        self.config, self.is_connected = config, False

    def connect(self) -> None:
        if self.config.index_or_path == Path("/dev/video9"):
            raise ConnectionError("Failed to open OpenCVCamera(/dev/video9)")
        self.is_connected = True

    def async_read(self, timeout_ms: float = 200) -> Any:
        if not self.is_connected:
            raise RuntimeError("not connected")
        picture = np.zeros((self.config.height, self.config.width, 3), np.uint8)
        picture[:, : self.config.width // 2] = 200
        return picture

    def disconnect(self) -> None:
        self.is_connected = False
