"""A kinematic body for the robots that the peers serve: it follows a velocity command at once, for a limited time."""

import base64
import math
import threading
import time


class Body:
    """A thread-safe body. `place` is x and y in m and the heading in rad; `velocity` is forward, left and
    counter-clockwise."""

    def __init__(self):
        self._lock = threading.Lock()
        self._place, self._velocity, self._since_s, self._until_s = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0, 0.0

    def command(self, forward, left, turning, hold_s=1.0):
        with self._lock:
            self._move()
            self._velocity, self._until_s = (forward, left, turning), time.monotonic() + hold_s

    def look(self):
        """Return the current place and velocity."""
        with self._lock:
            self._move()
            moving = time.monotonic() < self._until_s
            return self._place, self._velocity if moving else (0.0, 0.0, 0.0)

    def _move(self):
        now_s = time.monotonic()
        seconds = max(0.0, min(now_s, self._until_s) - self._since_s)
        self._since_s = now_s
        x, y, yaw = self._place
        forward, left, turning = self._velocity
        x += seconds * (forward * math.cos(yaw) - left * math.sin(yaw))
        y += seconds * (forward * math.sin(yaw) + left * math.cos(yaw))
        self._place = x, y, yaw + seconds * turning


class CallLog:
    """Logs each received call as a line of JSON, from any thread."""

    def __init__(self, path):
        self._file, self._lock = open(path, "a", buffering=1, encoding="utf-8"), threading.Lock()  # noqa: SIM115

    def note(self, service, api_id, parameter):
        with self._lock:
            self._file.write(f'["{service}", {api_id}, {parameter or "null"}]\n')


_SMALL = base64.b64decode(
    "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDABsSFBcUERsXFhceHBsgKEIrKCUlKFE6PTBCYFVlZF9VXVtqeJmBanGQc1tdhbWGkJ6jq62rZ4C8ybqm"
    "x5moq6T/wAALCAAQABABAREA/8QAFQABAQAAAAAAAAAAAAAAAAAABgX/xAAWEAADAAAAAAAAAAAAAAAAAAAABUH/2gAIAQEAAD8AlL4Jl8DK+CZf"
    "D//Z"
)
#: A 16 by 16 gradient with a comment that makes the file as long as a real picture.
PICTURE = _SMALL[:2] + b"\xff\xfe" + (25_602).to_bytes(2, "big") + bytes(range(256)) * 100 + _SMALL[2:]
