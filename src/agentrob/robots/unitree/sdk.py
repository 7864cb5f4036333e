"""Access to the Unitree SDK: one DDS domain per process, one client per purpose, the newest state and its age.

Problems that this module works around (seen with unitree-sdk2py 1.0.3 and cyclonedds 11):
- `agentrob.process.dds` must be imported before any type of the SDK, or robots on cyclonedds 0.10 do not understand us;
- the SDK's ChannelFactory is a process singleton that ignores a second domain without a word: here that is an error;
- naming an interface makes the SDK log to one shared file in the temporary folder: its configuration is replaced;
- a write to a robot that is not there blocks for the client's timeout, so velocities have a client with a short one;
- the SDK prints what goes wrong; the driver sends that to standard error.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, TypeVar

from agentrob.errors import RobotBusy, RobotUnreachable

C = TypeVar("C")

#: Explanations of the error codes of the SDK and the robot.
CODES = {
    3001: "the robot's answer could not be understood",
    3102: "the request could not be sent: no such service answers on the robot's network",
    3103: "this client does not know the call",
    3104: "the robot did not answer in time",
    3202: "the robot reports an internal error",
    3203: "the robot does not offer this action",
    3204: "the robot rejected the parameters",
    3205: "the robot is held by another program's lease",
    3206: "the robot is held by another program's lease",
    3207: "the robot is held by another program's lease",
    4201: "the action timed out on the robot",
    4205: "the robot is not ready for this action, or busy with another",
    4206: "the robot's posture or surroundings do not allow this action",
    7400: "the arm is busy",
    7401: "the arm still holds its last action",
    7402: "the arm does not know this action",
    7404: "the robot's present mode does not allow this action",
}
#: Codes that mean that the robot does not have this action at all.
UNSUPPORTED = (3103, 3203)
LATE = 3104
NO_ANSWER = (3102, LATE)


def explain(code: int) -> str:
    """Explain an error code."""
    return f"{CODES.get(code, 'the robot answered with an error')} (code {code})"


_lock = threading.Lock()
_connected: tuple[int, str] | None = None


def connect(domain: int, interface: str) -> None:
    """Join a DDS domain on a network interface. Raises `RobotBusy` when this process is on another one already."""
    global _connected  # noqa: PLW0603  the SDK's factory is as global
    import agentrob.process.dds  # noqa: I001  first: see above
    from unitree_sdk2py.core import channel

    with _lock:
        if _connected is not None:
            if _connected != (domain, interface):
                raise RobotBusy(f"this process speaks DDS on domain {_connected[0]} already; one process, one robot")
            return
        agentrob.process.dds.use_in(channel)
        try:
            channel.ChannelFactoryInitialize(domain, interface or None)
        except Exception:  # the SDK raises bare Exception
            raise RobotUnreachable(
                f"DDS could not be opened on interface {interface!r}, domain {domain}; `ip link` names the interfaces"
            ) from None
        _connected = (domain, interface)


def clients(*makers: tuple[Callable[[], C], float]) -> list[C]:
    """Make SDK clients at the same time (each takes 0.7 s): pairs of a class and its timeout in seconds."""
    made: list[Any] = [None] * len(makers)

    def make(i: int, maker: Callable[[], Any], timeout_s: float) -> None:
        client = maker()
        client.SetTimeout(timeout_s)
        client.Init()
        made[i] = client

    threads = [threading.Thread(target=make, args=(i, *m), daemon=True) for i, m in enumerate(makers)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if None in made:
        raise RobotUnreachable("a client of the Unitree SDK could not be made; see the lines above")
    return made


#: Messages of a topic are kept this long, and at most this often.
KEPT_S, KEPT_EVERY_S = 1.0, 0.02


class Topic:
    """The newest message of a DDS topic and when it came; `None` until the first.

    `heard` is called with both, in the listener's thread, and must return at once.
    """

    def __init__(self, name: str, kind: Any, heard: Callable[[float, Any], None] | None = None) -> None:
        from unitree_sdk2py.core.channel import ChannelSubscriber

        self._heard = heard
        self._newest: tuple[float, Any] | None = None
        self._kept: tuple[tuple[float, Any], ...] = ()
        self._subscriber = ChannelSubscriber(name, kind)
        self._subscriber.Init(self._take, 0)  # in the listener's own thread: what others read is replaced, not changed

    def _take(self, message: Any) -> None:
        now_s = time.monotonic()
        self._newest = (now_s, message)
        if not self._kept or now_s - self._kept[-1][0] >= KEPT_EVERY_S:
            self._kept = (*(one for one in self._kept if one[0] > now_s - KEPT_S), self._newest)
        if self._heard is not None:
            self._heard(now_s, message)

    def recent(self) -> tuple[tuple[float, Any], ...]:
        """(monotonic seconds, message) of the last second, oldest first, not all of them."""
        return self._kept

    def newest(self) -> tuple[float, Any] | None:
        """(monotonic seconds, message)."""
        return self._newest

    def close(self) -> None:
        self._subscriber.Close()


class PolledTopic:
    """A topic published more often than needed: one message is decoded every `every_s`, the others are skipped.

    `hurry` makes it more often for a while.
    """

    def __init__(self, name: str, kind: Any, every_s: float) -> None:
        from unitree_sdk2py.core.channel import ChannelSubscriber

        self.newest: Any = None
        self._subscriber = ChannelSubscriber(name, kind)
        self._subscriber.Init()
        self._closed, self._wake = False, threading.Event()
        self._hurry_s, self._hurry_until_s = every_s, 0.0
        threading.Thread(target=self._poll, args=(every_s,), name=f"poll {name}", daemon=True).start()

    def hurry(self, every_s: float, for_s: float) -> None:
        """Decode a message every `every_s` from now on, until nobody has called this for `for_s`."""
        idle = time.monotonic() >= self._hurry_until_s
        self._hurry_s, self._hurry_until_s = every_s, time.monotonic() + for_s
        if idle:
            self._wake.set()

    def _poll(self, every_s: float) -> None:
        while not self._closed:
            message = self._subscriber.Read(every_s)
            if message is not None:
                self.newest = message
                self._wake.wait(self._hurry_s if time.monotonic() < self._hurry_until_s else every_s)
                if not self._closed:
                    self._wake.clear()

    def close(self) -> None:
        self._closed = True
        self._wake.set()
