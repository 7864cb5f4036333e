"""The interface of a follower arm, as LeRobot's `Robot` class has it, and how a real one is opened through LeRobot.

LeRobot is not a dependency (it brings torch): it is imported when a real arm is opened.
"""

from __future__ import annotations

import importlib
import io
import logging
from pathlib import Path
from typing import Any, Protocol

from agentrob.errors import ConfigError, RobotError, RobotUnreachable
from agentrob_so101.options import So101Options

log = logging.getLogger(__name__)

INSTALL = "pip install 'lerobot[feetech]'"
#: Where LeRobot has the class: today, and before its version 0.4.4.
MODULES = ("lerobot.robots.so_follower", "lerobot.robots.so101_follower")
CAMERA_MODULE = "lerobot.cameras.opencv"
#: LeRobot itself sends no goal farther than this from where a joint is.
MOST_RELATIVE_DEG = 30.0
PICTURE_MS = 1000


class Follower(Protocol):
    """The part of LeRobot's `Robot` that is used. Observations and actions have the keys `shoulder_pan.pos` to
    `wrist_roll.pos` in degrees and `gripper.pos` in percent. Its calls block while the bus answers, some milliseconds,
    and are made by one thread at a time."""

    @property
    def is_calibrated(self) -> bool: ...

    def connect(self, calibrate: bool = True) -> None: ...

    def get_observation(self) -> dict[str, Any]: ...

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]: ...

    def disconnect(self) -> None: ...


class Camera(Protocol):
    """Takes one picture when it is asked for."""

    def jpeg(self) -> bytes:
        """Return a JPEG. Raises `RobotError` if there is no picture."""
        ...

    def close(self) -> None: ...


def load_lerobot() -> Any:
    """Import LeRobot's module of the arm. Raises `RobotError`, which says what to install."""
    for name in MODULES:
        try:
            return importlib.import_module(name)
        except ModuleNotFoundError as e:
            missing = e.name or ""
            if not name.startswith(missing):  # LeRobot is there, one of its own packages is not
                raise RobotError(f"LeRobot cannot be used: it lacks {missing}; {INSTALL}") from None
    raise RobotError(f"a real SO-101 needs LeRobot on this machine: {INSTALL}")


def open_follower(options: So101Options, lerobot: Any = None) -> Follower:
    """Connect to the arm at `options.port`; `lerobot` is LeRobot's module of the arm.

    Raises `ConfigError` without a port, `RobotError` if LeRobot is missing or too old or the arm is not calibrated, and
    `RobotUnreachable` if nothing answers on the port.
    """
    if not options.port:
        raise ConfigError(
            "options of an SO-101 arm: port must name the serial port of the arm, such as /dev/ttyACM0 "
            "(`lerobot-find-port` finds it); set simulated = true for a simulated arm"
        )
    lerobot = lerobot or load_lerobot()
    folder = Path(options.calibration_folder).expanduser() if options.calibration_folder else None
    try:
        config = lerobot.SO101FollowerConfig(
            port=options.port,
            id=options.calibration or None,
            calibration_dir=folder,
            use_degrees=True,
            max_relative_target=MOST_RELATIVE_DEG,
            disable_torque_on_disconnect=False,  # with the torque off the arm would drop
        )
    except (AttributeError, TypeError) as e:
        raise RobotError(f"this version of LeRobot is not supported ({e}); {INSTALL}") from None
    follower: Follower = lerobot.SO101Follower(config)
    try:
        follower.connect(calibrate=False)  # else it would ask questions on the terminal
    except Exception as e:  # what LeRobot and the serial port raise
        raise RobotUnreachable(f"the SO-101 does not answer on {options.port}: {type(e).__name__}: {e}") from None
    if not follower.is_calibrated:
        follower.disconnect()
        name = options.calibration or "NAME"
        raise RobotError(
            f"the SO-101 on {options.port} is not calibrated as {name!r}: run lerobot-calibrate "
            f"--robot.type=so101_follower --robot.port={options.port} --robot.id={name}, and set calibration = {name!r}"
        )
    return follower


class OpenCVCamera:
    """A camera through LeRobot's class for OpenCV, beside the arm: a slow camera never delays its bus."""

    def __init__(self, options: So101Options, cameras: Any = None) -> None:
        """`cameras` is LeRobot's module of the camera. Raises `RobotError` if it cannot be opened."""
        try:
            cameras = cameras or importlib.import_module(CAMERA_MODULE)
        except ModuleNotFoundError:
            raise RobotError(f"the camera of a real SO-101 needs LeRobot on this machine: {INSTALL}") from None
        own = options.camera
        source = Path(own.source) if isinstance(own.source, str) else own.source
        config = cameras.OpenCVCameraConfig(index_or_path=source, fps=own.fps, width=own.width, height=own.height)
        self._camera, self._source = cameras.OpenCVCamera(config), own.source
        try:
            self._camera.connect()
        except Exception as e:  # what LeRobot and OpenCV raise
            raise RobotError(f"the camera {own.source} cannot be opened: {type(e).__name__}: {e}") from None

    def jpeg(self) -> bytes:
        from PIL import Image

        try:
            picture = self._camera.async_read(timeout_ms=PICTURE_MS)  # (height, width, 3), RGB
        except Exception as e:  # as above
            raise RobotError(f"the camera {self._source} gives no picture: {type(e).__name__}: {e}") from None
        out = io.BytesIO()
        Image.fromarray(picture).save(out, "JPEG", quality=85)
        return out.getvalue()

    def close(self) -> None:
        try:
            self._camera.disconnect()
        except Exception as e:  # as above
            log.warning("the camera %s could not be closed: %s", self._source, e)
