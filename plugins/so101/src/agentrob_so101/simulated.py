"""The simulated arm as its driver sees it: LeRobot's interface, over a local socket to the process of its world.

One JSON object a line each way: {"do": "observe"}, {"do": "act", "action": {…}}, {"do": "picture"}, and for tests
{"do": "apply", "what": {…}}; an answer has "error" if that could not be done.
"""

from __future__ import annotations

import base64
import contextlib
import json
import socket
import threading
from typing import Any

from agentrob.errors import RobotError
from agentrob.process import host_lock

#: The answer of the world must come within this time, with a picture within the second.
ANSWER_S, PICTURE_S = 0.3, 10.0
LONGEST_LINE = 8_000_000


def address(interface: str, domain: int) -> str:
    """The name of the socket of the arm that is simulated on a domain (`agentrob.process.host_lock`)."""
    return f"so101/{interface}/{domain}"


class Channel:
    """One connection to the world, which is made when something is asked and again after it broke. Thread-safe."""

    def __init__(self, name: str, timeout_s: float) -> None:
        self._name, self._timeout_s = name, timeout_s
        self._socket: socket.socket | None = None
        self._left = b""
        self._lock = threading.Lock()

    def ask(self, **request: Any) -> dict[str, Any]:
        """Raises `ConnectionError` if the world does not answer in time, or cannot do it."""
        with self._lock:
            try:
                if self._socket is None:
                    self._socket, self._left = host_lock.connect(self._name, self._timeout_s), b""
                self._socket.sendall(json.dumps(request).encode() + b"\n")
                answer: dict[str, Any] = json.loads(self._line(self._socket))
            except (OSError, ValueError) as e:
                self._drop()
                raise ConnectionError(f"the simulation does not answer ({e or type(e).__name__})") from None
        if "error" in answer:
            raise ConnectionError(str(answer["error"]))
        return answer

    def close(self) -> None:
        with self._lock:
            self._drop()

    def _line(self, connection: socket.socket) -> bytes:
        while b"\n" not in self._left:
            if not (more := connection.recv(65536)) or len(self._left) > LONGEST_LINE:
                raise ConnectionError("it closed the connection")
            self._left += more
        line, _, self._left = self._left.partition(b"\n")
        return line

    def _drop(self) -> None:
        if self._socket is not None:
            with contextlib.suppress(OSError):
                self._socket.close()
        self._socket = None


class SimulatedFollower:
    """See `agentrob_so101.follower.Follower` and `Camera`. Its world need not run yet."""

    is_calibrated = True

    def __init__(self, interface: str, domain: int) -> None:
        self._bus = Channel(address(interface, domain), ANSWER_S)
        self._eye = Channel(address(interface, domain), PICTURE_S)

    def connect(self, calibrate: bool = True) -> None:
        """Does nothing: it connects when it is asked for something."""

    def get_observation(self) -> dict[str, Any]:
        return self._bus.ask(do="observe")

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        return self._bus.ask(do="act", action=action)

    def disconnect(self) -> None:
        self._bus.close()

    def jpeg(self) -> bytes:
        try:
            return base64.b64decode(self._eye.ask(do="picture")["jpeg"])
        except ConnectionError as e:
            raise RobotError(f"the arm's camera gives no picture: {e}") from None

    def close(self) -> None:
        self._eye.close()
