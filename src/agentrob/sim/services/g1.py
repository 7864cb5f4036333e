"""The G1's services and topics on its DDS domain: sport, arm, videohub, odommodestate, lowstate.

`rt/odommodestate` (a `SportModeState_`) is the topic that the vendor's documentation names for the G1's odometry; which
of its fields a real G1 fills is not verified, so only position, velocity, yaw speed and attitude are filled here, and
the stamp, which times the steps of simulated robots.
**`videohub` is a convention of ours**: a real G1 serves its pictures otherwise, and not on DDS.
"""

from __future__ import annotations

from typing import Any

from agentrob.sim.services.dds import ServiceCall  # patches DDS: before IDL types
from agentrob.sim.services.unitree import RobotContext, RobotServices

# isort: split
from unitree_sdk2py.idl.default import unitree_hg_msg_dds__LowState_
from unitree_sdk2py.idl.unitree_hg.msg.dds_ import LowState_

from agentrob.sim.bodies.g1 import G1
from agentrob.sim.services.g1_sport import G1Sport

MOTOR_C = 32  # all of them: the G1's warmth is not simulated


class G1Services(RobotServices):
    """Serves one G1, which has no ranges that could fail."""

    def __init__(self, body: G1, context: RobotContext) -> None:
        self._body, self._sport = body, G1Sport(body, lambda: context.world.time_s, context.event_log)
        super().__init__(
            body, self._sport, context,
            state_topic="rt/odommodestate", low=unitree_hg_msg_dds__LowState_(), low_type=LowState_,
        )  # fmt: skip
        self._services = (
            self._serve("sport", "1.0.0.0", self._on_sport),
            self._serve("arm", "1.0.0.14", self._on_arm),
            self._serve("videohub", "1.0.0.1", self._on_video),
        )

    def _on_arm(self, call: ServiceCall) -> None:
        if not self._fault_state.swallows():
            self._context.call_soon(lambda: self._sport.call_arm(call.api_id, call.parameter, call.answer))

    def _fill_low(self, low: Any) -> None:
        body, felt = self._body, self._state.imu_state
        torque = body.data.qfrc_applied[body.v].tolist()
        rows = zip(body.joints_rad.tolist(), body.joint_speeds_rps.tolist(), torque, strict=True)
        for motor, (q, dq, tau) in zip(low.motor_state, rows, strict=False):  # 29 of 35
            motor.mode, motor.q, motor.dq, motor.tau_est, motor.temperature = 1, q, dq, tau, [MOTOR_C, MOTOR_C]
        imu = low.imu_state
        imu.rpy, imu.quaternion = felt.rpy, felt.quaternion
        imu.gyroscope, imu.accelerometer = felt.gyroscope, felt.accelerometer
