"""From what was said to what is done: drafts in, steps out, or the reason why it is not enough to move.

Fails closed: one motion clause that is not wholly understood, and nothing moves at all. A distance is never guessed;
the one assumption made, a bare "turn left" as 90°, is told in a note.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from agentrob.language.clauses import Draft, Sentence
from agentrob.language.lexicon import Kind
from agentrob.language.phrases import quote, say
from agentrob.model import Direction, Language, Op, Primitive

#: Bounds of the language, whatever a robot can do: beyond them something was misunderstood.
MAX_DISTANCE_M = 100.0
MAX_DEGREES = 3600.0
MAX_STEPS = 100
SLOW_MPS = 0.2
SLOW_FROM_MPS, FAST_TO_MPS = 0.01, 10.0


@dataclass
class Reading:
    """Steps that are understood, in order; `problem` is the first reason not to do them, as a sentence."""

    steps: list[Primitive]
    notes: list[str]
    problem: str = ""
    picture_after_each: bool = False


def read(sentences: Sequence[Sentence], text: str, language: Language) -> Reading:
    """Turn the drafts of a whole post into steps."""
    reading = Reading([], [])
    wants = any(sentence.drafts for sentence in sentences)
    for sentence in sentences:
        if sentence.report or (sentence.asked and not sentence.requested and _is_question(sentence)):
            continue
        reading.problem = reading.problem or _doubt(sentence, wants, text, language)
        for draft in _settle(sentence.drafts):
            _add(reading, draft, text, language)
    if len(reading.steps) > MAX_STEPS:
        reading.problem = reading.problem or say("ask.too_many", language, steps=MAX_STEPS)
    if reading.picture_after_each:
        reading.steps = _after_each(reading.steps)
    return reading


def _is_question(sentence: Sentence) -> bool:
    return sentence.talked or sentence.condition is not None or not any(d.verb for d in sentence.drafts)


def _doubt(sentence: Sentence, wants: bool, text: str, language: Language) -> str:
    """What makes a sentence doubtful: conditions, denials without an end, questions. Empty when nothing does.

    A condition or denial that stands alone ("Don't … walk 1 m") may mean its neighbours when the post `wants` anything.
    """
    if wants and sentence.condition is not None:
        return say("ask.condition", language, words=quote(text[sentence.condition.start : sentence.condition.end]))
    if sentence.denial_unclear is not None and (wants or sentence.denial_joined):
        denial = sentence.denial_unclear
        return say("ask.denial", language, words=quote(text[denial.start : denial.end]))
    if sentence.drafts and sentence.asked and not sentence.requested:
        return say("ask.question", language)
    return ""


# ------------------------------------------------------------------ drafts that belong together
def _settle(drafts: Sequence[Draft]) -> list[Draft]:
    """Join afterthoughts to what they complete, and drop false starts."""
    joined: list[Draft] = []
    for draft in drafts:
        if draft.verb is None and not draft.unknown and _completes(joined, draft):
            continue
        while joined and draft.joined and _is_false_start(joined[-1], draft):
            joined.pop()
        joined.append(draft)
    return joined


def _completes(drafts: Sequence[Draft], extra: Draft) -> bool:
    """ "Turn right and take a photo, ninety degrees": an amount or side said late completes the last motion."""
    last = next((d for d in reversed(drafts) if d.is_motion), None)
    if last is None or last.verb is None or last.unknown or not extra.is_motion:
        return False
    if extra.direction is not None and last.direction not in (None, extra.direction):
        return False
    if extra.amount is not None and (last.amount is not None or not _belongs(last, extra)):
        return False
    if extra.amount is None and last.direction is not None:
        return False
    last.amount = last.amount or extra.amount
    last.direction = last.direction or extra.direction
    last.end = max(last.end, extra.end)
    return True


def _belongs(last: Draft, extra: Draft) -> bool:
    is_angle = extra.amount is not None and extra.amount.kind in (Kind.ANGLE, Kind.NUMBER)
    return is_angle if last.verb is Kind.TURN else not is_angle or last.direction not in _AHEAD


def _is_false_start(start: Draft, again: Draft) -> bool:
    """ "Move forward, uh, move three feet": the same begun twice without a pause, the first without an amount."""
    if not start.is_motion or start.amount is not None or start.unknown or start.verb is None or not again.is_motion:
        return False
    if start.direction is None:
        return start.verb is again.verb or again.verb is None
    same = start.direction is again.direction or (again.direction is None and start.verb is again.verb)
    if same and again.direction is None:
        again.direction = start.direction
    return same and (again.amount is not None)


# ------------------------------------------------------------------ one draft
def _add(reading: Reading, draft: Draft, text: str, language: Language) -> None:
    said = text[draft.start : draft.end]
    if draft.stop_word and reading.steps and not (draft.unknown or draft.amount or draft.direction):
        return  # "walk 2 m and stop": it stops by itself
    if draft.unknown or draft.stop_word:
        # Within a motion the whole clause is in doubt, otherwise only the words that are not known.
        known_part = draft.is_motion or draft.stop_word or not draft.unknown
        words = said if known_part else text[draft.unknown[0][0] : draft.unknown[-1][1]]
        # "Go to the kitchen", "face the door": a place instead of an amount.
        place = draft.verb in (Kind.MOVE, Kind.TURN) and draft.amount is None and bool(draft.unknown)
        key = "ask.place" if place else "ask.words"
        reading.problem = reading.problem or say(key, language, words=quote(words))
        return
    step, problem = (_motion(draft, said, language, reading.notes)) if draft.op is None else (Primitive(draft.op), "")
    if draft.bare_picture:
        step, problem = Primitive(Op.GET_FRONT_IMAGE), ""
    if step is None:
        reading.problem = reading.problem or problem
        return
    if not 1 <= draft.times <= MAX_STEPS:
        reading.problem = reading.problem or say("ask.too_many", language, steps=MAX_STEPS)
        return
    if step.op is Op.GET_FRONT_IMAGE and not draft.counted and not draft.each and reading.steps[-1:] == [step]:
        return  # "take a picture, take a picture": said twice, meant once
    reading.picture_after_each |= draft.each
    reading.steps += [step] * draft.times


def _after_each(steps: Sequence[Primitive]) -> list[Primitive]:
    picture = Primitive(Op.GET_FRONT_IMAGE)
    return [x for step in steps if step != picture for x in (step, picture)]


_AHEAD = (Direction.FORWARD, Direction.BACKWARD)
_SIDES = (Direction.LEFT, Direction.RIGHT)


def _motion(draft: Draft, said: str, language: Language, notes: list[str]) -> tuple[Primitive | None, str]:
    kind = draft.amount.kind if draft.amount else None
    value = float(draft.amount.value) if draft.amount and isinstance(draft.amount.value, float) else 0.0
    if draft.verb is None and (draft.amount is None or draft.direction is None) and kind is not Kind.ANGLE:
        return None, say("ask.what", language, words=quote(said))
    if draft.verb is Kind.TURN and draft.direction in _AHEAD:
        return None, say("ask.words", language, words=quote(said))
    turns = draft.verb is Kind.TURN or kind is Kind.ANGLE
    if kind is Kind.NUMBER and not (turns and value >= 5):
        return None, say("ask.unit", language, words=quote(said))
    if kind is Kind.DURATION:
        return None, say("ask.duration", language, words=quote(said))
    if kind is Kind.STEPS:
        return None, say("ask.steps", language, words=quote(said))
    return _turn(draft, value, said, language, notes) if turns else _move(draft, value, said, language)


def _note(notes: list[str], note: str) -> None:
    if note not in notes:
        notes.append(note)


def _turn(
    draft: Draft, degrees: float, said: str, language: Language, notes: list[str]
) -> tuple[Primitive | None, str]:
    direction = draft.direction
    if draft.amount is None:
        if draft.vague or direction is None:
            return None, say("ask.angle" if direction else "ask.turn", language, words=quote(said))
        degrees = 90.0
        _note(notes, say("note.turn_90", language, words=quote(said)))
    if draft.slow or draft.speed_mps is not None:
        _note(notes, say("note.turn_speed", language))
    if direction in _AHEAD:
        return None, say("ask.words", language, words=quote(said))
    if direction is None and degrees not in (180.0, 360.0):
        return None, say("ask.side", language, words=quote(said))
    if not 0 < degrees <= MAX_DEGREES:
        return None, say("ask.degrees_bound", language, degrees=f"{MAX_DEGREES:g}")
    return Primitive(Op.TURN, direction or Direction.LEFT, degrees=round(degrees, 4)), ""


def _move(draft: Draft, distance_m: float, said: str, language: Language) -> tuple[Primitive | None, str]:
    if draft.amount is None:
        return None, say("ask.distance", language, words=quote(said))
    if not 0 < distance_m <= MAX_DISTANCE_M:
        return None, say("ask.distance_bound", language, metres=f"{MAX_DISTANCE_M:g}")
    speed = draft.speed_mps if draft.speed_mps is not None else (SLOW_MPS if draft.slow else None)
    if speed is not None and not SLOW_FROM_MPS <= speed <= FAST_TO_MPS:
        return None, say("ask.speed", language, words=quote(said))
    step = Primitive(Op.MOVE, draft.direction or Direction.FORWARD, distance_m=round(distance_m, 4))
    return replace(step, speed_mps=speed), ""
