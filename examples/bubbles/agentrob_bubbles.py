"""A robot that blows bubbles: the example of an operation that AgentRob does not know (docs/robots/add-a-robot.md)."""

from dataclasses import replace

from agentrob import (
    ActionClass,
    ActionResult,
    Capabilities,
    FakeRobot,
    Number,
    Operation,
    Primitive,
    Quantity,
    RobotConfig,
    Unit,
    Watch,
    run_for,
)

BLOW_BUBBLES = Operation(
    "blow_bubbles",
    ActionClass.GESTURE,
    words={"en": "blow bubbles|make bubbles|blow {seconds} of bubbles", "zh": "吹泡泡|吹{seconds}泡泡"},
    done={"en": "blew bubbles", "zh": "吹了泡泡"},
    arguments=(Number("seconds", Unit.SECONDS, least=1, most=10, default=3),),
    measured=(Quantity("seconds", Unit.SECONDS, tolerance=0.5),),
    free_space_m=0.5,
    takes_s=1.0,
)


class BubbleRobot(FakeRobot):
    """The fake robot with a fan, which `step` switches on and off."""

    fan = False

    @classmethod
    def describe(cls, settings: RobotConfig) -> Capabilities:
        return replace(super().describe(settings), model="bubbles", declared=(BLOW_BUBBLES,))

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        if primitive.op != BLOW_BUBBLES.name:
            return super().step(primitive, watch)
        return run_for(self, primitive, watch, primitive.value("seconds"), self._fan_on, self._fan_off)

    def _fan_on(self) -> None:
        self.fan = True

    def _fan_off(self) -> None:
        self.fan = False
