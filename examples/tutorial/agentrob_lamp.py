"""A desk lamp as a robot, and a mind that knows when somebody needs light: the example of docs/start/tutorial.md."""

import time
from collections.abc import Sequence

from agentrob import (
    ActionClass,
    ActionResult,
    Addressee,
    Capabilities,
    Intent,
    Number,
    Operation,
    Plan,
    Pose,
    Primitive,
    Quantity,
    RobotConfig,
    RobotState,
    RulesMind,
    StopResult,
    Understanding,
    Unit,
    Watch,
    limits_of,
    run_for,
)

SHINE = Operation(
    "shine",
    ActionClass.GESTURE,
    words={"en": "shine|light up|give me {seconds} of light", "zh": "发光|亮灯"},
    done={"en": "shone", "zh": "亮了灯"},
    arguments=(Number("seconds", Unit.SECONDS, least=1, most=20, default=2),),
    measured=(Quantity("seconds", Unit.SECONDS, tolerance=0.5),),
    takes_s=0.0,
    harmless=True,
)


class Lamp:
    """A lamp that stands on a desk. It can shine, and nothing else."""

    @classmethod
    def describe(cls, settings: RobotConfig) -> Capabilities:
        """What a lamp can do; AgentRob asks before it makes one."""
        return Capabilities("lamp", frozenset(), limits_of(settings), declared=(SHINE,), simulated=True)

    def __init__(self, settings: RobotConfig) -> None:
        self.capabilities = self.describe(settings)
        self.on = False
        self.stops = 0

    def state(self) -> RobotState:
        """It never moves, so its state is always the same."""
        return RobotState(
            age_s=0.0,
            pose=Pose(0.0, 0.0, 0.0),
            velocity_mps=(0.0, 0.0),
            yaw_rate_rps=0.0,
            mode="gesture" if self.on else "idle",
            ranges_m=(None, None, None, None),
            upright=True,
        )

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        """Shine for the seconds that were asked for, unless the guard or a stop ends it."""
        before = self.stops

        def watch_and_listen(state: RobotState) -> str | None:
            return "stop" if self.stops != before else watch(state)

        seconds = primitive.value("seconds")
        return run_for(self, primitive, watch_and_listen, seconds, self._switch_on, self._switch_off)

    def stop(self) -> StopResult:
        """Switch off at once, and end the step that is under way."""
        was_on = self.on
        self.stops += 1
        self._switch_off()
        return StopResult(latency_ms=0.0, confirmed=True, was_moving=was_on, coasted_m=0.0)

    def close(self) -> None:
        self._switch_off()

    def now_s(self) -> float:
        return time.monotonic()

    def wait_until(self, time_s: float) -> None:
        time.sleep(max(0.0, time_s - self.now_s()))

    def _switch_on(self) -> None:
        self.on = True  # here you would switch a pin of your computer

    def _switch_off(self) -> None:
        self.on = False


class ConsiderateMind:
    """Reads posts by the rules, and makes light where somebody complains that it is dark."""

    name = "considerate"

    def __init__(self) -> None:
        self._rules = RulesMind()

    async def understand(self, text: str, addressee: Addressee, history: Sequence[Plan] = ()) -> Understanding:
        understood = await self._rules.understand(text, addressee, history)
        unclear = understood.intent in (Intent.ASK_BACK, Intent.NOTHING)
        if not unclear or "dark" not in text.lower() or SHINE not in addressee.capabilities.declared:
            return understood
        shine = Primitive(SHINE.name, arguments=(("seconds", 5),), declared=SHINE)
        return Understanding(Intent.COMMAND, plan=Plan((shine,), notes=("You said that it is dark.",)))
