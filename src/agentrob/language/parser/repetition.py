"""Repeat earlier steps: "again", "the same but slower", "do this twice", "and now back".

Steps are repeated from the same post, otherwise from the last executed plan in the thread; a note lists them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from agentrob.language.messages.catalog import quote, say
from agentrob.language.messages.plan_text import outline
from agentrob.language.parser.drafts import Draft
from agentrob.language.parser.lexicon import TokenKind
from agentrob.model import BUILT_IN, BaseMotion, Capabilities, Direction, Language, Plan, Primitive

#: The most steps of one post.
MAX_STEPS = 100
HALF_TURN_DEG = 180.0
#: What "slowly" means, in metres per second.
SLOW_MPS = 0.2
_SIDES = (Direction.LEFT, Direction.RIGHT)
_OPPOSITE = {
    Direction.FORWARD: Direction.BACKWARD,
    Direction.BACKWARD: Direction.FORWARD,
    Direction.LEFT: Direction.RIGHT,
    Direction.RIGHT: Direction.LEFT,
}


@dataclass(frozen=True, slots=True)
class ParseContext:
    """The context of a post that is parsed.

    `history`: plans executed in the thread, oldest first. `pace_mps`: the robot's speed for a walk that is given in
    seconds without a speed. `step_m`: the length of the robot's step, if configured. `can`: what the robot can do, so
    that examples stay within it.
    """

    history: Sequence[Plan] = ()
    pace_mps: float = 0.3
    step_m: float | None = None
    can: Capabilities | None = None

    def abilities(self, ops: frozenset[str]) -> Capabilities:
        """Return what the robot can do; without `can` the built-in ones of `ops`, since nobody declares the others."""
        return self.can or Capabilities("", frozenset(op for op in ops if op in BUILT_IN))


class AmbiguousRepetition(Exception):
    """Raised with a sentence that says why steps cannot be repeated."""


def repeated_steps(
    draft: Draft, said: str, before: Sequence[Primitive], history: Sequence[Plan], language: Language
) -> tuple[list[Primitive], str]:
    """Return the steps that follow `before` (the steps of the same post), and a note that lists them.

    Raises `AmbiguousRepetition`.
    """
    base = list(before) or (list(history[-1].steps) if history else [])
    if not base:
        raise AmbiguousRepetition(say("ask.again", language, words=quote(said)))
    if draft.only is not None and any(step.base_motion is not draft.only for step in base):
        raise AmbiguousRepetition(say("ask.again_how", language, words=quote(said), steps=outline(base, language)))
    if draft.back:
        steps = reversed_path(base)
        turned = bool(steps) and steps[0].rotates and steps[0].degrees == HALF_TURN_DEG  # forward, or as it came?
        if not steps or turned or draft.counted or draft.amount is not None:
            raise AmbiguousRepetition(say("ask.again_how", language, words=quote(said), steps=outline(base, language)))
        steps = _changed(steps, draft, said, language)
    else:
        once = draft.counted and draft.times == 1 and not draft.more  # "repeat everything once": in all, or once more
        if before and (once or not draft.counted) and len(base) > 1:
            raise AmbiguousRepetition(say("ask.again_which", language, words=quote(said)))
        # "Walk 1 m, do this twice": twice in all. "Again" with nothing before it: as often as it says.
        times = draft.times - 1 if before and draft.counted and not draft.more else draft.times
        if not 0 <= times * len(base) <= MAX_STEPS or draft.times < 1:
            raise AmbiguousRepetition(say("ask.too_many", language, steps=MAX_STEPS))
        steps = _changed(base, draft, said, language) * times
    return steps, say("note.again", language, words=quote(said), steps=outline([*before, *steps], language))


def reversed_path(steps: Sequence[Primitive]) -> list[Primitive]:
    """Return the same path in reverse, without gestures and pictures."""
    moves = [step for step in reversed(steps) if step.walks and step.direction]
    return [replace(step, direction=_OPPOSITE[step.direction]) for step in moves if step.direction]


def _changed(steps: Sequence[Primitive], draft: Draft, said: str, language: Language) -> list[Primitive]:
    """Apply changes ("the same but slower, to the left, two metres") where it is clear which step is meant."""
    unclear = AmbiguousRepetition(say("ask.again_how", language, words=quote(said), steps=outline(steps, language)))
    plain = not (draft.counted or draft.slow or draft.direction or draft.amount or draft.speed_mps)
    walks = [step for step in steps if step.translates]
    if draft.faster or (draft.vague and plain) or ((draft.slow or draft.speed_mps is not None) and not walks):
        raise unclear
    found = list(steps)
    if draft.speed_mps is not None or draft.slow:
        found = [replace(s, speed_mps=_speed(s, draft)) if s.translates else s for s in found]
    if draft.direction is not None and not draft.back:
        axis = _SIDES if draft.direction in _SIDES else tuple(d for d in Direction if d not in _SIDES)
        if len({s.direction for s in found if s.direction in axis}) != 1:
            raise unclear
        found = [replace(s, direction=draft.direction) if s.direction in axis else s for s in found]
    if draft.amount is not None:
        motion = {TokenKind.LENGTH: BaseMotion.TRANSLATION, TokenKind.ANGLE: BaseMotion.ROTATION}.get(draft.amount.kind)
        if (
            motion is None
            or sum(s.base_motion is motion for s in found) != 1
            or not isinstance(draft.amount.value, float)
        ):
            raise unclear
        found = [_with_amount(s, round(draft.amount.value, 4)) if s.base_motion is motion else s for s in found]
    return found


def _with_amount(step: Primitive, amount: float) -> Primitive:
    return replace(step, distance_m=amount) if step.translates else replace(step, degrees=amount)


def _speed(step: Primitive, draft: Draft) -> float:
    if draft.speed_mps is not None:
        return draft.speed_mps
    return round(step.speed_mps / 2, 4) if draft.slower and step.speed_mps else SLOW_MPS
