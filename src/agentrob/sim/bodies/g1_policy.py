"""The walking policy of the G1: its observations, its actions, and the motor parameters it was trained with.

The packaged policy (agentrob-world) carries joint names and gains in its own metadata. Joints are in that order:
left leg 0-5, right leg 6-11, waist 12-14, left arm 15-21, right arm 22-28.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from agentrob.sim.bodies.go2_policy import VelocityTrim, onnx_session
from agentrob.sim.world.legged import PERIOD_S, Array

_LEG = (-0.312, 0.0, 0.0, 0.669, -0.363, 0.0)
#: Standing with the knees a little bent and the forearms ahead.
STAND_RAD: Array = np.array([*_LEG, *_LEG, 0, 0, 0, 0.2, 0.2, 0, 0.6, 0, 0, 0, 0.2, -0.2, 0, 0.6, 0, 0, 0])
TORQUE_NM: Array = np.array([88, 139, 88, 139, 50, 50] * 2 + [88, 50, 50] + [25, 25, 25, 25, 25, 5, 5] * 2, float)
ACTION_SCALE = 0.25
GYRO_SCALE, JOINT_SPEED_SCALE = 0.25, 0.05
COMMAND_SLEW = 0.05  # most a command (m/s, rad/s) changes in one period
LEAST_COMMAND = 0.01  # below this it stands
STEP_RAD = 2 * math.pi * PERIOD_S  # of the phase each period: one stride a second
CLIP = 100.0
#: Reflected inertia (kg m²) by the natural frequency that the gains were made for: kp = armature x (10 Hz)².
_NATURAL_RPS = 2 * math.pi * 10.0


class G1Trim(VelocityTrim):
    """Like the Go2's; this policy follows better, and keeps stepping while any trim is applied."""

    FILTER_S = 0.5
    LACK: Array = np.zeros(3)
    GAIN: Array = np.array([0.8, 0.8, 1.0])
    BOUND: Array = np.array([0.10, 0.10, 0.15])


@dataclass(frozen=True, slots=True)
class Motors:
    """Per joint (29,): names, gains (N·m/rad, N·m·s/rad) and rotor inertia (kg·m²)."""

    names: tuple[str, ...]
    kp: Array
    kd: Array
    armature: Array


class G1Policy:
    """Computes joint targets from a velocity at 50 Hz; keeps the phase of the stride."""

    def __init__(self, path: Path) -> None:
        self._session = onnx_session(path)
        self._input = self._session.get_inputs()[0].name
        self._output = self._session.get_outputs()[0].name
        facts = self._session.get_modelmeta().custom_metadata_map
        kp, kd = np.array(json.loads(facts["kp"]), float), np.array(json.loads(facts["kd"]), float)
        self.motors = Motors(tuple(json.loads(facts["dof_names"])), kp, kd, kp / _NATURAL_RPS**2)
        self.reset()

    def reset(self) -> None:
        self._last_action = np.zeros(len(STAND_RAD))
        self._phase = np.array([0.0, math.pi])
        self._stands = False

    def targets(self, gyro: Array, gravity: Array, joints: Array, joint_speeds: Array, velocity: Array) -> Array:
        """Joint targets (29, rad); arguments as those of the Go2's policy (`agentrob.sim.bodies.go2_policy`)."""
        wanted = velocity if np.abs(velocity).max() >= LEAST_COMMAND else np.zeros(3)
        seen = np.concatenate(
            [
                self._last_action,
                gyro * GYRO_SCALE,
                wanted[2:],
                wanted[:2],
                np.cos(self._phase),
                joints - STAND_RAD,
                joint_speeds * JOINT_SPEED_SCALE,
                gravity,
                np.sin(self._phase),
            ]
        )
        batch = np.clip(seen, -CLIP, CLIP).astype(np.float32)[None, :]
        (answer,) = self._session.run([self._output], {self._input: batch})
        self._last_action = np.clip(answer[0].astype(np.float64), -CLIP, CLIP)
        self._stride(bool(wanted.any()))
        return np.asarray(STAND_RAD + self._last_action * ACTION_SCALE)

    def _stride(self, walks: bool) -> None:
        if not walks:
            self._phase, self._stands = np.full(2, math.pi), True
        elif self._stands:
            self._phase, self._stands = np.array([0.0, math.pi]), False
        else:
            self._phase = np.fmod(self._phase + STEP_RAD + math.pi, 2 * math.pi) - math.pi
