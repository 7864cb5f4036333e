"""A robot whose body is another process (`kill_body`), so that it continues when its driver is killed, like a real one.

The driver finds it by its entry point, like any third party's robot.
"""

from __future__ import annotations

import io
import json
import socket
import threading
import time
from typing import Any

from PIL import Image

from agentrob.config.robots import RobotConfig
from agentrob.model import ActionResult, Capabilities, Op, Outcome, Primitive, RobotState, StopResult
from agentrob.robots import codec
from agentrob.robots.control.controller import RATE_HZ, Gait, Velocity
from agentrob.robots.control.step_runner import REST_LIMIT_S, run_step
from agentrob.robots.protocol import Watch, limits_of

GAIT = Gait(gain_speed=3.0, gain_turn=4.0, coast_s=0.15, coast_turn_s=0.15, settle_s=0.4)


class RemoteBodyRobot:
    """See `agentrob.robots.protocol.Robot`. `options.body` is the socket of its body."""

    @classmethod
    def describe(cls, settings: RobotConfig) -> Capabilities:
        return Capabilities(
            "far", frozenset({Op.MOVE, Op.TURN, Op.GET_FRONT_IMAGE}), limits_of(settings), simulated=True
        )

    def __init__(self, settings: RobotConfig) -> None:
        self.capabilities = self.describe(settings)
        limits = self.capabilities.limits
        self._gait = GAIT.at_most(limits.speed_mps, limits.turn_dps * 3.14159 / 180)
        self._lock, self._stops = threading.Lock(), 0
        body = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        body.connect(settings.options["body"])
        self._lines = body.makefile("rw", encoding="utf-8")

    def _ask(self, what: str, **facts: Any) -> Any:
        with self._lock:
            self._lines.write(json.dumps({"what": what, **facts}) + "\n")
            self._lines.flush()
            return json.loads(self._lines.readline())

    # ------------------------------------------------------------ the robot
    def state(self) -> RobotState:
        return codec.decode_state(self._ask("state"))

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        before = self._stops
        attentive: Watch = lambda state: "stop" if self._stops != before else watch(state)  # noqa: E731
        if primitive.moves:
            self._ask("step", op=str(primitive.op))
            return run_step(self, primitive, self._gait, attentive)
        now_s = time.monotonic()
        return ActionResult(primitive, Outcome.DONE, {}, started_s=now_s, ended_s=now_s, image=self.picture())

    def picture(self) -> bytes:
        data = io.BytesIO()
        Image.effect_noise((160, 120), 60).convert("RGB").save(data, "JPEG")
        return data.getvalue()

    def stop(self) -> StopResult:
        asked_s = time.monotonic()
        self._stops += 1
        was_moving = not self._resting()
        self.rest()
        latency_ms, end_s = 1000 * (time.monotonic() - asked_s), asked_s + REST_LIMIT_S
        while not (resting := self._resting()) and time.monotonic() < end_s:
            self.wait_until(time.monotonic() + 1 / RATE_HZ)
        return StopResult(latency_ms, resting, was_moving, None, "")

    def _resting(self) -> bool:
        return not self._ask("moving")

    def close(self) -> None:
        self.rest()

    # ------------------------------------------------------------ agentrob.robots.control.step_runner.Body
    def now_s(self) -> float:
        return time.monotonic()

    def command(self, velocity: Velocity) -> None:
        self._ask("command", velocity=velocity)

    def rest(self) -> None:
        self._ask("rest")

    def wait_until(self, time_s: float) -> None:
        time.sleep(max(0.0, time_s - time.monotonic()))
