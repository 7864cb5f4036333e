"""The Go2's services and topics on its DDS domain: sport, videohub, motion_switcher, sportmodestate, lowstate."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from agentrob.sim.services import INTERNAL, NOT_IMPLEMENTED, OK, Call, Node, Service  # patches DDS: before IDL types

# isort: split
from unitree_sdk2py.idl.default import unitree_go_msg_dds__LowState_, unitree_go_msg_dds__SportModeState_
from unitree_sdk2py.idl.unitree_go.msg.dds_ import LowState_, SportModeState_
from unitree_sdk2py.utils.crc import CRC

from agentrob.sim import sensors
from agentrob.sim.cameras import Cameras
from agentrob.sim.faults import Faults, Trouble, black_picture
from agentrob.sim.go2 import Go2
from agentrob.sim.ledger import Ledger
from agentrob.sim.legged import Array
from agentrob.sim.policy import PERIOD_S
from agentrob.sim.sport import WALKING, Sport
from agentrob.sim.world import World

AMBIENT_C, WARMING_C_PER_NM, WARMING_S = 30.0, 1.2, 120.0  # of a motor
LOW_EVERY = 5  # ticks: lowstate at 10 Hz, sportmodestate at every tick (50 Hz)
FEET = ("FR", "FL", "RR", "RL")
GET_IMAGE_SAMPLE, CHECK_MODE = 1001, 1001
MODE_NAME = {"form": "0", "name": "mcf"}  # what a Go2 with the present motion service answers


@dataclass(frozen=True, slots=True)
class Station:
    """What the world's process lends to the services of one robot. `later(work)` runs work in the world's thread."""

    node: Node
    world: World
    cameras: Cameras
    ledger: Ledger
    later: Callable[[Callable[[], None]], None]
    rng: np.random.Generator
    noisy: bool


class Go2Services:
    """Serves one Go2. `before_tick`, `after_tick` and `reset` are called in the world's thread."""

    def __init__(self, body: Go2, station: Station) -> None:
        self._body, self._station = body, station
        self._sport = Sport(body, lambda: station.world.time_s, station.ledger)
        rng, noisy, node = station.rng, station.noisy, station.node
        self._odometry = sensors.Odometry(body, rng, noisy)
        self._ranges = sensors.Ranges(body, rng, noisy)
        self._inertia = sensors.Inertia(body, rng, noisy)
        self._battery = sensors.Battery()
        self._velocity_noise = sensors.VELOCITY_NOISE_MPS if noisy else 0.0
        self._warmth = np.full(len(body.build.joints), AMBIENT_C)
        self._trouble = Trouble(body)
        self._stuck: list[float] | None = None  # what the ranges say for ever
        self._clock_s = 0.0  # how far its clock has leapt
        self._ticks = 0
        self._state = unitree_go_msg_dds__SportModeState_()
        self._low = unitree_go_msg_dds__LowState_()
        self._checksum = CRC()  # without it Unitree's own C++ library takes the message for broken
        self._state_out = node.writer("rt/sportmodestate", SportModeState_)
        self._low_out = node.writer("rt/lowstate", LowState_)
        self._services = (
            Service(node, "sport", "1.0.0.1", self._on_sport),
            Service(node, "videohub", "1.0.0.1", self._on_video),
            Service(node, "motion_switcher", "1.0.0.1", self._on_mode),
        )

    # ------------------------------------------------------------------ services (DDS threads)
    def _on_sport(self, call: Call) -> None:
        if not self._trouble.swallows():
            self._station.later(lambda: self._sport.call(call.api_id, call.parameter, call.answer))

    def _on_video(self, call: Call) -> None:
        if call.api_id != GET_IMAGE_SAMPLE:
            call.answer(NOT_IMPLEMENTED)
            return
        if spoil_picture(call, self._trouble.now):
            return

        def deliver(jpeg: bytes | None) -> None:
            if jpeg:
                call.answer(OK, "", jpeg)
            else:
                call.answer(INTERNAL)

        self._station.cameras.request(f"{self._body.name}/front", deliver)

    def _on_mode(self, call: Call) -> None:
        if call.api_id == CHECK_MODE:
            call.answer(OK, json.dumps(MODE_NAME))
        else:
            call.answer(NOT_IMPLEMENTED)

    # ------------------------------------------------------------------ topics (world's thread)
    def before_tick(self) -> None:
        """Once per tick, before the physics: holds, actions."""
        self._trouble.tick(PERIOD_S)
        self._sport.tick()

    def reset(self) -> None:
        """The world was put back: odometry starts again at zero, as after a restart of the robot."""
        self._sport.reset()
        self._odometry.reset()
        self.fail(Faults(self._body.name))

    def fail(self, faults: Faults) -> None:
        """Sense wrongly from now on, until told otherwise."""
        self._trouble.make(faults)
        self._stuck = None
        self._clock_s += faults.clock_s
        self._odometry.jump(*faults.jump_m)

    def after_tick(self) -> None:
        """Once per tick, after the physics: sense and publish."""
        self._odometry.update()
        torque = np.asarray(self._body.data.qfrc_applied[self._body.v])
        speeds = self._body.joint_speeds_rps
        self._battery.drain(float(np.abs(torque * speeds).sum()), PERIOD_S)
        self._battery.exchange()
        self._warmth += (AMBIENT_C + WARMING_C_PER_NM * np.abs(torque) - self._warmth) * (PERIOD_S / WARMING_S)
        self._fill_state()
        if not self._trouble.mute:
            self._state_out.write(self._state)
        if self._ticks % LOW_EVERY == 0:
            self._fill_low(torque, speeds)
            if not self._trouble.now.unplugged:
                self._low_out.write(self._low)
        self._ticks += 1

    def _fill_state(self) -> None:
        state, body = self._state, self._body
        x, y, yaw = (math.nan,) * 3 if self._trouble.now.lost else self._odometry.read()
        velocity = body.heading_velocity() + self._station.rng.normal(0, 1, 3) * self._velocity_noise
        state.error_code, state.mode = self._sport.codes
        state.progress = self._sport.progress
        state.gait_type = 1 if self._sport.codes == WALKING else 0
        state.stamp.sec, state.stamp.nanosec = _stamp(max(0.0, self._station.world.time_s + self._clock_s))
        state.position = [x, y, body.z_m]
        state.body_height = body.z_m
        state.velocity = [float(velocity[0]), float(velocity[1]), 0.0]
        state.yaw_speed = float(velocity[2])
        state.range_obstacle = self._read_ranges()
        roll, pitch = self._inertia.tilt_rad()
        imu = state.imu_state
        imu.rpy = [roll, pitch, yaw]
        imu.quaternion = _quaternion(roll, pitch, yaw)
        imu.gyroscope = self._inertia.gyro_rps().tolist()
        imu.accelerometer = self._inertia.acceleration_mps2().tolist()
        if self._ticks % LOW_EVERY == 0:
            state.foot_force = sensors.foot_forces_n(body, FEET)

    def _read_ranges(self) -> list[float]:
        ranges: list[float] = self._ranges.read().tolist()
        match self._trouble.now.ranges:
            case "missing":
                return [math.nan] * 4
            case "zero":
                return [0.0] * 4
            case "constant":
                self._stuck = self._stuck or ranges
                return self._stuck
            case _:
                return ranges

    def _fill_low(self, torque: Array, speeds: Array) -> None:
        low = self._low
        rows = zip(self._body.joints_rad.tolist(), speeds.tolist(), torque.tolist(), self._warmth.tolist(), strict=True)
        for motor, (q, dq, tau, warmth) in zip(low.motor_state[:12], rows, strict=True):
            motor.mode, motor.q, motor.dq, motor.tau_est, motor.temperature = 1, q, dq, tau, round(warmth)
        low.imu_state = self._state.imu_state
        low.foot_force = self._state.foot_force
        told = self._trouble.now.battery_percent
        low.bms_state.soc = math.ceil(self._battery.percent if told is None else told)
        low.bms_state.current = -round(1000 * self._battery.power_w / self._battery.volts)
        low.power_v, low.power_a = self._battery.volts, self._battery.power_w / self._battery.volts
        low.tick = self._ticks * round(PERIOD_S * 1000)
        low.crc = self._checksum.Crc(low)


def spoil_picture(call: Call, faults: Faults) -> bool:
    """Answer for a camera that is dead, black or cut off; False when it is well."""
    if faults.unplugged or faults.camera == "good":
        return faults.unplugged
    if faults.camera == "dead":
        call.answer(INTERNAL)
    else:
        call.answer(OK, "", black_picture())
    return True


def _stamp(seconds: float) -> tuple[int, int]:
    whole = int(seconds)
    return whole, int((seconds - whole) * 1e9)


def _quaternion(roll: float, pitch: float, yaw: float) -> list[float]:
    """(w, x, y, z) of yaw after pitch after roll."""
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]
