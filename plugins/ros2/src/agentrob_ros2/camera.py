"""The camera of a ROS 2 base: one picture when it is asked for."""

from __future__ import annotations

import io
import threading
import time
from typing import Any

from cyclonedds.internal import InvalidSample
from PIL import Image as Pictures

from agentrob.errors import RobotError
from agentrob.model import ActionResult, Outcome, Primitive
from agentrob_ros2 import messages
from agentrob_ros2.network import Node, qos_of, ros_type
from agentrob_ros2.options import Ros2Options

#: A picture must come within this time.
PICTURE_S = 3.0
POLL_S = 0.02
MOST_PIXELS = 8_000_000
#: Encodings of sensor_msgs/Image: mode of Pillow, its raw decoder, bytes a pixel.
ENCODINGS = {
    "rgb8": ("RGB", "RGB", 3), "bgr8": ("RGB", "BGR", 3), "rgba8": ("RGB", "RGBX", 4), "bgra8": ("RGB", "BGRX", 4),
    "mono8": ("L", "L", 1), "8UC1": ("L", "L", 1), "8UC3": ("RGB", "BGR", 3),
}  # fmt: skip


class Camera:
    """A picture is decoded only when somebody asks: the newest that comes after that."""

    def __init__(self, node: Node, options: Ros2Options) -> None:
        self._topic = options.absolute(options.image.topic)
        self._kind: Any = messages.CompressedImage if options.image.compressed else messages.Image
        self._reader = node.reader(self._topic, self._kind, qos_of(options.image))
        self._looking = threading.Lock()

    def look(self) -> bytes:
        """A JPEG of now. Raises `RobotError` if none comes in time or it cannot be read."""
        with self._looking:
            self._reader.take(10)  # what came before was seen before
            end_s = time.monotonic() + PICTURE_S
            while time.monotonic() < end_s:
                for message in self._reader.take(1):
                    if not isinstance(message, InvalidSample):
                        return self._jpeg(message)
                time.sleep(POLL_S)
        raise RobotError(f"no picture came on {self._topic} ({ros_type(self._kind)}) within {PICTURE_S:g} s")

    def photo(self, primitive: Primitive) -> ActionResult:
        started_s = time.monotonic()
        try:
            image = self.look()
        except RobotError as e:
            message = str(e)[:1].upper() + str(e)[1:] + "."
            return ActionResult(primitive, Outcome.FAILED, {}, "bad_image", message, started_s, time.monotonic())
        return ActionResult(primitive, Outcome.DONE, {}, "", "", started_s, time.monotonic(), image=image)

    def _jpeg(self, message: Any) -> bytes:
        return compressed_jpeg(message) if isinstance(message, messages.CompressedImage) else raw_jpeg(message)


def compressed_jpeg(message: messages.CompressedImage) -> bytes:
    """A JPEG as it came, or a PNG converted."""
    data = bytes(message.data)
    if data.startswith(b"\xff\xd8"):
        return data
    try:
        with Pictures.open(io.BytesIO(data), formats=("PNG",)) as picture:
            return _encoded(picture)
    except (OSError, SyntaxError, ValueError, Pictures.DecompressionBombError) as e:
        raise RobotError(f"the camera's picture ({message.format!r}) cannot be read: {type(e).__name__}") from None


def raw_jpeg(message: messages.Image) -> bytes:
    """A JPEG of a raw picture."""
    if message.encoding not in ENCODINGS:
        known = ", ".join(sorted(ENCODINGS))
        raise RobotError(f"the camera's encoding {message.encoding!r} cannot be read; valid: {known}")
    mode, raw, bytes_each = ENCODINGS[message.encoding]
    width, height, step = int(message.width), int(message.height), int(message.step)
    data = bytes(message.data)
    fits = 0 < width * height <= MOST_PIXELS and step >= width * bytes_each and len(data) >= step * height
    if not fits:
        raise RobotError(f"the camera sent {len(data)} bytes, which are no picture of {width} x {height}")
    return _encoded(Pictures.frombuffer(mode, (width, height), data, "raw", raw, step, 1))


def _encoded(picture: Pictures.Image) -> bytes:
    out = io.BytesIO()
    picture.convert("RGB").save(out, "JPEG", quality=85)
    return out.getvalue()
