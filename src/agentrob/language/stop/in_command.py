"""Recognise a stop that is part of a command, so that the post does not stop the robot (law 13).

Examples: "walk 1 m and stop", "turn left 90 degrees, pause, then turn back", 前进两米后停下. Either the shape of the
post matches, or the grammar parses it as a command with and without its stop. The patterns match a whole post
in lower case and simplified characters, without mentions.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from agentrob.language.parser.grammar import MAX_CHARS, parse
from agentrob.model import Intent, Op

#: Returns the clauses of a text that stop a moving robot (`stop_while_moving`).
StoppingClauses = Callable[[str], Sequence[str]]

#: Longest post, in characters, that is matched by shape: the patterns are not linear in its length.
_LONGEST_SHAPE = 400


def is_bound_in_command(
    text: str, visible: str, names: Sequence[str], robots: Sequence[str], stopping: StoppingClauses
) -> bool:
    """Return whether the stop in a post for the robot called `names` is only part of a command.

    `text` is the part of the post for this robot, normalised for the patterns; `visible` is the whole post and `robots`
    the handles of other robots in it. Anything else in the post that stops, such as a warning, still stops the robot.
    """
    if _has_shape(text, stopping):
        return True
    return _is_whole_command(visible, names, robots) and not _warns_besides(text, stopping)


def _one_of(lines: str) -> str:
    """Return a group of alternatives, which are separated by `|` or line ends."""
    return "(?:" + "|".join(line.strip() for line in lines.strip().splitlines()) + ")"


@dataclass(frozen=True, slots=True)
class _Shape:
    """A command with a stop at its end or in its middle; `command` has the groups head, joint, stop and tail.

    It counts if the head or the tail names an amount or a place (`goal`), or the tail continues with a motion (`more`).
    """

    command: re.Pattern[str]
    goal: re.Pattern[str]
    more: re.Pattern[str]


# ---------------------------------------------------------------------- English
_NUMBER = _one_of(
    r"""
    \d[\d.,]*|a|an|couple|eight|few|fifteen|fifty|five|forty|four|full|half|nine|ninety|one|quarter|several|seven|six
    ten|thirty|three|twelve|twenty|two
    """
)
_UNIT = _one_of(
    """
    °|centimet(?:re|er)s?|circles?|cm|deg|degrees?|feet|foot|ft|in|inch(?:es)?|km|laps?|m|met(?:re|er)s?|minutes?|mm
    paces?|rounds?|seconds?|secs?|steps?|times?|turns?|yards?
    """
)
_ACT = _one_of(
    """
    advance|back|bow|circle|climb|come|crawl|creep|dance|do|drive|follow|go|head|hop|jog|jump|lift|look|make|march|move
    nod|pace|patrol|perform|play|point|raise|return|roll|rotate|run|shoot|shuffle|sidestep|sit|snap|spin|step|strafe
    stretch|stroll|take|tiptoe|travel|trot|turn|twirl|walk|wander|wave
    """
)
_MANNERS = "(?:(?:and then|can you|could you|first|hey|hi|next|now|ok|okay|please|pls|robot|then),? )*"
_MANNER = "(?:carefully |gently |quickly |slowly )?"
_ARRIVED = "(?:as soon as|once|when) you (?:are|arrive|get|hit|reach|see)"
_JOINT = r"(?:,|\b(?:afterwards|and|then)\b)"
#: A clause before a command that puts it off: "for the next run: trot forward ...".
_LATER = _one_of(
    r"""
    \bafter (?:that|the|this)\b|\bafterwards\b|\blater\b|\bnext\b|\bonce (?:it|this|you)|\bround\b|\bsecond\b
    \btomorrow\b|\bwhen (?:he|it|she|this|you)(?:'s|'re| is| are)? (?:\w+ )?(?:back|done|finished|ready|there)
    """
)
_STOP = (
    "(?:come to (?:a|an) (?:complete |full )?)?"
    "(?:brake|freeze|halt|halting|hold still|pause|pausing|stand still|stay still|stop|stopping|wait)"
)
#: How the sentence may continue after the stop: "... and stop facing the window".
_AFTER_STOP = _one_of(
    f"""
    about|after|and|at|before|behind|beside|by|close to|facing|for|in|inside|just|like|near|next to|on|once|outside
    right (?:at|before|behind|by|in|next)|short|so|then|there|under|until|when|with|{_ACT}|{_NUMBER}
    """
)
#: Words before a place: "up to the door".
_PLACE = (
    r"\b(?:across|along|around|at|before|behind|beside|by|facing|in front of|into|near|next to|onto|over to|past|to"
    r"|towards?|up to) (?:a|an|door|her|his|my|our|room|that|the|this|your|[a-z]+'s)\b"
)
_ENGLISH = _Shape(
    command=re.compile(
        rf"(?:[^!?.;]{{0,60}}?{_LATER}[^!?.;]{{0,40}}?[:,] ?)?"
        rf"(?P<head>{_MANNERS}{_MANNER}(?:{_ACT}|{_ARRIVED})\b[^!?.;]*?)"
        rf"(?P<joint>\s*{_JOINT}(?:\s|{_JOINT})*)"
        rf"(?P<stop>{_STOP})\b[, ]*"
        rf"(?P<tail>(?:{_AFTER_STOP}\b[^!?;]*)?)"
    ),
    goal=re.compile(
        rf"\b{_NUMBER} ?{_UNIT}(?!\w)|\bin place\b|\breach\b|\bto (?:[a-z]+'s|him|me|them|us)\b"
        rf"|\buntil (?:it|the|you)\b|{_PLACE}"
    ),
    more=re.compile(rf"(?:,|\b(?:and|then)\b)(?: then)? {_ACT}\b"),
)
#: "wait 3 seconds and then wave"
_WAIT_THEN_ACT = re.compile(
    r"(?:(?:after|once|when) [^!?;]{3,40}? )?(?:(?:first|ok|okay|please|robot),? )*"
    rf"(?:freeze|hold|pause|stand|stay|stop|wait)\b[^!?;,]{{0,50}}? {_NUMBER} ?"
    r"(?:mins?|minutes?|moments?|s|secs?|seconds?)[, ]+(?:afterwards |and |then )+"
    rf"(?P<tail>{_ACT}\b[^!?;]*)"
)

# ---------------------------------------------------------------------- Chinese
#: The robot as a subject, which may tell what it does now: 小车前行三秒，停下. In doubt it stops.
_TELLS_OF_ROBOT = re.compile(r"\s*(?:底盘|小车|机器小车)")
_NUMBER_ZH = "[0-9零一二两三四五六七八九十百半几]+"
_UNIT_ZH = "(?:下|公分|公尺|分钟|厘米|圈|寸|尺|度|次|步|秒|米)"
_ACT_ZH = _one_of(
    """
    倒退|做|举|伸|前进|到|去|右转|后退|向|看到|看见|站起来|移动|绕|行|表演|趴|跑|跳|蹲|走|转|退|靠近|鞠|鞠躬|坐|小跑|左转
    巡逻|往|抬|拍|挥|摇|朝|爬
    """
)
#: A clause before a command that puts it off: 下一个任务：往前走两米，停三秒.
_LATER_ZH = "(?:下一|下次|之后|做完|完了|待会|接下来|明天|第二|等下|等会|走完)"
_STOP_ZH = "(?:停(?:下来|住|止|下|低|一停)?|定住|定格|暂停|歇|站住|站定|等(?:着|我|待|一下)?|静止)"
_AFTER_STOP_ZH = "(?:一|再|在|坐|拍|挥|接着|朝|然后|等|趴|跟住|蹲|转|面|于|[0-9一二两三四五六七八九十半几])"
_CHINESE = _Shape(
    command=re.compile(
        rf"(?:.{{0,30}}?{_LATER_ZH}[^!！?？。；]{{0,15}}?[，,：: ]?)?"
        rf"(?P<head>(?:你|先|再|小狗|帮我|快速|慢慢|机器人|然后|请|麻烦)*{_ACT_ZH}[^!！?？。；]*?)"
        r"(?P<joint>(?:[，,、\s]|中间|之后|先|再|后|就|并|接着|最后|然后)*)"
        rf"(?P<stop>{_STOP_ZH})(?:不动)?"
        rf"(?P<tail>(?:[，,、\s]*{_AFTER_STOP_ZH}[^!！?？；]*)?)"
    ),
    goal=re.compile(rf"{_NUMBER_ZH}个?半?{_UNIT_ZH}|姿势|(?:到|去|往|向|朝|在)(?!这|此).{{1,20}}"),
    more=re.compile("(?:之后|再|接着|最后|然后|跟住)[^，,。]"),
)
#: The post may name the robot if it consists only of motions with amounts, and a word, not only a comma, joins the
#: stop at the end: 小车前行三秒后停住.
_ROBOT_ZH = "(?:底盘|机器人|机器狗|机械狗|机身|小狗|小车|狗狗|车子)"
_DIRECTION_ZH = "(?:向|往|朝)(?:前|右|后|左)(?:侧|方|边)?"
_MOTION_ZH = _one_of(
    """
    倒退|前行|前进|右旋|右移|右转|后退|小跑|左旋|左移|左转|平移|旋转|移动|行走|行进|行驶|走|跑|转|转动|退
    """
)
_AMOUNT_ZH = (
    f"{_NUMBER_ZH}(?:[.点]{_NUMBER_ZH})?个?(?:公分|公尺|分钟|厘米|周|圈|尺|度|步|秒钟?|米)[一二三四五六七八九半]?"
)
_MEASURED_ZH = f"(?:(?:{_DIRECTION_ZH})?(?:原地)?{_MOTION_ZH}|{_DIRECTION_ZH}){_AMOUNT_ZH}"
_MEASURED_THEN_STOP_ZH = re.compile(
    rf"(?P<head>(?:请|麻烦)?让?{_ROBOT_ZH}?[，,\s]*(?:先|再|快速|慢慢|缓慢)*"
    rf"{_MEASURED_ZH}(?:(?:[，,、\s]|再|并|接着|然后)+{_MEASURED_ZH})*)"
    r"[，,、\s]*(?:之后|以后|再|后|就|并|接着|最后|然后)+停(?:下来|住|止|下)?(?:不动)?"
)


# ---------------------------------------------------------------------- judging
_MENTION = re.compile(r"@\w+")


def _has_shape(text: str, stopping: StoppingClauses) -> bool:
    """Return whether the post has the shape of a command with a goal and a stop at its end or in between.

    The grammar need not understand it: the robot then asks back, which is no reason to stop.
    """
    if len(text) > _LONGEST_SHAPE:
        return False
    plain = " ".join(_MENTION.sub(" ", text).split()).strip(" .。")
    if found := _WAIT_THEN_ACT.fullmatch(plain):
        return not stopping(found["tail"])
    if found := _MEASURED_THEN_STOP_ZH.fullmatch(plain):
        return not stopping(found["head"])
    return any(_fits(shape, plain, stopping) for shape in (_ENGLISH, _CHINESE))


def _fits(shape: _Shape, plain: str, stopping: StoppingClauses) -> bool:
    found = shape.command.fullmatch(plain)
    if not found or stopping(found["head"]) or stopping(found["tail"]):
        return False
    goal = shape.goal.search(found["head"]) or shape.goal.search(found["tail"]) or shape.more.search(found["tail"])
    # A comma alone binds nothing at the end: "back up 2 m, stop" is a stop of its own.
    joined = not found["joint"] or found["joint"].strip(" ,，、") or found["tail"]
    return bool(goal and joined)


_BOUND_STOP = re.compile(r"\b(?:brake|freeze|halt|pause|stop|wait)\b|停|站住|等", re.IGNORECASE)
_JOINT_AT_END = re.compile(
    r"(?:[\s,，、]|\b(?:afterwards|and|then)\b|之后|再|就|并|并且|接着|最后|然后)+$", re.IGNORECASE
)
_SHOUT = re.compile("[!！]")


def _is_whole_command(visible: str, names: Sequence[str], robots: Sequence[str]) -> bool:
    """Return whether the grammar parses the post as a command that ends in its stop, and still does without it.

    A command without any stop word counts as well: "take a photo of what is in front of you" is not a warning.
    """
    if len(visible) > MAX_CHARS:
        return False
    found = list(_BOUND_STOP.finditer(visible))
    head = visible[: found[0].start()] if found else visible
    joint = _JOINT_AT_END.search(head)
    if found and (joint is None or not joint[0].strip() or _SHOUT.search(visible, found[0].end())):
        return False
    return _is_command(visible, names, robots) and _is_command(_JOINT_AT_END.sub("", head), names, robots)


def _is_command(text: str, names: Iterable[str], robots: Iterable[str]) -> bool:
    return bool(_steps(text, names, robots))


def _steps(text: str, names: Iterable[str] = (), robots: Iterable[str] = ()) -> int:
    """Return how many steps a text commands; 0 if it is no command."""
    if _TELLS_OF_ROBOT.match(text):
        return 0
    understood = parse(text, list(names), list(robots), frozenset(Op), remarks=False)
    return len(understood.plan.steps) if understood.intent is Intent.COMMAND else 0


def _warns_besides(text: str, stopping: StoppingClauses) -> bool:
    """Return whether a clause that stops is not a part of the command; the grammar would drop it as a remark."""
    return any(
        not (_BOUND_STOP.search(clause) or _steps(clause) or _adds_step(text, clause)) for clause in stopping(text)
    )


def _adds_step(text: str, clause: str) -> bool:
    """Return whether a clause is a step after the clauses before it: "turn around, take a photo of what's behind
    you"."""
    at = text.find(clause)
    return at > 0 and _steps(text[: at + len(clause)]) > _steps(text[:at]) > 0
