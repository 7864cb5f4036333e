"""A client of the HTTP API of `reachy-mini-daemon`: its state, its moves, and how they are stopped."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import httpx2

from agentrob.errors import RobotError
from agentrob_reachy_mini.pose import BodyPose, checked, implausible

#: A state that takes longer is too old to be worth waiting for.
STATE_S, COMMAND_S = 0.4, 2.0
MOTORS_ON = "enabled"


class DaemonLost(RobotError):
    """The daemon does not answer."""


class DaemonRefused(RobotError):
    """The daemon answers with an error, or with something else than it should."""


class Sample(NamedTuple):
    """A state as the daemon tells it: its own time stamp, the mode of the motors, the pose."""

    stamp: str
    mode: str
    pose: BodyPose


class Health(NamedTuple):
    """`running`: whether its control loop runs; `error`: what it says is wrong. `alive`: when its motors last answered,
    by its own clock; None in its simulations."""

    running: bool
    error: str
    alive: float | None


class Daemon:
    """The daemon at a URL. Its methods may be called from several threads; they raise `DaemonLost` and
    `DaemonRefused`."""

    def __init__(self, url: str) -> None:
        self.url = url
        self._http = httpx2.Client(base_url=url, trust_env=False, timeout=COMMAND_S)
        # A stop waits for no other request and for no new connection: what is asked all the time keeps this one open.
        self._stopping = httpx2.Client(base_url=url, trust_env=False, timeout=COMMAND_S)

    def state(self) -> Sample:
        """Raises `DaemonRefused` too where what it says is not an angle of this robot in radians."""
        answer = self._get("/api/state/full", STATE_S)
        try:
            head, antennas = answer["head_pose"], answer["antennas_position"]
            numbers = (
                head["yaw"], head["pitch"], head["roll"], answer["body_yaw"], antennas[0], antennas[1], head["z"],
            )  # fmt: skip
            pose = BodyPose(*(float(number) for number in numbers))
            sample = Sample(str(answer["timestamp"]), str(answer["control_mode"]), pose)
        except (KeyError, IndexError, TypeError, ValueError) as e:
            raise DaemonRefused(f"The state of {self.url} lacks {e}; is it reachy-mini-daemon 1.12 or newer?") from None
        if wrong := implausible(pose):
            raise DaemonRefused(wrong)
        return sample

    def health(self) -> Health:
        answer = self._get("/api/daemon/status", STATE_S)
        if not isinstance(answer, Mapping):
            raise DaemonRefused(f"The status of {self.url} is not an object.")
        backend = answer.get("backend_status") or {}
        alive, error = backend.get("last_alive"), answer.get("error") or backend.get("error") or ""
        return Health(answer.get("state") == "running", str(error), alive if isinstance(alive, float | int) else None)

    def running(self) -> frozenset[str]:
        """The ids of the moves that run now."""
        answer = self._answer(self._stopping, "GET", "/api/move/running", None, STATE_S)
        try:
            return frozenset(str(move["uuid"]) for move in answer)
        except (KeyError, TypeError):
            raise DaemonRefused(f"The running moves of {self.url} are not a list of ids.") from None

    def goto(self, pose: BodyPose, seconds: float) -> str:
        """Start a minimum-jerk motion to a pose and return its id; it takes so many seconds. Raises `OutOfReach` for
        what is outside the bounds, before anything is sent."""
        checked(pose)
        head = {"x": 0.0, "y": 0.0, "z": pose.head_up_m, "roll": pose.roll, "pitch": pose.pitch, "yaw": pose.head_yaw}
        target = {
            "head_pose": head, "antennas": [pose.right_antenna, pose.left_antenna], "body_yaw": pose.body_yaw,
            "duration": seconds,
        }  # fmt: skip
        return self._started(self._post("/api/move/goto", target))

    def play(self, dataset: str, move: str) -> str:
        """Start a recorded move and return its id."""
        return self._started(self._post(f"/api/move/play/recorded-move-dataset/{dataset}/{move}", None))

    def stop(self, move: str) -> bool:
        """End a move where it is; the robot holds its pose. Return whether it ran: the daemon answers with a server
        error for one that has ended."""
        try:
            self._answer(self._stopping, "POST", "/api/move/stop", {"uuid": move}, COMMAND_S)
        except DaemonRefused:
            return False
        return True

    def close(self) -> None:
        self._http.close()
        self._stopping.close()

    def _started(self, answer: Any) -> str:
        try:
            return str(answer["uuid"])
        except (KeyError, TypeError):
            raise DaemonRefused(f"{self.url} did not say which move it started.") from None

    def _get(self, path: str, limit_s: float) -> Any:
        return self._answer(self._http, "GET", path, None, limit_s)

    def _post(self, path: str, content: Any) -> Any:
        return self._answer(self._http, "POST", path, content, COMMAND_S)

    def _answer(self, http: httpx2.Client, method: str, path: str, content: Any, limit_s: float) -> Any:
        try:
            response = http.request(method, path, json=content, timeout=limit_s)
        except httpx2.HTTPError as e:
            raise DaemonLost(f"{self.url} does not answer ({type(e).__name__}).") from None
        except RuntimeError:  # a client that was closed meanwhile
            raise DaemonLost(f"{self.url} is not connected any more.") from None
        if response.status_code != 200:
            raise DaemonRefused(f"{self.url}{path} answered {response.status_code}: {_reason(response)}")
        try:
            return response.json()
        except ValueError:
            raise DaemonRefused(f"{self.url}{path} answered with something else than JSON.") from None


def _reason(response: httpx2.Response) -> str:
    try:
        return str(response.json()["detail"])[:120]
    except (ValueError, KeyError, TypeError):
        return response.reason_phrase
