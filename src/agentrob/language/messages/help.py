"""Write a robot's answer to "help" from its capabilities; the grammar understands every example in it."""

from __future__ import annotations

from dataclasses import replace

from agentrob.language.messages.catalog import say
from agentrob.language.messages.plan_text import sentence
from agentrob.model import Capabilities, Direction, Language, Op, Primitive


def help_text(capabilities: Capabilities, name: str, language: Language) -> str:
    """Return Markdown for the robot called `name` (its handle without @). Examples are code, so they command nobody."""
    limits = capabilities.limits
    lines = [
        say("help.intro", language, name=name, model=capabilities.model),
        "",
        say("help.do", language),
        "",
        *(_example(name, [step], language) for step in examples(capabilities)),
        "",
    ]
    if len(chain := _chain(capabilities)) > 1:
        lines += [say("help.chain", language), "", _example(name, chain, language), ""]
    if Op.MOVE in capabilities.ops:
        more = [say("help.example", language, name=name, sentence=words) for words in thread_examples(language)]
        lines += [say("help.more", language), "", *more, ""]
    lines += [
        say("help.stop", language, name=name),
        "",
        say(
            "help.limits",
            language,
            step=f"{limits.step_m:g}",
            command=f"{limits.command_m:g}",
            seconds=f"{limits.command_s:g}",
            steps=limits.command_steps,
            speed=f"{limits.speed_mps:g}",
        ),
    ]
    return "\n".join(lines)


def examples(capabilities: Capabilities) -> list[Primitive]:
    """Return one step of each kind that this robot can do within its limits."""
    limits = capabilities.limits
    walks = [d for d in (Direction.FORWARD, Direction.BACKWARD, Direction.LEFT) if d in capabilities.move_directions]
    steps = [
        Primitive(Op.MOVE, d, distance_m=min(m, limits.step_m)) for d, m in zip(walks, (1.0, 0.5, 0.3), strict=False)
    ]
    steps += [
        Primitive(Op.TURN, Direction.LEFT, degrees=min(90.0, limits.step_deg)),
        Primitive(Op.TURN, Direction.RIGHT, degrees=min(45.0, limits.step_deg)),
    ]
    steps += [Primitive(op) for op in Op if op not in (Op.MOVE, Op.TURN)]
    return [step for step in steps if step.op in capabilities.ops]


def thread_examples(language: Language) -> list[str]:
    """Return what can be said about an earlier walk in the thread."""
    return [say(key, language) for key in ("help.again", "help.slower", "help.back")]


def within(step: Primitive, capabilities: Capabilities) -> Primitive:
    """Return the step, shortened to the limits of one step."""
    limits = capabilities.limits
    if step.distance_m is not None:
        return replace(step, distance_m=min(step.distance_m, limits.step_m))
    return replace(step, degrees=min(step.degrees, limits.step_deg)) if step.degrees is not None else step


def _chain(capabilities: Capabilities) -> list[Primitive]:
    """Return a walk, a turn and a picture, as far as the robot can do them."""
    firsts = {step.op: step for step in reversed(examples(capabilities))}
    return [firsts[op] for op in (Op.MOVE, Op.TURN, Op.HELLO, Op.GET_FRONT_IMAGE) if op in firsts]


def _example(name: str, steps: list[Primitive], language: Language) -> str:
    return say("help.example", language, name=name, sentence=sentence(steps, language))
