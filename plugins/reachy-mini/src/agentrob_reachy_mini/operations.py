"""The operations of a Reachy Mini as declarations: the words for them in English and Chinese, angles and measures.

"Look left" already means a turn to every robot: it turns the body, and the head goes along.
"""

from __future__ import annotations

from dataclasses import replace

from agentrob.model import BUILT_IN, ActionClass, Number, Op, Operation, Quantity, Unit
from agentrob.model.operations.declaration import Choice, Option
from agentrob_reachy_mini.options import ReachyOptions
from agentrob_reachy_mini.pose import HEAD_PITCH_DEG, HEAD_ROLL_DEG, HEAD_YAW_DEG

#: How far an angle may be from what was asked.
TOLERANCE_DEG = 4.0
LOOK_UP, LOOK_DOWN, GLANCE, TILT, CENTRE = "look_up", "look_down", "glance", "tilt_head", "center_head"
NOD, SHAKE_HEAD, ANTENNAS, SWAY, GROOVE = "nod", "shake_head", "wiggle_antennas", "sway", "groove"
ANGLE, SIDE, SECONDS = "angle_deg", "side", "seconds"
#: The operations of recorded moves are named so.
PLAY = "play_"

_SIDE = Choice(
    SIDE,
    (
        Option("left", {"en": "left|to the left|to your left", "zh": "左边|左"}),
        Option("right", {"en": "right|to the right|to your right", "zh": "右边|右"}),
    ),
)
_MEASURED_ANGLE = (Quantity(ANGLE, Unit.DEGREES, TOLERANCE_DEG),)


def _angle(most: float, default: float) -> Number:
    return Number(ANGLE, Unit.DEGREES, least=5, most=most, default=default)


def _gesture(name: str, en: str, zh: str, done_en: str, done_zh: str, takes_s: float) -> Operation:
    measured = (Quantity("head_deg" if name != ANTENNAS else "antenna_deg", Unit.DEGREES),)
    return Operation(
        name, ActionClass.GESTURE, {"en": en, "zh": zh}, done={"en": done_en, "zh": done_zh}, travel_m=0.0,
        takes_s=takes_s, time_limit_s=15.0, measured=measured, harmless=True,
    )  # fmt: skip


def _look(name: str, arguments: tuple[Choice | Number, ...], en: str, zh: str, done_en: str, done_zh: str) -> Operation:
    return Operation(
        name, ActionClass.GESTURE, {"en": en, "zh": zh}, arguments, {"en": done_en, "zh": done_zh}, travel_m=0.0,
        takes_s=1.5, time_limit_s=15.0, measured=_MEASURED_ANGLE if arguments else (Quantity("off_deg", Unit.DEGREES),),
    )  # fmt: skip


def _dance(name: str, en: str, zh: str, done_en: str, done_zh: str) -> Operation:
    seconds = Number(SECONDS, Unit.SECONDS, least=3, most=20, default=6)
    measured = (Quantity(SECONDS, Unit.SECONDS, tolerance=2.0), Quantity("head_deg", Unit.DEGREES))
    return Operation(
        name, ActionClass.GESTURE, {"en": en, "zh": zh}, (seconds,), {"en": done_en, "zh": done_zh}, travel_m=0.0,
        takes_s=1.0, time_limit_s=10.0, measured=measured, harmless=True,
    )  # fmt: skip


#: Its foot stays where it stands, so that a turn of the body needs no free space.
TURN_BODY = replace(
    BUILT_IN[Op.TURN], travel_m=0.0, takes_s=3.0, measured=(Quantity("degrees", Unit.DEGREES, TOLERANCE_DEG),)
)
#: It greets with its antennas.
GREET = replace(BUILT_IN[Op.HELLO], travel_m=0.0, takes_s=3.0, time_limit_s=15.0)

DECLARED = (
    TURN_BODY,
    GREET,
    _look(LOOK_UP, (_angle(HEAD_PITCH_DEG, 20),), "look up|raise your head|lift your head", "抬头|抬起头|抬抬头|仰头",
          "looked up", "抬了头"),
    _look(LOOK_DOWN, (_angle(HEAD_PITCH_DEG, 20),), "look down|lower your head|bow your head", "低头|低下头|低低头",
          "looked down", "低了头"),
    _look(GLANCE, (_SIDE, _angle(HEAD_YAW_DEG, 30)), "glance {side}|glance",
          "瞥{side}|往{side}瞥|向{side}瞥|瞄{side}", "glanced aside", "瞥了一眼"),
    _look(TILT, (_SIDE, _angle(HEAD_ROLL_DEG, 15)), "tilt your head {side}|tilt your head",
          "歪头|向{side}歪头|往{side}歪头", "tilted its head", "歪了头"),
    _look(CENTRE, (), "center your head|centre your head|straighten your head", "头摆正|把头摆正|摆正头",
          "centered its head", "把头摆正了"),
    _gesture(NOD, "nod|nod your head|give a nod", "点点头|点头|点个头|点一下头", "nodded", "点了头", 1.5),
    _gesture(SHAKE_HEAD, "shake your head|shake the head", "摇摇头|摇头|摇一摇头", "shook its head", "摇了头", 2.5),
    _gesture(ANTENNAS, "wiggle your antennas|wiggle the antennas|move your antennas|wiggle antennas|wiggle your ears",
             "动动天线|摇摇天线|晃晃天线|摆动天线|动一动天线", "wiggled its antennas", "动了天线", 2.5),
    _dance(SWAY, "sway|sway to the music|sway from side to side", "左右摇摆|摇摆身体|随音乐摇摆", "swayed", "摇摆了"),
    _dance(GROOVE, "groove|bob your head|do the groove", "律动|跟着节奏点头|跟着节拍动", "grooved", "律动了"),
)  # fmt: skip


def declared(options: ReachyOptions) -> tuple[Operation, ...]:
    """Its own operations, and the recorded moves of its configuration. Raises `ValueError` for words that cannot be."""
    return (*DECLARED, *(_recorded(name, options) for name in options.moves))


def _recorded(name: str, options: ReachyOptions) -> Operation:
    move = options.moves[name]
    return Operation(
        PLAY + name,
        ActionClass.GESTURE,
        move.words,
        travel_m=0.0,
        takes_s=move.seconds,
        time_limit_s=move.seconds + 5.0,
        measured=(Quantity("head_deg", Unit.DEGREES),),
    )
