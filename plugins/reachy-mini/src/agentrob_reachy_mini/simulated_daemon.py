"""A small stand-in for `reachy-mini-daemon` with the part of its HTTP API that AgentRob uses, without its packages.

Its robot follows each move with a minimum-jerk profile and a short lag. It has no physics, camera or sound. The peer
tests hold it against the real daemon: both pass the same contract.
"""

from __future__ import annotations

import math
import threading
import time
import uuid
from dataclasses import dataclass
from datetime import UTC, datetime
from socket import socket
from typing import Any

import uvicorn
from fastapi import FastAPI, HTTPException
from pydantic import BaseModel

from agentrob.errors import SimError
from agentrob_reachy_mini.pose import BodyPose

#: How much later the body is where it was sent.
LAG_S = 0.04
#: The real daemon turns the body no farther than this, and the head no farther from it.
BODY_RAD, NECK_RAD = math.radians(160), math.radians(65)
READY_S = 20.0
PUSHED_RPS = 0.5


class HeadPose(BaseModel):
    """Metres and radians."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0


class Goto(BaseModel):
    head_pose: HeadPose | None = None
    antennas: tuple[float, float] | None = None
    body_yaw: float | None = None
    duration: float


class MoveId(BaseModel):
    uuid: uuid.UUID


@dataclass(slots=True)
class Faults:
    """Injected faults. `frozen`: its motors no longer answer, and the state repeats the last angles. `stuck`: moves are
    accepted, and nothing moves. `refusing`: moves are answered with an error. `degrees`: angles are told in degrees.
    `limp`: its motors are off. `deaf`: a stop is acknowledged, and the move goes on. `old_stamp`: the time stamp of the
    state does not advance. `pushed_s`: since this moment (monotonic) somebody turns the body at 0.5 rad/s."""

    frozen: bool = False
    stuck: bool = False
    refusing: bool = False
    degrees: bool = False
    limp: bool = False
    deaf: bool = False
    old_stamp: bool = False
    pushed_s: float = math.inf


@dataclass(frozen=True, slots=True)
class Move:
    id: str
    start: BodyPose
    end: BodyPose
    began_s: float
    seconds: float


class SimulatedDaemon:
    """Serves on a socket that listens, in a thread, until `close`. `commands` are the moves that it was asked for, and
    `stops` when it was asked to stop, by the monotonic clock. While `answering` is not set, requests wait."""

    def __init__(self, listening: socket) -> None:
        self.faults = Faults()
        self.commands: list[Goto] = []
        self.stops: list[float] = []
        self.answering = threading.Event()
        self.answering.set()
        self._lock = threading.Lock()
        self._move: Move | None = None
        self._held = BodyPose(right_antenna=-0.17, left_antenna=0.17)
        self._frozen: BodyPose | None = None
        self._alive = time.time()
        self._first_stamp = datetime.now(UTC)
        self._server = uvicorn.Server(uvicorn.Config(self._app(), log_level="warning", access_log=False))
        self._thread = threading.Thread(target=self._server.run, args=([listening],), name="reachy daemon", daemon=True)
        self._thread.start()
        end_s = time.monotonic() + READY_S
        while not self._server.started:
            if time.monotonic() > end_s or not self._thread.is_alive():
                raise SimError("the simulated daemon did not start")
            time.sleep(0.01)

    def close(self) -> None:
        self.answering.set()
        self._server.should_exit = True
        self._thread.join()

    # ------------------------------------------------------------ the body
    def target(self, now_s: float) -> BodyPose:
        """Where the daemon sends the body at a moment."""
        move = self._move
        if move is None:
            return self._held
        share = max(0.0, min(1.0, (now_s - move.began_s) / move.seconds))
        eased = share**3 * (10 - 15 * share + 6 * share**2)
        return BodyPose(*(a + (b - a) * eased for a, b in zip(move.start, move.end, strict=True)))

    def present(self) -> BodyPose:
        """Where the body is."""
        with self._lock:
            return self._present(time.monotonic())

    def _present(self, now_s: float) -> BodyPose:
        if self.faults.frozen:
            self._frozen = self._frozen or self.target(now_s - LAG_S)
            return self._frozen
        self._frozen = None
        pose, pushed = self.target(now_s - LAG_S), PUSHED_RPS * max(0.0, now_s - self.faults.pushed_s)
        return pose._replace(head_yaw=pose.head_yaw + pushed, body_yaw=pose.body_yaw + pushed)

    def _end_if_over(self, now_s: float) -> None:
        move = self._move
        if move is not None and now_s >= move.began_s + move.seconds + LAG_S:
            self._move, self._held = None, move.end

    def _running(self, now_s: float) -> Move | None:
        self._end_if_over(now_s)
        move = self._move
        return move if move is not None and now_s < move.began_s + move.seconds else None

    def _goto(self, goto: Goto) -> str:
        with self._lock:
            now_s, name = time.monotonic(), str(uuid.uuid4())
            self.commands.append(goto)
            if self._running(now_s) is not None or self.faults.stuck:
                return name  # as the real one: accepted, and ignored
            start = self._present(now_s)
            self._move = Move(name, start, _end(start, goto), now_s, max(goto.duration, 1e-3))
            return name

    def _stop(self, name: str) -> bool:
        with self._lock:
            now_s = time.monotonic()
            self.stops.append(now_s)
            move = self._running(now_s)
            if move is None or move.id != name:
                return False
            if not self.faults.deaf:
                self._held, self._move = self.target(now_s), None
            return True

    # ------------------------------------------------------------ the API
    def _app(self) -> FastAPI:
        app = FastAPI()

        @app.get("/api/state/full")
        def full_state() -> dict[str, Any]:
            self.answering.wait()
            pose, factor = self.present(), 180 / math.pi if self.faults.degrees else 1.0
            yaw, pitch, roll, body, right, left = (factor * value for value in pose[:6])
            head = {"x": 0.0, "y": 0.0, "z": pose.head_up_m, "roll": roll, "pitch": pitch, "yaw": yaw}
            stamp = self._first_stamp if self.faults.old_stamp else datetime.now(UTC)
            return {
                "control_mode": "disabled" if self.faults.limp else "enabled", "head_pose": head, "body_yaw": body,
                "antennas_position": [right, left], "timestamp": stamp.isoformat(),
            }  # fmt: skip

        @app.get("/api/daemon/status")
        def status() -> dict[str, Any]:
            self.answering.wait()
            if not self.faults.frozen:
                self._alive = time.time()
            return {"state": "running", "error": None, "backend_status": {"last_alive": self._alive, "error": None}}

        @app.get("/api/move/running")
        def running() -> list[dict[str, str]]:
            self.answering.wait()
            with self._lock:
                move = self._running(time.monotonic())
            return [] if move is None else [{"uuid": move.id}]

        @app.post("/api/move/goto")
        def goto(asked: Goto) -> dict[str, str]:
            self.answering.wait()
            if self.faults.refusing:
                raise HTTPException(503, "Backend not running")
            return {"uuid": self._goto(asked)}

        @app.post("/api/move/stop")
        def stop(move: MoveId) -> dict[str, str]:
            self.answering.wait()
            if not self._stop(str(move.uuid)):
                raise HTTPException(500, "Internal Server Error")
            return {"message": "Stopped"}

        return app


def _end(start: BodyPose, goto: Goto) -> BodyPose:
    """Where a move ends: as the real one, the body no farther than its limits and those of the neck."""
    head = goto.head_pose or HeadPose(yaw=start.head_yaw, pitch=start.pitch, roll=start.roll, z=start.head_up_m)
    body = start.body_yaw if goto.body_yaw is None else goto.body_yaw
    body = max(-BODY_RAD, min(BODY_RAD, max(head.yaw - NECK_RAD, min(head.yaw + NECK_RAD, body))))
    right, left = goto.antennas or (start.right_antenna, start.left_antenna)
    return BodyPose(head.yaw, head.pitch, head.roll, body, right, left, head.z)
