"""Base of the services of the simulated Unitree robots: sport, videohub, odometry and low state."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import mujoco
import numpy as np

from agentrob.sim.services.dds import (  # patches DDS: before IDL types
    INTERNAL,
    NOT_IMPLEMENTED,
    OK,
    Node,
    Service,
    ServiceCall,
)

# isort: split
from unitree_sdk2py.idl.default import unitree_go_msg_dds__SportModeState_
from unitree_sdk2py.idl.unitree_go.msg.dds_ import SportModeState_
from unitree_sdk2py.utils.crc import CRC

from agentrob.sim.bodies import sensors
from agentrob.sim.event_log import EventLog
from agentrob.sim.faults import Faults, FaultState, black_picture
from agentrob.sim.rendering.cameras import Cameras
from agentrob.sim.world.legged import PERIOD_S, Legged
from agentrob.sim.world.world import World

COMMAND_EVERY_S = 0.05  # a driver that walks a robot commands it this often
LOW_EVERY = 5  # ticks: lowstate at 10 Hz (500 on a real robot), odometry at every tick (50 Hz)
GET_IMAGE_SAMPLE = 1001


@dataclass(frozen=True, slots=True)
class RobotContext:
    """The parts of the simulator that one robot's services use. `call_soon(work)` runs work in the world's thread."""

    node: Node
    world: World
    cameras: Cameras
    event_log: EventLog
    call_soon: Callable[[Callable[[], None]], None]
    rng: np.random.Generator
    noisy: bool


class MotionService(Protocol):
    """The motion service of a body (`Sport`, `G1Sport`)."""

    @property
    def commanded_s(self) -> float | None:
        """When the velocity came that is held now, in simulated seconds; None while none is held."""
        ...

    def call(self, api_id: int, parameter: Mapping[str, Any], answer: Callable[..., None]) -> None: ...

    def tick(self) -> None: ...

    def reset(self) -> None: ...


class RobotServices:
    """Serves one robot. `before_tick`, `after_tick`, `fail` and `reset` are called in the world's thread.

    A subclass defines its topics, adds to the state, and fills the low state.
    """

    def __init__(
        self, body: Legged, sport: MotionService, context: RobotContext, *, state_topic: str, low: Any, low_type: Any
    ) -> None:
        self._context = context
        self._motion_service = sport
        self._legged = body
        self._odometry = sensors.Odometry(body, context.rng, context.noisy)
        self._inertia = sensors.Inertia(body, context.rng, context.noisy)
        self._velocity_noise = sensors.VELOCITY_NOISE_MPS if context.noisy else 0.0
        self._fault_state = FaultState(body)
        self._ticks = 0
        self._clock_s = 0.0  # how far its clock has leapt
        self._state = unitree_go_msg_dds__SportModeState_()
        self._low = low
        self._checksum = CRC()  # without it, Unitree's C++ library rejects the message
        self._state_out = context.node.writer(state_topic, SportModeState_)
        self._low_out = context.node.writer("rt/lowstate", low_type)

    # ------------------------------------------------------------------ of each kind
    def _sense(self) -> None:
        """Update this kind's sensors in a tick, before the state is published."""

    def _fill_more(self, state: Any) -> None:
        """Fill this kind's fields of the state besides odometry and attitude."""

    def _fill_low(self, low: Any) -> None:
        """Fill the low state: joints and other data that is published less often."""
        raise NotImplementedError

    # ------------------------------------------------------------------ services (DDS threads)
    def _serve(self, name: str, version: str, on_call: Callable[[ServiceCall], None]) -> Service:
        return Service(self._context.node, name, version, on_call)

    def _on_sport(self, call: ServiceCall) -> None:
        if not self._fault_state.swallows():
            self._context.call_soon(lambda: self._motion_service.call(call.api_id, call.parameter, call.answer))

    def _on_video(self, call: ServiceCall) -> None:
        if call.api_id != GET_IMAGE_SAMPLE:
            call.answer(NOT_IMPLEMENTED)
            return
        if _spoil_picture(call, self._fault_state.now):
            return

        def deliver(jpeg: bytes | None) -> None:
            if jpeg:
                call.answer(OK, "", jpeg)
            else:
                call.answer(INTERNAL)

        self._context.cameras.request(f"{self._legged.name}/front", deliver)

    # ------------------------------------------------------------------ topics (world's thread)
    def before_tick(self) -> None:
        """Once per tick, before the physics: holds, gestures."""
        self._fault_state.tick(PERIOD_S)
        self._motion_service.tick()

    def awaits_command(self) -> bool:
        """Whether the next command of a driver that walks the robot is due."""
        commanded_s = self._motion_service.commanded_s
        return commanded_s is not None and self._context.world.time_s - commanded_s > COMMAND_EVERY_S

    def reset(self) -> None:
        """Reset after the world was reset: odometry starts at zero, as after a restart of the robot."""
        self._motion_service.reset()
        self._odometry.reset()
        self.fail(Faults(self._legged.name))

    def fail(self, faults: Faults) -> None:
        """Apply faults of the sensors until the next call."""
        self._fault_state.make(faults)
        self._clock_s += faults.clock_s
        self._odometry.jump(*faults.jump_m)

    def after_tick(self) -> None:
        """Once per tick, after the physics: sense and publish."""
        self._odometry.update()
        self._sense()
        self._fill_state()
        if not self._fault_state.mute:
            self._state_out.write(self._state)
        if self._ticks % LOW_EVERY == 0:
            low = self._low
            self._fill_low(low)
            low.tick = self._ticks * round(PERIOD_S * 1000)
            low.crc = self._checksum.Crc(low)
            if not self._fault_state.now.unplugged:
                self._low_out.write(low)
        self._ticks += 1

    def _fill_state(self) -> None:
        state, body = self._state, self._legged
        x, y, yaw = (math.nan,) * 3 if self._fault_state.now.lost else self._odometry.read()
        velocity = body.heading_velocity() + self._context.rng.normal(0, 1, 3) * self._velocity_noise
        state.position = [x, y, body.z_m]
        state.body_height = body.z_m
        state.velocity = [float(velocity[0]), float(velocity[1]), 0.0]
        state.yaw_speed = float(velocity[2])
        roll, pitch = self._inertia.tilt_rad()
        quaternion = np.zeros(4)
        mujoco.mju_euler2Quat(quaternion, np.array([roll, pitch, yaw]), "XYZ")  # yaw after pitch after roll
        imu = state.imu_state
        imu.rpy = [roll, pitch, yaw]
        imu.quaternion = quaternion.tolist()
        imu.gyroscope = self._inertia.gyro_rps().tolist()
        imu.accelerometer = self._inertia.acceleration_mps2().tolist()
        state.stamp.sec, state.stamp.nanosec = _stamp(max(0.0, self._context.world.time_s + self._clock_s))
        self._fill_more(state)


def _stamp(seconds: float) -> tuple[int, int]:
    whole = int(seconds)
    return whole, int((seconds - whole) * 1e9)


def _spoil_picture(call: ServiceCall, faults: Faults) -> bool:
    """Answer for a camera that is dead, black or unplugged; return False if it works."""
    if faults.unplugged or faults.camera == "good":
        return faults.unplugged
    if faults.camera == "dead":
        call.answer(INTERNAL)
    else:
        call.answer(OK, "", black_picture())
    return True
