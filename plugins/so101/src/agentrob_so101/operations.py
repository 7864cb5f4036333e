"""The operations of the arm: their declarations, and the poses that they lead through."""

from __future__ import annotations

from dataclasses import replace

from agentrob.model import BUILT_IN, ActionClass, Choice, Number, Op, Operation, Option, Primitive, Quantity, Unit
from agentrob_so101.pose import ArmPose

HOME, POINT, OPEN, CLOSE, PICK = "rest_pose", "point", "open_gripper", "close_gripper", "pick_up_cube"
WAY, ANGLE, OPENING, OFF = "way", "angle", "opening", "joint_error"

#: Folded above its foot, with the gripper in front of it.
HOME_POSE = ArmPose(0.0, -70.0, 75.0, 30.0, 0.0, 10.0)
#: Up, with the gripper waving.
WAVE_POSE = ArmPose(0.0, -35.0, -10.0, -15.0, 0.0, 10.0)
WAVE_DEG, WAVES = 25.0, 2
POINT_DEG, POINT_TOLERANCE_DEG, OPENING_TOLERANCE = 60.0, 5.0, 6.0
#: How much of an angle upwards is done by each joint.
UP = ArmPose(0.0, -0.4, -0.3, -0.3)

_WAYS = (
    Option("left", {"en": "left", "zh": "左边|左|左侧"}),
    Option("right", {"en": "right", "zh": "右边|右|右侧"}),
    Option("up", {"en": "up|upwards|the ceiling", "zh": "上面|上|上方"}),
)

DECLARED = (
    replace(BUILT_IN[Op.HELLO], takes_s=10.0, time_limit_s=40.0),
    Operation(
        HOME,
        ActionClass.GESTURE,
        words={
            "en": "go home|home|go to the home pose|return home|move home|fold up",
            "zh": "归位|回到初始位置|收回手臂|回零位|回初始姿态",
        },
        done={"en": "went to its home pose, with a largest joint error", "zh": "回到了初始位置，最大关节误差"},
        measured=(Quantity(OFF, Unit.DEGREES),),
        takes_s=5.0,
        harmless=True,
    ),
    Operation(
        POINT,
        ActionClass.GESTURE,
        words={
            "en": "point {way}|point to the {way}|point to your {way}|point your arm {way}|point at {way}",
            "zh": "指向{way}|指{way}|往{way}指|朝{way}指|向{way}指",
        },
        done={"en": "pointed {way}", "zh": "指了{way}"},
        arguments=(Choice(WAY, _WAYS), Number(ANGLE, Unit.DEGREES, 5.0, 90.0, POINT_DEG)),
        measured=(Quantity(ANGLE, Unit.DEGREES, tolerance=POINT_TOLERANCE_DEG),),
        takes_s=5.0,
        harmless=True,
    ),
    Operation(
        OPEN,
        ActionClass.GESTURE,
        words={
            "en": "open the gripper|open your gripper|open gripper|open the gripper to {opening}|open your hand|"
            "open the claw|open the jaws",
            "zh": "张开夹爪|打开夹爪|松开夹爪|夹爪张开{opening}|夹爪张开到{opening}|张开手",
        },
        done={"en": "opened the gripper", "zh": "张开了夹爪"},
        arguments=(Number(OPENING, Unit.PERCENT, 10.0, 100.0, 100.0),),
        measured=(Quantity(OPENING, Unit.PERCENT, tolerance=OPENING_TOLERANCE),),
        takes_s=2.0,
    ),
    Operation(
        CLOSE,
        ActionClass.GESTURE,
        words={
            "en": "close the gripper|close your gripper|close gripper|close your hand|close the claw|close the jaws",
            "zh": "合上夹爪|闭合夹爪|夹紧|合上手",
        },
        done={"en": "closed the gripper to", "zh": "合上了夹爪"},
        measured=(Quantity(OPENING, Unit.PERCENT),),
        takes_s=2.0,
    ),
)
#: What only the simulated arm does: it knows where its camera is.
PICK_UP = Operation(
    PICK,
    ActionClass.GESTURE,
    words={
        "en": "pick up the red cube|pick up the cube|grab the red cube|grasp the red cube|take the red cube|"
        "pick the red cube up",
        "zh": "拿起红色方块|抓起红色方块|捡起红色方块|抓住红色方块|拿起方块",
    },
    done={"en": "picked up the red cube, gripper open", "zh": "拿起了红色方块，夹爪张开"},
    measured=(Quantity(OPENING, Unit.PERCENT),),
    takes_s=16.0,
)


def way_of(step: Primitive, now: ArmPose) -> tuple[ArmPose, ...]:
    """Return the poses that a step leads through from where the arm is now; the gripper stays as it is unless the step
    is about it."""
    if step.op == OPEN:
        return (now._replace(gripper=float(step.value(OPENING))),)
    if step.op == CLOSE:
        return (now._replace(gripper=0.0),)
    if step.op == POINT:
        return (_pointing(str(step.value(WAY)), float(step.value(ANGLE)))._replace(gripper=now.gripper),)
    if step.op == HOME:
        return (HOME_POSE._replace(gripper=now.gripper),)
    start = WAVE_POSE._replace(gripper=now.gripper)
    left, right = (start._replace(wrist_flex=start.wrist_flex + side * WAVE_DEG) for side in (-1, 1))
    return (start, *((left, right) * WAVES), start, HOME_POSE._replace(gripper=now.gripper))


def _pointing(way: str, angle_deg: float) -> ArmPose:
    if way == "up":
        return ArmPose(*(angle_deg * share for share in UP))
    return ArmPose(shoulder_pan=angle_deg if way == "right" else -angle_deg)
