"""The Go2's services and topics on its DDS domain: sport, videohub, motion_switcher, sportmodestate, lowstate."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from agentrob.sim.services.dds import NOT_IMPLEMENTED, OK, ServiceCall  # patches DDS: before IDL types
from agentrob.sim.services.unitree import LOW_EVERY, RobotContext, RobotServices

# isort: split
from unitree_sdk2py.idl.default import unitree_go_msg_dds__LowState_
from unitree_sdk2py.idl.unitree_go.msg.dds_ import LowState_

from agentrob.sim.bodies import sensors
from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.faults import Faults
from agentrob.sim.services.go2_sport import WALKING, Sport
from agentrob.sim.world.legged import PERIOD_S

AMBIENT_C, WARMING_C_PER_NM, WARMING_S = 30.0, 1.2, 120.0  # of a motor
FEET = ("FR", "FL", "RR", "RL")
CHECK_MODE = 1001
MODE_NAME = {"form": "0", "name": "mcf"}  # the answer of a Go2 with the current motion service


class Go2Services(RobotServices):
    """Serves one Go2; adds ranges, a battery, foot forces and motor temperatures."""

    def __init__(self, body: Go2, context: RobotContext) -> None:
        self._body, self._sport = body, Sport(body, lambda: context.world.time_s, context.event_log)
        super().__init__(
            body, self._sport, context,
            state_topic="rt/sportmodestate", low=unitree_go_msg_dds__LowState_(), low_type=LowState_,
        )  # fmt: skip
        self._ranges = sensors.Ranges(body, context.rng, context.noisy)
        self._battery = sensors.Battery()
        self._warmth = np.full(len(body.build.joints), AMBIENT_C)
        self._stuck: list[float] | None = None  # what the ranges say for ever
        self._services = (
            self._serve("sport", "1.0.0.1", self._on_sport),
            self._serve("videohub", "1.0.0.1", self._on_video),
            self._serve("motion_switcher", "1.0.0.1", self._on_mode),
        )

    def _on_mode(self, call: ServiceCall) -> None:
        if call.api_id == CHECK_MODE:
            call.answer(OK, json.dumps(MODE_NAME))
        else:
            call.answer(NOT_IMPLEMENTED)

    def fail(self, faults: Faults) -> None:
        """Apply faults of the sensors until the next call."""
        super().fail(faults)
        self._stuck = None

    def _sense(self) -> None:
        torque = np.abs(self._body.data.qfrc_applied[self._body.v])
        self._battery.drain(float((torque * np.abs(self._body.joint_speeds_rps)).sum()), PERIOD_S)
        self._battery.exchange()
        self._warmth += (AMBIENT_C + WARMING_C_PER_NM * torque - self._warmth) * (PERIOD_S / WARMING_S)

    def _fill_more(self, state: Any) -> None:
        state.error_code, state.mode = self._sport.codes
        state.progress = self._sport.progress
        state.gait_type = 1 if self._sport.codes == WALKING else 0
        state.range_obstacle = self._read_ranges()
        if self._ticks % LOW_EVERY == 0:
            state.foot_force = sensors.foot_forces_n(self._body, FEET)

    def _read_ranges(self) -> list[float]:
        ranges: list[float] = self._ranges.read().tolist()
        match self._fault_state.now.ranges:
            case "missing":
                return [math.nan] * 4
            case "zero":
                return [0.0] * 4
            case "constant":
                self._stuck = self._stuck or ranges
                return self._stuck
            case _:
                return ranges

    def _fill_low(self, low: Any) -> None:
        body = self._body
        torque, speeds = body.data.qfrc_applied[body.v].tolist(), body.joint_speeds_rps.tolist()
        rows = zip(body.joints_rad.tolist(), speeds, torque, self._warmth.tolist(), strict=True)
        for motor, (q, dq, tau, warmth) in zip(low.motor_state[:12], rows, strict=True):
            motor.mode, motor.q, motor.dq, motor.tau_est, motor.temperature = 1, q, dq, tau, round(warmth)
        low.imu_state = self._state.imu_state
        low.foot_force = self._state.foot_force
        fault_percent = self._fault_state.now.battery_percent
        low.bms_state.soc = math.ceil(self._battery.percent if fault_percent is None else fault_percent)
        low.bms_state.current = -round(1000 * self._battery.power_w / self._battery.volts)
        low.power_v, low.power_a = self._battery.volts, self._battery.power_w / self._battery.volts
