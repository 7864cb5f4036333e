"""The G1's services and topics on its DDS domain: sport, arm, videohub, odommodestate, lowstate.

`rt/odommodestate` (a `SportModeState_`) is the topic that the vendor's documentation names for the G1's odometry; which
of its fields a real G1 fills is not verified, so only position, velocity, yaw speed and attitude are filled here.
**`videohub` is a convention of ours**: a real G1 serves its pictures otherwise, and not on DDS.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np

from agentrob.sim.services import INTERNAL, NOT_IMPLEMENTED, OK, Call, Service  # patches DDS: before IDL types

# isort: split
from unitree_sdk2py.idl.default import unitree_go_msg_dds__SportModeState_, unitree_hg_msg_dds__LowState_
from unitree_sdk2py.idl.unitree_go.msg.dds_ import SportModeState_
from unitree_sdk2py.idl.unitree_hg.msg.dds_ import LowState_
from unitree_sdk2py.utils.crc import CRC

from agentrob.sim import sensors
from agentrob.sim.faults import Faults, Trouble
from agentrob.sim.g1 import G1
from agentrob.sim.g1_sport import G1Sport
from agentrob.sim.go2_services import GET_IMAGE_SAMPLE, Station, spoil_picture
from agentrob.sim.policy import PERIOD_S

LOW_EVERY = 5  # ticks: lowstate at 10 Hz (500 on the real robot), odommodestate at every tick (50 Hz)
MOTOR_C = 32  # all of them: the G1's warmth is not simulated


class G1Services:
    """Serves one G1. `before_tick`, `after_tick` and `reset` are called in the world's thread."""

    def __init__(self, body: G1, station: Station) -> None:
        self._body, self._station = body, station
        self._sport = G1Sport(body, lambda: station.world.time_s, station.ledger)
        rng, noisy, node = station.rng, station.noisy, station.node
        self._odometry = sensors.Odometry(body, rng, noisy)
        self._inertia = sensors.Inertia(body, rng, noisy)
        self._velocity_noise = sensors.VELOCITY_NOISE_MPS if noisy else 0.0
        self._ticks = 0
        self._trouble = Trouble(body)
        self._state = unitree_go_msg_dds__SportModeState_()
        self._low = unitree_hg_msg_dds__LowState_()
        self._checksum = CRC()  # without it Unitree's own C++ library takes the message for broken
        self._state_out = node.writer("rt/odommodestate", SportModeState_)
        self._low_out = node.writer("rt/lowstate", LowState_)
        self._services = (
            Service(node, "sport", "1.0.0.0", self._on_sport),
            Service(node, "arm", "1.0.0.14", self._on_arm),
            Service(node, "videohub", "1.0.0.1", self._on_video),
        )

    # ------------------------------------------------------------------ services (DDS threads)
    def _on_sport(self, call: Call) -> None:
        if not self._trouble.swallows():
            self._station.later(lambda: self._sport.call(call.api_id, call.parameter, call.answer))

    def _on_arm(self, call: Call) -> None:
        if not self._trouble.swallows():
            self._station.later(lambda: self._sport.call_arm(call.api_id, call.parameter, call.answer))

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

    # ------------------------------------------------------------------ topics (world's thread)
    def before_tick(self) -> None:
        """Once per tick, before the physics: holds, gestures."""
        self._trouble.tick(PERIOD_S)
        self._sport.tick()

    def reset(self) -> None:
        """The world was put back: odometry starts again at zero, as after a restart of the robot."""
        self._sport.reset()
        self._odometry.reset()
        self.fail(Faults(self._body.name))

    def fail(self, faults: Faults) -> None:
        """Sense wrongly from now on, until told otherwise. It has no ranges that could fail."""
        self._trouble.make(faults)
        self._odometry.jump(*faults.jump_m)

    def after_tick(self) -> None:
        """Once per tick, after the physics: sense and publish."""
        self._odometry.update()
        self._fill_state()
        if not self._trouble.mute:
            self._state_out.write(self._state)
        if self._ticks % LOW_EVERY == 0:
            self._fill_low()
            if not self._trouble.now.unplugged:
                self._low_out.write(self._low)
        self._ticks += 1

    def _fill_state(self) -> None:
        state, body = self._state, self._body
        x, y, yaw = (math.nan,) * 3 if self._trouble.now.lost else self._odometry.read()
        velocity = body.heading_velocity() + self._station.rng.normal(0, 1, 3) * self._velocity_noise
        state.position = [x, y, body.z_m]
        state.body_height = body.z_m
        state.velocity = [float(velocity[0]), float(velocity[1]), 0.0]
        state.yaw_speed = float(velocity[2])
        roll, pitch = self._inertia.tilt_rad()
        quaternion = np.zeros(4)
        mujoco.mju_euler2Quat(quaternion, np.array([roll, pitch, yaw]), "XYZ")
        imu = state.imu_state
        imu.rpy = [roll, pitch, yaw]
        imu.quaternion = quaternion.tolist()
        imu.gyroscope = self._inertia.gyro_rps().tolist()
        imu.accelerometer = self._inertia.acceleration_mps2().tolist()

    def _fill_low(self) -> None:
        low, body, felt = self._low, self._body, self._state.imu_state
        torque = body.data.qfrc_applied[body.v].tolist()
        rows = zip(body.joints_rad.tolist(), body.joint_speeds_rps.tolist(), torque, strict=True)
        for motor, (q, dq, tau) in zip(low.motor_state, rows, strict=False):  # 29 of 35
            motor.mode, motor.q, motor.dq, motor.tau_est, motor.temperature = 1, q, dq, tau, [MOTOR_C, MOTOR_C]
        imu = low.imu_state
        imu.rpy, imu.quaternion = felt.rpy, felt.quaternion
        imu.gyroscope, imu.accelerometer = felt.gyroscope, felt.accelerometer
        low.tick = self._ticks * round(PERIOD_S * 1000)
        low.crc = self._checksum.Crc(low)
