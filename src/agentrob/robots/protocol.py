"""The robot protocol: four blocking calls, made by the driver process only."""

from __future__ import annotations

from collections.abc import Callable
from threading import Event
from typing import Protocol, runtime_checkable

from agentrob.config.robots import RobotConfig
from agentrob.model import ActionResult, Capabilities, Limits, Posture, Primitive, RobotState, StopResult

#: Called at every control period (20 times a second) while a step runs. Returns a reason to stop now (a stable code as
#: in `ActionResult.reason`) or None to continue. The guard and the driver pass their own.
Watch = Callable[[RobotState], str | None]

#: From the centre of the body to its corners: the radius that a turn on the spot sweeps (Go2: 0.70 m x 0.31 m).
BODY_RADIUS_M = 0.40


class Robot(Protocol):
    """One robot, constructed as `cls(settings: RobotConfig)`.

    `stop` may be called from another thread at any time, also while a step runs.
    """

    capabilities: Capabilities

    def state(self) -> RobotState:
        """Return the newest known state; never blocks."""
        ...

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        """Do one step, block until it has ended, and measure it. If `watch` returns a reason, stop the body and return
        `stopped` with that reason.

        A step that cannot be done is a result, not an exception. `primitive.speed_mps` limits the speed; for a turn,
        the speed of the body's corners (`BODY_RADIUS_M` from the centre).
        """
        ...

    def stop(self) -> StopResult:
        """Command zero velocity at once, on a channel of its own; then wait for rest (at most 3 s)."""
        ...

    def close(self) -> None: ...


@runtime_checkable
class HasCamera(Protocol):
    """A robot whose camera can also be read while it moves."""

    def look(self) -> bytes:
        """Return a JPEG of its own camera. Called on a separate thread, also while a step runs, which it must not
        delay. Raises `RobotError` if there is no picture.
        """
        ...


@runtime_checkable
class HasPosture(Protocol):
    """A robot that also reports the attitude of its body and its joint angles, for the live view."""

    def posture(self, *, joints: bool) -> Posture:
        """Return the newest known posture; never blocks. Its `pose` is in the robot's own odometry frame. Joint angles
        are only read if asked for: that they are decoded takes time."""
        ...


@runtime_checkable
class ExplainsSilence(Protocol):
    """A robot that can say why no states or no range readings come: nobody publishes a topic, its QoS differs."""

    def silence(self) -> str:
        """Return sentences for its owner, empty if nothing is known to be wrong. Called when a step is refused for
        want of a fresh state or of ranges; takes at most some milliseconds."""
        ...


class Simulator(Protocol):
    """The simulation of a robot that its package brings along: the entry point `agentrob.simulators` of the robot's
    model names a class of this kind, which is constructed without arguments."""

    def settings(self, settings: RobotConfig) -> RobotConfig:
        """Return the settings of a robot that is simulated: those given (model, domain, `simulated`) with its options,
        map and scene. Raises `SimError` with a sentence that says what must be installed if it cannot run here."""
        ...

    def serve(self, settings: RobotConfig, ended: Event) -> None:
        """Simulate the robot on the domain and interface of the settings until `ended` is set. Call
        `print_ready` when its driver may connect. Runs in the main thread of a process of its
        own."""
        ...


def limits_of(settings: RobotConfig) -> Limits:
    """The limits of law 10 from the robot's settings."""
    return Limits(**settings.limits.model_dump())
