"""What a robot is: four calls, all blocking, made from the driver's process only."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from agentrob.model import ActionResult, Capabilities, Primitive, RobotState, StopResult

#: Looked at 20 times a second while a step runs: a reason to stop now (a stable word as in `ActionResult.reason`), or
#: None to go on. The guard and the driver pass their own; a robot must ask it at every control period.
Watch = Callable[[RobotState], str | None]


class Robot(Protocol):
    """One robot. `step` blocks until the step has ended, `stop` may be called from another thread at any time."""

    capabilities: Capabilities

    def state(self) -> RobotState:
        """What is known now; never blocks."""
        ...

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        """Do one step and measure it. When `watch` gives a reason: stop the body, then return `stopped` with it.

        A step that cannot be done is a result, not an exception.
        """
        ...

    def stop(self) -> StopResult:
        """Zero velocity at once, on a path of its own; then watch the state for rest (at most 3 s)."""
        ...

    def close(self) -> None: ...
