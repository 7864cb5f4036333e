"""Write a robot's answer to "help" from its capabilities; the grammar understands every example in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from agentrob.language.messages.catalog import say
from agentrob.language.messages.plan_text import example_of, sentence
from agentrob.language.routines import Routine, steps_of, usual_size_m
from agentrob.model import BUILT_IN, ActionClass, BaseMotion, Capabilities, Direction, Language, Primitive, turn, walk

#: The routines that help names.
ROUTINES = (Routine.DANCE, Routine.SQUARE, Routine.CIRCLE, Routine.PATROL)


def help_text(capabilities: Capabilities, name: str, language: Language, *, sees: bool = False) -> str:
    """Return Markdown for the robot called `name` (its handle without @). Examples are code, so they command nobody.
    `sees`: it has a detector for its camera's pictures."""
    limits = capabilities.limits
    lines = [
        say("help.intro", language, name=name, model=capabilities.model),
        "",
        say("help.do", language),
        "",
        *(_example(name, [step], language) for step in examples(capabilities)),
        "",
    ]
    if len(chain := firsts(capabilities)) > 1:
        lines += [say("help.chain", language), "", _example(name, chain, language), ""]
    for key, sentences in (
        ("help.play", play_examples(capabilities, language)),
        ("help.eyes", eye_examples(capabilities, language) if sees else []),
    ):
        if sentences:
            played = [say("help.example", language, name=name, sentence=words) for words in sentences]
            lines += [say(key, language), "", *played, ""]
    if capabilities.does(BaseMotion.TRANSLATION):
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
    steps = [walk(d, min(m, limits.step_m)) for d, m in zip(walks, (1.0, 0.5, 0.3), strict=False)]
    steps += [
        turn(Direction.LEFT, min(90.0, limits.step_deg)),
        turn(Direction.RIGHT, min(45.0, limits.step_deg)),
    ]
    steps = [step for step in steps if step.op in capabilities.ops]
    return steps + [example_of(one) for one in capabilities.operations if one.base_motion is None]


def firsts(capabilities: Capabilities) -> list[Primitive]:
    """Return a walk, a turn, a gesture and a picture, as far as the robot can do them."""
    found: dict[BaseMotion | ActionClass, Primitive] = {}
    for step in examples(capabilities):
        found.setdefault(step.base_motion or step.operation.action_class, step)
    return [found[kind] for kind in (*BaseMotion, ActionClass.GESTURE, ActionClass.PHOTO) if kind in found]


def commands(capabilities: Capabilities, language: Language) -> list[str]:
    """Return sentences that this robot understands: several steps at once, what only it can do or else a gesture, a
    photo, one step of each kind."""
    steps = examples(capabilities)
    gestures = [step for step in steps if step.operation.action_class is ActionClass.GESTURE]
    chain = [step for step in firsts(capabilities) if step.moves]
    chain = chain if any(step.walks for step in chain) else gestures[:2]
    own = [step for step in steps if step.op not in BUILT_IN]
    plans: list[Sequence[Primitive]] = [chain] if len(chain) > 1 else []
    plans += [[step] for step in (own or [step for step in gestures if step not in chain] or gestures)[:1]]
    plans += [[step] for step in steps if step.operation.picture][:1]
    plans += [[step] for step in steps]
    return list(dict.fromkeys(sentence(plan, language) for plan in plans))


def thread_examples(language: Language) -> list[str]:
    """Return what can be said about an earlier walk in the thread."""
    return [say(key, language) for key in ("help.again", "help.slower", "help.back")]


def play_examples(capabilities: Capabilities, language: Language) -> list[str]:
    """Return the routines that fit this robot's limits, and the way home."""
    found = [say(f"help.{r}", language) for r in ROUTINES if steps_of(r, capabilities, usual_size_m(r, capabilities))]
    goes = all(map(capabilities.does, BaseMotion)) and Direction.FORWARD in capabilities.move_directions
    return [*found, say("help.home", language)] if goes else found


def eye_examples(capabilities: Capabilities, language: Language) -> list[str]:
    """Return what can be asked of a robot with a detector."""
    if not any(operation.picture for operation in capabilities.operations):
        return []
    turns = [say("help.face", language)] if capabilities.does(BaseMotion.ROTATION) else []
    return [*turns, say("help.colours", language)]


def within(step: Primitive, capabilities: Capabilities) -> Primitive:
    """Return the step, shortened to the limits of one step."""
    limits = capabilities.limits
    if step.distance_m is not None:
        return replace(step, distance_m=min(step.distance_m, limits.step_m))
    return replace(step, degrees=min(step.degrees, limits.step_deg)) if step.degrees is not None else step


def _example(name: str, steps: list[Primitive], language: Language) -> str:
    return say("help.example", language, name=name, sentence=sentence(steps, language))
