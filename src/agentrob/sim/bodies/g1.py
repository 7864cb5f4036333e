"""The Unitree G1's body in the world (29 joints): walking by its policy, arm motions on top of it, and damping."""

from __future__ import annotations

from typing import Any

import numpy as np

from agentrob.sim.bodies.g1_gestures import Indices
from agentrob.sim.bodies.g1_policy import COMMAND_SLEW, STAND_RAD, TORQUE_NM, G1Policy, G1Trim
from agentrob.sim.bodies.go2_gestures import Motion
from agentrob.sim.world import assets
from agentrob.sim.world.legged import PERIOD_S, Array, Build, Drive, Legged
from agentrob.sim.world.scene import Start

#: Velocities that the policy follows well: forward, sideways (m/s) and turning (rad/s).
VELOCITY_BOUND: Array = np.array([0.6, 0.3, 0.8])

FRICTION = 0.1  # of a joint
CAMERA_BODY, CAMERA_AT_M, CAMERA_FOVY_DEG = "torso_link", [0.12, 0.0, 0.42], 60
CAMERA_AXES = [0, -1, 0, 0.4, 0, 0.92]  # tilted down by 23 degrees: it sees the floor 1 to 6 m ahead

CALM_MPS, CALM_RPS, CALM_S = 0.08, 0.15, 0.4  # slower than this for so long: it stands (it sways all the time)
HAND_BACK_S = 0.3  # from the last pose of a gesture to what the policy wants
LIMP_DAMPING = 2.0  # factor on KD in damping mode


class G1(Legged):
    """Follows `walk(vx, vy, yaw_rate)` and can move its arms at the same time, or is limp."""

    def __init__(self, name: str = "g1", start: Start | None = None) -> None:
        super().__init__(name, start)
        self._policy = G1Policy(assets.policy("g1"))
        self._trim = G1Trim()
        motors = self._policy.motors
        self.build = Build(
            root="pelvis",
            joints=motors.names,
            kp=motors.kp,
            kd=motors.kd,
            torque_nm=TORQUE_NM,
            rest_rad=STAND_RAD,
            height_m=0.78,
        )

    def add_to(self, spec: Any, collision_group: int) -> None:
        import mujoco

        path = assets.model("g1")
        robot = mujoco.MjSpec.from_file(str(path))
        robot.meshdir = str(path.parent / "assets")
        for name, armature in zip(self.build.joints, self._policy.motors.armature, strict=True):
            joint = robot.joint(name)
            joint.armature, joint.frictionloss, joint.damping = armature, FRICTION, [0, 0, 0]
        robot.body(CAMERA_BODY).add_camera(name="front", pos=CAMERA_AT_M, xyaxes=CAMERA_AXES, fovy=CAMERA_FOVY_DEG)
        for geom in robot.geoms:
            if geom.classname.name in ("collision", "foot"):
                geom.group = collision_group
        for part in (*robot.keys, *robot.actuators, *robot.lights):
            robot.delete(part)
        robot.option.cone, robot.option.impratio = spec.option.cone, spec.option.impratio
        robot.option.timestep, robot.option.integrator = spec.option.timestep, spec.option.integrator
        spec.attach(robot, prefix=f"{self.name}/", frame=spec.worldbody.add_frame())

    # ------------------------------------------------------------------ commands (by the world's thread)
    def begin(self) -> None:
        self._wanted, self._slewed = np.zeros(3), np.zeros(3)
        self._target = STAND_RAD.copy()
        self._arms: _Arms | None = None
        self._limp = False
        self._calm_s = 0.0
        self._policy.reset()
        self._trim.reset()

    def walk(self, velocity: Array) -> None:
        """Walk at (vx, vy, yaw rate), clipped to `VELOCITY_BOUND`; zeros mean stand. Ends `go_limp`."""
        if self._limp:
            self._limp = False
            self._policy.reset()
        self._wanted = np.clip(velocity, -VELOCITY_BOUND, VELOCITY_BOUND)

    def move_arms(self, joints: Indices, motion: Motion) -> None:
        """Move these joints through a motion; afterwards they hold its last pose until `free_arms`."""
        seen = self._arms.seen_rad if self._arms and len(self._arms.joints) == len(joints) else self.joints_rad[joints]
        self._arms = _Arms(joints, motion, seen)

    def free_arms(self) -> None:
        """Return the arms to the policy smoothly."""
        if self._arms is not None:
            self._arms.motion = None

    def go_limp(self) -> None:
        """Only damp the joints: the robot falls."""
        self._wanted = np.zeros(3)
        self._arms, self._limp = None, True

    @property
    def arms_moving(self) -> bool:
        """Whether a motion of the arms is running."""
        return self._arms is not None and not self._arms.ended

    @property
    def standing(self) -> bool:
        """Whether it was commanded to stand and is at rest."""
        return not self._limp and not self._wanted.any() and self._calm_s >= CALM_S

    @property
    def target_rad(self) -> Array:
        """The joint targets of the last period."""
        return self._target

    # ------------------------------------------------------------------ one period
    def drive(self) -> Drive:
        if self._limp:
            return Drive(self.joints_rad, 0.0, LIMP_DAMPING)
        velocity = self.heading_velocity()
        vx, vy, turning = velocity
        calm = float(np.hypot(vx, vy)) < CALM_MPS and abs(turning) < CALM_RPS
        self._calm_s = self._calm_s + PERIOD_S if calm else 0.0
        self._slewed += np.clip(self._wanted - self._slewed, -COMMAND_SLEW, COMMAND_SLEW)
        joints, speeds = self.joints_rad, self.joint_speeds_rps
        if self._arms is not None:  # it must not see them: beyond what it was trained with it falls
            joints[self._arms.joints], speeds[self._arms.joints] = self._arms.seen_rad, 0.0
        asked = self._slewed
        if self._wanted.any():
            asked = self._trim.follow(self._slewed, velocity)
        else:
            self._trim.reset()
        target = self._policy.targets(self.gyro_rps, -self.rotation[2], joints, speeds, asked)
        if self._arms is not None:
            target[self._arms.joints] = self._arms.next(target[self._arms.joints], self._target[self._arms.joints])
            if self._arms.back:
                self._arms = None
        self._target = target
        return Drive(target)


class _Arms:
    """Arm joints that follow a motion, then hold its pose, then return to the policy."""

    def __init__(self, joints: Indices, motion: Motion, seen_rad: Array) -> None:
        self.joints, self.seen_rad = joints, seen_rad
        self.motion: Motion | None = motion
        self.ended = False
        self._playing_s = self._giving_s = 0.0

    @property
    def back(self) -> bool:
        return self._giving_s >= HAND_BACK_S

    def next(self, policy: Array, last: Array) -> Array:
        """The targets of this period, from the policy's targets and the previous ones."""
        if self.motion is not None:
            pose = self.motion(self._playing_s)
            self._playing_s += PERIOD_S
            self.ended = pose is None
            return last if pose is None else pose[0]
        self.ended = True
        self._giving_s += PERIOD_S
        left_s = max(HAND_BACK_S - self._giving_s, 0.0)
        share = PERIOD_S / (left_s + PERIOD_S)
        return np.asarray(last + share * (policy - last))
