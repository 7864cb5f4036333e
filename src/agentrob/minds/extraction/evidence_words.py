"""The words that count as evidence, in English and Chinese: actions, directions, units, and words of doubt."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from agentrob.model import Direction, Op

V = TypeVar("V")


def _table(rows: Mapping[str, V]) -> dict[str, V]:
    """Phrases separated by | to what they mean."""
    return {phrase.strip(): value for phrases, value in rows.items() for phrase in phrases.split("|")}


#: Only forms that can order something: "walked" and "has turned" are none.
ACTIONS: dict[str, tuple[Op, ...]] = _table(
    {
        "walk|move|go|step|advance|proceed|stroll|march|travel|"
        "head|come|drive|run|trot|crawl|scoot|shuffle|strafe|"
        "go back|walk back|move back|come back|step back|sidestep|walking|moving|going|approach|"
        "retreat|back up|back off|reverse|pace|roll|creep|amble|wander|"
        "走|移动|前进|前行|后退|倒退|退后|退|行走|平移|横移|挪|移|迈|跑|直走|直行|过去|过来|靠近": (Op.MOVE,),
        "turn back|turn|rotate|spin|pivot|swivel|twist|face|swing|turning|rotating|"
        "veer|转|旋转|转动|转向|转身|掉头|调头|拐|扭": (Op.TURN,),
        "wave|waving|greet|say hello|say hi|greeting|hello|打招呼|打个招呼|招手|挥手|挥挥手|问好|问个好|你好": (
            Op.HELLO,
        ),
        "shake hands|shake hand|shake my hand|shake a hand|handshake|shake paws|shake paw|"
        "offer your hand|give me your hand|give me your paw|give paw|give me a paw|offer your paw|"
        "握手|握个手|握握手|握一握手|握一下手|伸出手|伸爪子|给个爪子": (Op.SHAKE, Op.HELLO),
        "clap|clapping|clap hands|applaud|applause|"
        "鼓掌|鼓个掌|鼓鼓掌|拍手|拍拍手|拍个手|拍一拍手|拍一下手|拍掌|拍拍掌|拍巴掌": (Op.CLAP,),
        "heart|make a heart|show love|比心|比个心|爱心|画心|画个心": (Op.HEART,),
        "backflip|back flip|flip|somersault|后空翻|空翻|翻跟头|翻个跟头|跟斗": (Op.BACKFLIP,),
        "sit|sit down|have a seat|take a seat|坐|坐下": (Op.SIT,),
        "stand|stand up|get up|rise|站起来|起立|站立|起来": (Op.STAND,),
        "stretch|stretching|limber up|伸懒腰|伸个懒腰|伸展|拉伸|舒展": (Op.STRETCH,),
        "photo|picture|pic|photograph|image|snapshot|snap|shot|"
        "selfie|camera|look|see|show me|what do you see|view|"
        "photos|pictures|pics|images|拍照|照片|拍|照相|"
        "照|图片|看看|看一下|看见|看到|画面|相片": (Op.GET_FRONT_IMAGE,),
    }
)

DIRECTIONS: dict[str, Direction] = _table(
    {
        "forward|forwards|ahead|straight|straight ahead|onward|onwards|advance|frontward|"
        "前|向前|往前|朝前|前进|前行|直走|直行|前面|前方": Direction.FORWARD,
        "go back|walk back|move back|come back|step back|and back|now back|backward|backwards|"
        "back|back up|back off|retreat|reverse|rearward|rearwards|behind|"
        "后|向后|往后|朝后|后退|倒退|退后|退|后面|后方": Direction.BACKWARD,
        "left|leftward|leftwards|counterclockwise|counter-clockwise|anticlockwise|anti-clockwise|port|"
        "左|向左|往左|左边|左侧|左转|左拐|逆时针": Direction.LEFT,
        "right|rightward|rightwards|clockwise|starboard|右|向右|往右|右边|右侧|右转|右拐|顺时针": Direction.RIGHT,
    }
)
# "左转" is a direction and an action at once.
ACTIONS |= dict.fromkeys(("左转", "左拐", "右转", "右拐"), (Op.TURN,))

#: Phrases that say an angle without a number.
FIXED_ANGLES: dict[str, float] = _table(
    {
        "turn around|turn round|about face|u-turn|u turn|half turn|half circle|"
        "掉头|调头|转身|转过身|转过去|向后转|转半圈": 180.0,
        "full turn|full circle|full rotation|complete turn|all the way around|"
        "spin around|转一圈|转个圈|转圈|转一整圈": 360.0,
        "right angle|quarter turn|直角|四分之一圈": 90.0,
    }
)

#: Words that are neither: (kind, value).
MARKS: dict[str, tuple[str, float]] = _table(
    {
        "don't|do not|dont|not|never|no|without|avoid|instead of|rather than|neither|nor|refuse|stop|"
        "cannot|can't|won't|"
        "shouldn't|must not|mustn't|isn't|wasn't|didn't|forget|ignore|except|"
        "不|别|勿|没|没有|不要|不用|禁止|拒绝|避免|停|停止|除了": ("not", 0.0),
        "if|unless|until|while|whenever|when|once|as soon as|otherwise|or|either|whether|"
        "如果|要是|假如|除非|直到|的时候|一旦|否则|或者|或|等到|当": ("if", 0.0),
        "slow|slowly|slower|carefully|gently|gentle|careful|slow down|慢|慢慢|缓慢|小心|轻轻|慢一点|慢点": (
            "slow",
            0.0,
        ),
        "again|once more|one more time|repeat|same|the same|do it|do that|redo|another|more|further|"
        "再|又|再来|再一次|重复|同样|一样|继续|还": ("again", 0.0),
        "undo|return|come back|go back|walk back|turn back|"
        "move back|back again|back to where|and back|now back|"
        "回来|回去|返回|回到|退回|转回": ("back", 0.0),
        "twice|two times|两次|两遍|两回|二次": ("times", 2.0),
        "thrice|three times|三次|三遍|三回": ("times", 3.0),
        "four times|四次|四遍": ("times", 4.0),
        "five times|五次|五遍": ("times", 5.0),
        "then|and|and then|after that|afterwards|next|before|after|but|while|followed by|finally|also|plus|"
        ",|;|:|(|)|[|]|—|–|，|、|；|：|（|）|然后|接着|并|并且|之后|随后|最后|而后|但|但是|同时": ("break", 0.0),
        ".|!|?|。|！|？|…": ("end", 0.0),
    }
)
MARKS["\n"] = ("end", 0.0)

_LENGTHS = {
    "m|meter|meters|metre|metres|米|公尺": 1.0,
    "cm|centimeter|centimeters|centimetre|centimetres|厘米|公分": 0.01,
    "mm|millimeter|millimeters|millimetre|millimetres|毫米": 0.001,
    "dm|分米": 0.1,
    "km|kilometer|kilometers|kilometre|kilometres|公里|千米": 1000.0,
    "ft|foot|feet|英尺": 0.3048,
    "in|inch|inches|英寸": 0.0254,
    "yd|yard|yards|码": 0.9144,
}
_ANGLES = {
    "deg|degree|degrees|°|度": 1.0,
    "rad|radian|radians|弧度": 57.29577951308232,
    "turn|turns|revolution|revolutions|rotation|rotations|circle|circles|圈|周": 360.0,
}
_SPEEDS = {
    "m/s|mps|meters per second|metres per second|"
    "meter per second|metre per second|meters a second|metres a second|"
    "米每秒|米/秒": 1.0,
    "cm/s|centimeters per second|centimetres per second|厘米每秒|厘米/秒": 0.01,
    "ft/s|feet per second": 0.3048,
    "km/h|kph|kmh|kilometers per hour|kilometres per hour|公里每小时|公里/小时": 1 / 3.6,
    "mph|miles per hour": 0.44704,
}
#: A unit as written: (kind, factor to metres, degrees or metres per second). "times" counts.
UNITS: dict[str, tuple[str, float]] = {
    **{p: ("length", f) for p, f in _table(_LENGTHS).items()},
    **{p: ("angle", f) for p, f in _table(_ANGLES).items()},
    **{p: ("speed", f) for p, f in _table(_SPEEDS).items()},
    **dict.fromkeys(("times", "次", "遍", "回", "下", "张"), ("times", 1.0)),
}
