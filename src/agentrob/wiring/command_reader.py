"""Read commands by rules alone, in a process of its own, for the pages of the forum on which they are written.

The same grammar and screen as those of a robot's agent, with what the robot's card says: what it can do, what its owner
consents to, which actions need an approval, and the scene where the owner shows it. A mind that is a language model may
understand more, and refuse more.
"""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, replace
from datetime import UTC, datetime

from pydantic import TypeAdapter

from agentrob.board.command_reading import DraftCommand, DraftReading, ReadableRobot, RobotReading
from agentrob.language.addressing import part_for
from agentrob.language.joint.parts import JointCommand
from agentrob.language.joint.reading import JointProblem, joint_command
from agentrob.language.messages.catalog import can_say, quote, say
from agentrob.language.messages.plan_text import sentence
from agentrob.language.previews.reading import rehearsed_part, speaks_of_preview
from agentrob.language.registry import language_of
from agentrob.language.schedule.reading import TimedText, cancels_elsewhere, lists_schedules, timed_text
from agentrob.language.stop.at_rest import stop_intent
from agentrob.language.visible_text import mentions, visible_text
from agentrob.minds.protocol import Addressee
from agentrob.minds.rules import RulesMind
from agentrob.minds.visual_loop.pursuit import goal_for, in_words, judged_plan, without_model
from agentrob.minds.visual_loop.vocabulary import colours
from agentrob.model import Account, Capabilities, Decision, Intent, Language, Limits, Op, Understanding
from agentrob.process.answering.client import LineProcess
from agentrob.process.answering.server import LineServer, TooSlow
from agentrob.screening.audience import text_for_robot
from agentrob.screening.screen import harm_in_words, prepare, screen

#: Processor seconds for one text; 2,000 characters take about a tenth of it.
LIMIT_S = 0.5
_START = "from agentrob.wiring.command_reader import serve; serve()"
_DRAFT, _READING = TypeAdapter(DraftCommand), TypeAdapter(DraftReading)
#: The zone of a robot is in the configuration of its agent: a time that is still to come in one of these may be.
_ZONES = ("UTC", "Etc/GMT+12", "Etc/GMT-14")
#: The field of `Limits` that each rule of the screen is about.
_LIMIT_OF = {
    "limit.step_distance": "step_m",
    "limit.step_degrees": "step_deg",
    "limit.command_distance": "command_m",
    "limit.command_time": "command_s",
    "limit.command_steps": "command_steps",
    "limit.speed": "speed_mps",
}


class ReaderProcess:
    """A `CommandReader` that asks a child process."""

    def __init__(self) -> None:
        self._process = LineProcess(_START)

    def read(self, draft: DraftCommand) -> DraftReading:
        try:
            answer = self._process.ask(_DRAFT.dump_python(draft, mode="json"))
        except OSError as e:
            raise TooSlow from e
        return _READING.validate_python(answer)

    def close(self) -> None:
        self._process.close()


@dataclass(frozen=True)
class _Sight:
    """The things that a robot's detector knows, from its card, which does not list colours."""

    things: tuple[str, ...]

    @property
    def colours(self) -> frozenset[str]:
        return frozenset(colours("en").values())


# -------------------------------------------------------------------- in the process
def serve() -> None:
    """Read texts from standard input until it ends."""
    server = LineServer(LIMIT_S)
    prepare()
    warm = ReadableRobot(
        "robot", Capabilities("", frozenset(Op)), scene="A room with a table 2 m in front of the robot."
    )
    read(DraftCommand("@robot walk forward 1 m, then turn left. 向前走一米", Account("0", "nobody"), (warm,)))
    read(DraftCommand("@robot wave, then @another wave", Account("0", "nobody"), (warm,)))
    while _one(server):
        pass


def _one(server: LineServer) -> bool:
    try:
        if (asked := server.question()) is None:
            return False
        server.answer(_READING.dump_python(read(_DRAFT.validate_python(asked)), mode="json"))
    except (TooSlow, MemoryError, RecursionError):
        server.give_up()
    return True


def read(draft: DraftCommand) -> DraftReading:
    """How each robot that the text mentions reads it."""
    visible = visible_text(draft.text)
    names = tuple(mentions(visible))
    called = [robot for robot in draft.robots if robot.name in names]
    return DraftReading(names, tuple(_reading(visible, draft.author, robot, names) for robot in called))


def _reading(visible: str, author: Account, robot: ReadableRobot, names: tuple[str, ...]) -> RobotReading:
    others = tuple(name for name in names if name != robot.name)
    if stop_intent(visible) is not None:
        return RobotReading(robot.name, say("read.stop", language_of(visible)), "stop")
    if (joint := joint_command(visible)) is not None:
        return _part_of(visible, author, robot, joint)
    part = part_for(visible, (robot.name,), others)
    if (rehearsed := rehearsed_part(part, visible)) is not None:
        return _preview(robot, author, rehearsed, language_of(part))
    timed = _timed(part)
    if timed is not None and timed.schedule is not None and visible.count(part) == 1:
        untimed = _read_now(visible.replace(part, timed.rest), author, replace(robot, history=()), others)
        if untimed.outcome in ("would", "needs_approval"):
            line = say("read.later", language_of(part), line=untimed.line)
            return replace(untimed, line=line)
        if untimed.outcome in ("refuse", "ask_back"):
            return untimed
    if lists_schedules(part) or cancels_elsewhere(part):
        return RobotReading(robot.name, say("read.answer", language_of(part)), "answer")
    if timed is not None and timed.surely_later:
        return RobotReading(robot.name, timed.question, "ask_back")
    found = _read_now(visible, author, robot, others)
    if found.outcome in ("would", "needs_approval") and speaks_of_preview(part, visible):
        return RobotReading(robot.name, say("preview.unclear", language_of(part)), "ask_back")
    if timed is not None and found.outcome == "ask_back" and not found.rule:
        return replace(found, line=timed.question or found.line)
    return found


def _part_of(visible: str, author: Account, robot: ReadableRobot, joint: JointCommand | JointProblem) -> RobotReading:
    """How a robot reads its part of a post in which robots wait for each other. The first of two parts is judged."""
    parts = joint.of(robot.name) if isinstance(joint, JointCommand) else ()
    if isinstance(joint, JointProblem) or not parts:
        question = joint.question if isinstance(joint, JointProblem) else ""
        if (harm := harm_in_words(visible, robot.scene, joint.language)) is not None:
            return RobotReading(robot.name, harm.reason, "refuse", harm.rule)
        return RobotReading(robot.name, question or say("joint.alias", joint.language, name=robot.name), "ask_back")
    first = parts[0]
    words = ". ".join(part.text for part in joint.parts)
    understood = Understanding(Intent.COMMAND, joint.language, first.plan)
    reading = _judged(visible, author, robot, (), understood, words)
    if reading.outcome not in ("would", "needs_approval") or not first.after:
        return reading
    who = ", ".join(dict.fromkeys(quote(name) for n in first.after for name in joint.part(n).robots))
    return replace(reading, line=say("read.part", joint.language, line=reading.line, who=who))


def _preview(robot: ReadableRobot, author: Account, rest: str, language: Language) -> RobotReading:
    """How a robot reads a request for a preview of `rest`."""
    found = _read_now(f"@{robot.name} {rest}", author, robot, ())
    if not rest or found.outcome == "nothing":
        return RobotReading(robot.name, say("preview.what", language), "ask_back")
    if found.outcome in ("would", "needs_approval"):
        return RobotReading(robot.name, say("read.preview", language, line=found.line), "answer")
    return found


def _timed(part: str) -> TimedText | None:
    read = [timed_text(part, datetime.now(UTC), tz) for tz in _ZONES]
    return next((timed for timed in read if timed is not None and timed.schedule is not None), read[0])


def _read_now(visible: str, author: Account, robot: ReadableRobot, others: tuple[str, ...]) -> RobotReading:
    """How a robot reads a command that is carried out at once."""
    understood = asyncio.run(
        RulesMind().understand(visible, Addressee((robot.name,), others, robot.can), robot.history)
    )
    language = understood.language
    if (pursued := _goal(visible, author, robot, others, understood)) is not None:
        return pursued
    match understood.intent:
        case Intent.COMMAND:
            return _judged(visible, author, robot, others, understood)
        case Intent.ASK_BACK:
            if (harm := harm_in_words(visible, robot.scene, language)) is not None:
                return RobotReading(robot.name, harm.reason, "refuse", harm.rule)
            return RobotReading(robot.name, _question(understood), "ask_back")
        case Intent.STOP | Intent.HALT:
            return RobotReading(robot.name, say("read.stop", language), "stop")
        case Intent.NOTHING:
            return RobotReading(robot.name, say("read.no_command", language), "nothing")
    return RobotReading(robot.name, say("read.answer", language), "answer")


def _goal(
    visible: str, author: Account, robot: ReadableRobot, others: tuple[str, ...], understood: Understanding
) -> RobotReading | None:
    """How a goal is read that the robot pursues without a model, such as the way home; None if it is not one."""
    goal = goal_for(visible, Addressee((robot.name,), others, robot.can), understood)
    if goal is None or not without_model(goal, robot.can, _Sight(robot.sees) if robot.sees else None):
        return None
    plan = judged_plan(goal, local=True)
    reading = _judged(visible, author, robot, others, replace(understood, plan=plan))
    words = in_words(goal, understood.language)
    if reading.outcome in ("would", "needs_approval"):
        key = "read.would" if reading.outcome == "would" else "read.approval"
        return replace(reading, line=say(key, understood.language, steps=words), steps=())
    return reading


def _judged(
    visible: str,
    author: Account,
    robot: ReadableRobot,
    others: tuple[str, ...],
    understood: Understanding,
    part: str | None = None,
) -> RobotReading:
    """Screen a plan. `part` is the text by which it is judged, by default that for this robot."""
    plan, language = understood.plan, understood.language
    verdict = screen(
        plan,
        text=visible,
        author=author,
        capabilities=robot.can,
        language=language,
        consents=robot.consents,
        scene=robot.scene,
        part=text_for_robot(visible, (robot.name,), others) if part is None else part,
        rights=robot.rights,
    )
    steps, data = sentence(plan, language), tuple(plan.as_data())
    match verdict.decision:
        case Decision.ALLOW:
            return RobotReading(robot.name, say("read.would", language, steps=steps), "would", steps=data)
        case Decision.NEEDS_APPROVAL:
            line = say("read.approval", language, steps=steps)
            return RobotReading(robot.name, line, "needs_approval", verdict.rule, data)
        case Decision.ASK_BACK:
            return RobotReading(robot.name, verdict.reason, "ask_back", verdict.rule, data)
    line = _over(verdict.rule, robot.can.limits, language) or verdict.reason
    return RobotReading(robot.name, line, "refuse", verdict.rule, data)


def _over(rule: str, limits: Limits, language: Language) -> str:
    """A short sentence for a command beyond a limit; empty for another rule."""
    if rule not in _LIMIT_OF or not can_say(f"read.{rule}"):
        return ""
    return say(f"read.{rule}", language, limit=f"{getattr(limits, _LIMIT_OF[rule]):g}")


def _question(understood: Understanding) -> str:
    """The question that the robot would ask, without the sentences of a reply ("I did not move")."""
    framed = say("ask.frame", understood.language, problem="\0", understood="\0", examples="\0")
    between = framed.split("\0")[1]
    return understood.question.replace(between, " " if between.startswith(" ") else "")
