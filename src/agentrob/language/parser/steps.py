"""Turn drafts into steps, or into the reason why they are not enough to move.

Fails closed: if one motion clause is not fully understood, nothing moves. Distances are never guessed; the only
assumption, 90° for a bare "turn left", is stated in a note.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

from agentrob.language.messages.catalog import quote, say
from agentrob.language.messages.plan_text import example_of, operation_names, outline, range_of, step_sentence
from agentrob.language.messages.routine_text import routine_note, unfit
from agentrob.language.parser.drafts import Action, Draft, Remark, RemarkKind, Sentence
from agentrob.language.parser.lexicon import Token, TokenKind
from agentrob.language.parser.remarks import Clause
from agentrob.language.parser.repairs import corrected, settled
from agentrob.language.parser.repetition import MAX_STEPS, SLOW_MPS, AmbiguousRepetition, ParseContext, repeated_steps
from agentrob.language.registry import locale
from agentrob.language.remarks.classifier import joins_order
from agentrob.language.routines import Routine, steps_of, usual_size_m
from agentrob.model import PHOTO, BaseMotion, Direction, Language, Primitive, turn, walk

#: Limits of the grammar for any robot: larger amounts mean a misunderstanding.
MAX_DISTANCE_M = 100.0
MAX_DEGREES = 3600.0
SLOW_FROM_MPS, FAST_TO_MPS = 0.01, 10.0
#: What "a picture after each move" and "after each turn" mean.
_MOTION_OF = {TokenKind.MOVE: BaseMotion.TRANSLATION, TokenKind.TURN: BaseMotion.ROTATION}


@dataclass
class ParsedSteps:
    """The steps that were understood, in order; `problem` is the first reason not to execute them, as a sentence."""

    steps: list[Primitive]
    notes: list[str]
    problem: str = ""
    picture_after: TokenKind | None = None
    hints: list[list[Primitive]] = field(default_factory=list)  # candidates for the first step that was not understood
    hinted_at: int = 0  # how many steps stand before that one
    unfit: bool = False  # a routine is known and does not fit the robot's limits
    doubts: int = 0  # how many things were not understood
    offers: list[list[Primitive]] = field(
        default_factory=list
    )  # whole plans that may have been meant, likely ones first

    def object_to(self, problem: str) -> None:
        self.doubts += bool(problem)
        self.problem = self.problem or problem

    def hint(self, steps: list[list[Primitive]]) -> None:
        """Note what the step that was not understood may have been."""
        if steps and not self.hints:
            self.hints, self.hinted_at = steps, len(self.steps)

    def note(self, note: str) -> None:
        if note not in self.notes:
            self.notes.append(note)


def read_steps(
    sentences: Sequence[Sentence], text: str, language: Language, ops: frozenset[str], background: ParseContext
) -> ParsedSteps:
    """Turn the drafts of a whole post into steps; `ops` are the robot's operations."""
    return _StepBuilder(text, language, ops, background).build(sentences)


def _is_question(sentence: Sentence) -> bool:
    return sentence.talked or sentence.condition is not None or not any(d.verb for d in sentence.drafts)


def _is_aside(sentence: Sentence) -> bool:
    """Return whether a whole sentence is not a command: a report of the past, or a question."""
    return sentence.report or (sentence.asked and not sentence.requested and _is_question(sentence))


def _carry_over(sentences: Sequence[Sentence]) -> None:
    """Apply a correction that is a sentence of its own to the next one: "Turn right. No! Left!"."""
    for before, sentence, after in zip(sentences, sentences[1:], sentences[2:], strict=False):
        if sentence.fix_unclear and not sentence.drafts and before.drafts and after.drafts and not after.talked:
            after.drafts[0].fixes = after.drafts[0].fixes or sentence.fix_unclear
            sentence.fix_unclear = None


def _doubt(sentence: Sentence, wants: bool, text: str, language: Language) -> str:
    """Return what makes a sentence doubtful: conditions, unclear denials, questions; empty if nothing does.

    A condition or denial that stands alone ("Don't … walk 1 m") may apply to its neighbours if the post `wants`
    anything. The same holds for a person near the robot, who is ignored only if nothing else is requested.
    """
    if (near := sentence.somebody) is not None and (wants or sentence.requested or sentence.somebody_does):
        return say("ask.words", language, words=quote(text[near.start : near.end]))
    if wants and sentence.condition is not None:
        key = "ask.wait" if sentence.condition.value == "later" else "ask.condition"
        return say(key, language, words=quote(text[sentence.condition.start : sentence.condition.end]))
    if sentence.denial_unclear is not None and (wants or sentence.denial_joined):
        denial = sentence.denial_unclear
        return say("ask.denial", language, words=quote(text[denial.start : denial.end]))
    if sentence.times_unclear is not None:
        times = sentence.times_unclear
        return say("ask.again_which", language, words=quote(text[times.start : times.end]))
    if sentence.fix_unclear is not None and wants:
        return say("ask.fix", language, words=quote(text[sentence.fix_unclear.start : sentence.fix_unclear.end]))
    if sentence.drafts and sentence.asked and not sentence.requested:
        return say("ask.question", language)
    return ""


_AHEAD = (Direction.FORWARD, Direction.BACKWARD)
_SIDES = (Direction.LEFT, Direction.RIGHT)
#: Numbers that are degrees when only a side is said with them: nobody steps 90 of anything aside.
_USUAL_ANGLES = (30.0, 45.0, 60.0, 90.0, 120.0, 135.0, 180.0, 270.0, 360.0)
#: Numbers that are degrees when nothing else is said with them.
_WHOLE_TURNS = (180.0, 360.0)
_PAUSE = re.compile(r"[,.;:!?\n，。；：！？]")
_WHOLE_TURN_DEG = 360.0
_PICTURE = Primitive(PHOTO)


class _StepBuilder:
    """Build steps from drafts, one after the other."""

    def __init__(self, text: str, language: Language, ops: frozenset[str], background: ParseContext) -> None:
        self.text = text
        self.language = language
        self.ops = ops
        self.background = background
        self.can = background.abilities(ops)
        self.reading = ParsedSteps([], [])
        self.waits = False
        self.besides = ""
        self.alone = True  # one draft is the whole post
        self.unclear = False  # whether it is unclear what a correction corrects
        self.gives_units = False  # some step without a verb has a length with its unit
        self.ahead: Draft | None = None  # what is repeated is said after it
        self.clause = ""  # the words around the draft that is read, up to the next pause or draft

    def build(self, sentences: Sequence[Sentence]) -> ParsedSteps:
        reading = self.reading
        wants = any(sentence.drafts for sentence in sentences)
        first = min((d.start for s in sentences if not _is_aside(s) for d in s.drafts), default=None)
        drafts: list[Draft] = []
        _carry_over(sentences)
        for sentence in sentences:
            if first is not None or any(r.kind is RemarkKind.WISH and r.actions for r in sentence.remarks):
                self._account(sentence, first or 0)
            if _is_aside(sentence):
                continue
            reading.object_to(_doubt(sentence, wants, self.text, self.language))
            if self.ahead:  # "Three times: … . And wave.": nobody can tell how far that reaches
                reading.object_to(self._say("ask.again_which", self.text[self.ahead.start : self.ahead.end]))
            self.ahead = next((d for d in sentence.drafts if d.ahead), self.ahead) if sentence.drafts else self.ahead
            if drafts and sentence.cancelled:  # "Turn left. Never mind."
                reading.object_to(self._say("ask.fix", self.text[sentence.cancelled.start : sentence.cancelled.end]))
            drafts += settled(sentence.drafts)
        drafts = self._corrected(sentences, drafts)
        self._object_to_contradictions(sentences, drafts)
        self.alone = len(drafts) == 1
        self.gives_units = any(d.verb is None and d.direction and _is_length(d.amount) for d in drafts)
        for at, draft in enumerate(drafts, 1):
            if draft.waits and at < len(drafts):  # "walk 1 m, wait, turn left"
                self.waits = True
                reading.object_to(self._say("ask.wait", self.text[draft.start : draft.end]))
            before, after = (
                drafts[at - 2].end if at > 1 else 0,
                drafts[at].start if at < len(drafts) else len(self.text),
            )
            self.clause = self._clause_of(draft, before, after)
            self._add(draft)
        if len(drafts) > 1 and (during := re.search(locale(self.language).meanwhile, self.text, re.IGNORECASE)):
            reading.object_to(self._say("ask.meanwhile", during[0].strip(" ,.;!，、")))
        reading.problem = " ".join(part for part in (reading.problem, self.besides) if part)
        if reading.picture_after is not None:
            reading.steps = _after_each(reading.steps, reading.picture_after)
        self._repeat_ahead()
        sent = next((s.sent for s in sentences if s.sent is not None), None)
        if sent is not None and reading.steps and _PICTURE not in reading.steps:  # "walk 1 m and post it"
            reading.object_to(self._say("ask.words", self.text[sent.start : sent.end]))
        if len(reading.steps) > MAX_STEPS:
            reading.object_to(say("ask.too_many", self.language, steps=MAX_STEPS))
            del reading.steps[MAX_STEPS:]
        if reading.problem and not (self.unclear or any(s.fix_unclear or s.cancelled for s in sentences)):
            reading.offers = self._offers(sentences)
        return reading

    def _offers(self, sentences: Sequence[Sentence]) -> list[list[Primitive]]:
        """Return whole plans made from this post that may have been meant.

        A step that was not understood is replaced by what it may have been, if nothing else is in doubt; otherwise the
        rest is offered. An order that is in doubt is offered both ways.
        """
        reading = self.reading
        if reading.hints and reading.doubts == 1 and not self.waits:
            before, after = reading.steps[: reading.hinted_at], reading.steps[reading.hinted_at :]
            return [[*before, *hint, *after] for hint in reading.hints]
        if not reading.steps:
            return reading.hints if reading.doubts == 1 else []
        counts = next((s.times_unclear for s in sentences if s.times_unclear is not None), None)
        times = int(counts.value) if counts is not None and isinstance(counts.value, float) else 0
        last = reading.steps[-times:] if times else []
        if 1 < times == len(last) and last.count(last[0]) == times:  # "sit and stand twice": the one, or both
            return [reading.steps, [*reading.steps[:-times], last[0]] * times]
        if any(s.condition is not None for s in sentences) and len(reading.steps) > 1:
            return [reading.steps, reading.steps[::-1]] if len(reading.steps) == 2 else []
        return [reading.steps]

    def _hint(self, draft: Draft) -> None:
        """Note what a draft may have been, if it says enough: not a number beside other things ("at 9"), nor words."""
        goes = draft.verb in (TokenKind.MOVE, TokenKind.TURN)
        says = goes or draft.direction is not None or self.alone
        if draft.unknown:
            says = goes and draft.direction is not None and draft.amount is None
        if says:
            self.reading.hint(_hints(draft))

    def _corrected(self, sentences: Sequence[Sentence], drafts: Sequence[Draft]) -> list[Draft]:
        """Apply corrections; object to unclear ones, and to a walk in a post that denies walking."""
        self._note_cancelled(drafts)
        settled_drafts, unclear = corrected(drafts)
        self.unclear = unclear is not None
        stays = next((s.stays for s in sentences if s.stays), None)
        if stays and any(d.is_motion and d.verb is not TokenKind.TURN for d in settled_drafts):
            self.reading.object_to(self._say("ask.denial", self.text[stays.start : stays.end]))
        if unclear is not None:
            self.reading.object_to(self._say("ask.fix", self.text[unclear.start : unclear.end]))
        return settled_drafts

    def _object_to_contradictions(self, sentences: Sequence[Sentence], drafts: Sequence[Draft]) -> None:
        """Object to what is also denied, and to a gesture named after "again": "backflip. again! backflip!"."""
        denied: set[Action | None] = {op for sentence in sentences for op in sentence.denied_ops}
        for draft in drafts:
            if draft.op in denied or (draft.bare_picture and PHOTO in denied):
                self.reading.object_to(self._say("ask.denial", self.text[draft.start : draft.end]))
        for motion in (motion for sentence in sentences for motion in sentence.denied_motions):
            if any(_is_denied(draft, motion) for draft in drafts):
                self.reading.object_to(self._say("ask.denial", self.text[motion.start : motion.end]))
        for before, draft in pairwise(drafts):
            if _turns_again(before, draft) or _repeats_gesture(before, draft, drafts):
                self.reading.object_to(self._say("ask.again_which", self.text[before.start : draft.end]))

    def _may_limit(self, denial: Remark) -> bool:
        """Return whether a denial in unknown words may limit what is commanded beside it."""
        words = self.text[denial.start : denial.end].lower()
        return denial.unknown and locale(self.language).limits_command(words)

    def _may_warn(self, denial: Remark) -> bool:
        """Return whether a denial denies no action, but says why not to do what is commanded."""
        words = self.text[denial.start : denial.end].lower()
        return denial.unknown and re.search(locale(self.language).warns, words) is not None

    def _clause_of(self, draft: Draft, before: int, after: int) -> str:
        """Return the words of a draft with those around it, but not beyond a pause, nor `before` and `after`."""
        begun = max((pause.end() for pause in _PAUSE.finditer(self.text, before, draft.start)), default=before)
        pause = _PAUSE.search(self.text, draft.end, max(draft.end, after))
        return self.text[begun : pause.start() if pause else max(draft.end, after)].strip()

    def _note_cancelled(self, drafts: Sequence[Draft]) -> None:
        """Note what is left out because "never mind" stands after it."""
        fixes = [draft.fixes for draft in drafts if draft.fixes and draft.fixes.kind is TokenKind.CANCEL]
        if fixes and drafts[0].start < fixes[-1].start:
            self.reading.note(self._say("note.left_out", self.text[drafts[0].start : fixes[-1].end]))

    def _account(self, sentence: Sentence, first: int) -> None:
        """Account for what accompanies the steps of a post, of which the first is at `first`.

        A mere remark is noted as left out; if it may ask something of the robot, the robot asks back.
        """
        if _is_aside(sentence):
            begun = min((d.start for d in sentence.drafts if d.is_action), default=None)
            since = self.text[sentence.reported_at or 0 : begun] if begun is not None else ""
            later = begun is not None and (begun < (sentence.reported_at or 0) or _PAUSE.search(since))
            # "yesterday it rained, wave" is not reported
            reported = sentence.report and not later and sentence.condition is None
            kind = RemarkKind.REMARK if reported else RemarkKind.WISH if sentence.drafts else RemarkKind.QUESTION
            beside = [Remark(kind, sentence.start, sentence.end)]
        else:
            beside = sentence.remarks
        for remark in beside:
            words = self.text[remark.start : remark.end].rstrip("?？ ")
            if remark.kind is RemarkKind.DENIED and any(d.verb is TokenKind.AGAIN for d in sentence.drafts):
                self.reading.object_to(self._say("ask.denial", words))  # "again, but not the turn"
            elif remark.kind is RemarkKind.DENIED and self._may_limit(remark):
                self.reading.object_to(self._say("ask.limit", words))  # "don't go past the door"
                continue
            elif remark.kind is RemarkKind.DENIED and self._may_warn(remark):
                self.besides = self.besides or self._say("ask.besides", words)  # "walk 1 m, it isn't safe"
                continue
            elif remark.kind is RemarkKind.DENIED:
                self.reading.note(self._say("note.not_done", words))
                continue
            half = remark.actions or (remark.beyond and sentence.drafts != [])
            asks = remark.kind in (RemarkKind.QUESTION, RemarkKind.HELP) and first < remark.start
            if remark.kind is RemarkKind.WISH or half or asks or self._may_ask(remark, sentence):
                self.besides = self.besides or self._say("ask.besides", words)
            else:
                self.reading.note(self._say("note.left_out", words))

    def _may_ask(self, beside: Remark, sentence: Sentence) -> bool:
        """Return whether a remark claims rights, holds an action, or may change what is asked.

        What it says of danger the screen judges.
        """
        known, remark = locale(self.language), self.text[beside.start : beside.end]
        question = beside.kind is RemarkKind.QUESTION
        if not sentence.report and not sentence.asked:
            if Clause(remark, known).holds_action(asked=question):
                return True
            if beside.kind is RemarkKind.REMARK and joins_order(remark):
                return True
            if beside.kind is RemarkKind.REMARK and Clause(self._to_pause(beside, sentence), known).unsettles:
                return True
        return re.search(known.claims, remark.lower()) is not None

    def _to_pause(self, beside: Remark, sentence: Sentence) -> str:
        """Return a remark with the rest of its clause: "I'm not sure, …"."""
        ends = [draft.start for draft in sentence.drafts if draft.start >= beside.end]
        if pause := _PAUSE.search(self.text, beside.end):
            ends.append(pause.start())
        return self.text[beside.start : min(ends, default=len(self.text))]

    def _repeat_ahead(self) -> None:
        reading, ahead = self.reading, self.ahead
        if ahead is None or reading.problem:
            return
        said = self.text[ahead.start : ahead.end]
        if not reading.steps:
            reading.object_to(self._say("ask.again", said))
        elif not 1 <= ahead.times * len(reading.steps) <= MAX_STEPS:
            reading.object_to(say("ask.too_many", self.language, steps=MAX_STEPS))
        else:
            reading.steps *= ahead.times
            done = outline(reading.steps, self.language)
            reading.note(say("note.again", self.language, words=quote(said), steps=done))

    def _say(self, key: str, words: str) -> str:
        return say(key, self.language, words=quote(words))

    def _add(self, draft: Draft) -> None:
        reading, said = self.reading, self.text[draft.start : draft.end]
        if draft.stop_word and reading.steps and not (draft.unknown or draft.amount or draft.direction):
            return  # "walk 2 m and stop": it stops by itself
        if draft.beyond:
            self.waits |= draft.beyond == "wait"
            can = operation_names(self.can.operations, self.language)
            reading.object_to(say(f"ask.{draft.beyond}", self.language, words=quote(said), can=can))
        elif draft.unknown or draft.stop_word:
            reading.object_to(self._not_understood(draft, said))
        elif draft.ahead:
            pass  # see `_repeat_ahead`
        elif draft.verb is TokenKind.AGAIN or (draft.back and draft.amount is None and self._is_way_back()):
            self._again(draft, said)
        else:
            self._one(draft, said)

    def _is_way_back(self) -> bool:
        return bool(self.reading.steps or self.background.history) and not self.reading.problem

    def _not_understood(self, draft: Draft, said: str) -> str:
        if draft.stop_word and draft.amount and draft.amount.kind is TokenKind.DURATION:
            self.waits = True
            return self._say("ask.wait", said)
        if draft.stop_word and not draft.unknown and not draft.amount:  # "please wait"
            return self._say("ask.wait", said)
        if draft.odd_number:
            self._hint(draft)
            return self._say("ask.number", said)
        # Within a motion the whole clause is in doubt, otherwise only the words that are not known.
        known_part = draft.is_motion or draft.stop_word or not draft.unknown
        words = said if known_part else self.text[draft.unknown[0][0] : draft.unknown[-1][1]]
        goes = draft.verb in (TokenKind.MOVE, TokenKind.TURN)
        # "Go to the kitchen", "face the door": a place instead of an amount.
        if draft.place and draft.unknown:
            return self._say("ask.place", words) if goes else self._say("ask.eyes", said)
        return self._say("ask.words", words)

    def _again(self, draft: Draft, said: str) -> None:
        reading = self.reading
        if reading.problem:
            return
        try:
            more, note = repeated_steps(draft, said, reading.steps, self.background.history, self.language)
        except AmbiguousRepetition as e:
            reading.object_to(str(e))
            return
        if not all(_in_bounds(step) for step in more):
            reading.object_to(self._say("ask.words", said))
            return
        reading.steps += more
        reading.note(note)
        if len(reading.steps) > MAX_STEPS:  # from here on it would only double
            reading.object_to(say("ask.too_many", self.language, steps=MAX_STEPS))

    def _one(self, draft: Draft, said: str) -> None:
        reading = self.reading
        if isinstance(draft.op, Routine):
            self._routine(draft.op, draft, said)
            return
        step: Primitive | None
        step, problem = self._operation(draft.op, draft, said) if draft.op else self._motion(draft, said)
        if draft.bare_picture:
            step, problem = _PICTURE, ""
        if draft.view is not None and not self._turned_to(draft.view):
            reading.object_to(self._say("ask.view", said))
            reading.hint([[_turn_to(draft.view), _PICTURE]])
        elif step is None:
            reading.object_to(problem)
            self._hint(draft)
        elif not 1 <= draft.times <= MAX_STEPS:
            reading.object_to(say("ask.too_many", self.language, steps=MAX_STEPS))
        elif draft.each is not None:
            reading.picture_after = draft.each
        elif step == _PICTURE and not (draft.counted or draft.again or draft.further) and reading.steps[-1:] == [step]:
            pass  # "take a picture, take a picture": said twice, meant once
        elif len(reading.steps) <= MAX_STEPS:
            reading.steps += _in_whole_turns(step, draft.amount) * draft.times

    def _routine(self, routine: Routine, draft: Draft, said: str) -> None:
        """Add the steps of a dance, a figure or a patrol, or say which sizes and counts fit this robot's limits."""
        reading, can = self.reading, self.can
        kind = draft.amount.kind if draft.amount else None
        size_m = draft.amount.value if draft.amount and isinstance(draft.amount.value, float) else None
        if kind is TokenKind.ANGLE and size_m and not size_m % 360 and not draft.counted:  # 巡逻两圈
            draft = replace(draft, times=int(size_m / 360), amount=None)
            kind, size_m = None, None
        if kind not in (None, TokenKind.LENGTH):  # "walk a square of 1"
            reading.object_to(self._say("ask.unit" if kind is TokenKind.NUMBER else "ask.words", said))
            return
        if size_m is None:
            size_m = usual_size_m(routine, can, max(1, draft.times))
        speed_mps = draft.speed_mps if draft.speed_mps is not None else (SLOW_MPS if draft.slow else None)
        if speed_mps is not None and not SLOW_FROM_MPS <= speed_mps <= FAST_TO_MPS:
            reading.object_to(self._say("ask.speed", said))
            return
        if draft.again or draft.times < 1 or not (steps := steps_of(routine, can, size_m, draft.times)):
            reading.unfit = True
            reading.object_to(unfit(routine, can, self.language, quote(said), size_m, draft.times))
            return
        if draft.faster:
            reading.note(say("note.own_speed", self.language))
        reading.note(routine_note(routine, steps, draft.times, self.language, quote(said)))
        reading.steps += [replace(s, speed_mps=speed_mps) if s.translates else s for s in steps]

    def _operation(self, op: str, draft: Draft, said: str) -> tuple[Primitive | None, str]:
        """Return the operation that was requested, or what this robot does instead ("shake hands")."""
        operation = self.can.operation(op)
        if operation is not None and operation.arguments:
            missing = next((a for a in operation.arguments if a.needed and a.name not in draft.arguments), None)
            if missing is not None:
                self.reading.hint([[example_of(operation, draft.arguments)]])
                can_be = range_of(missing, self.language)
                return None, say("ask.argument", self.language, words=quote(said), range=can_be)
            return Primitive(op, arguments=operation.complete(draft.arguments), declared=operation), ""
        return self._gesture(op, draft, said), ""

    def _gesture(self, op: str, draft: Draft, said: str) -> Primitive:
        known = [other for other in draft.or_else if not isinstance(other, Routine)]
        if op in self.ops or not (others := [other for other in known if other in self.ops]):
            return Primitive(op)
        step = Primitive(others[0])
        self.reading.note(
            say("note.instead", self.language, words=quote(said), step=step_sentence(step, self.language))
        )
        return step

    # -------------------------------------------------------------- walks and turns
    def _motion(self, draft: Draft, said: str) -> tuple[Primitive | None, str]:
        kind = draft.amount.kind if draft.amount else None
        value = float(draft.amount.value) if draft.amount and isinstance(draft.amount.value, float) else 0.0
        if draft.verb is None and draft.direction is None and kind is TokenKind.DURATION:  # "a photo in 5 seconds"
            self.waits = True
            return None, self._say("ask.wait", said)
        alone = draft.verb is None and draft.direction is None and draft.amount is not None
        if alone and kind is TokenKind.NUMBER and value in _WHOLE_TURNS:  # "180"
            return self._turn(draft, value, said)
        if alone and draft.amount and draft.amount.more and kind is TokenKind.LENGTH:  # "one more foot"
            return self._move(replace(draft, direction=self._last_direction()), value, said)
        if draft.verb is None and (draft.amount is None or draft.direction is None) and kind is not TokenKind.ANGLE:
            return None, self._say("ask.what", said)
        back_again = draft.back and self._turned_to(Direction.BACKWARD)  # "turn around and go back 2 m"
        if back_again and kind is TokenKind.LENGTH:
            return None, self._say("ask.words", said)
        if draft.verb is TokenKind.TURN and draft.direction in _AHEAD:
            return None, self._say("ask.words", said)
        # "90 left"; "left 90" alone is asked back, but not where lengths have their unit: "forward 2 m, left 90"
        first = draft.amount is not None and draft.amount.start == draft.start
        side = draft.verb is None and draft.direction in _SIDES
        angle = side and value in _USUAL_ANGLES and (first or self.gives_units)
        turns = draft.verb is TokenKind.TURN or kind is TokenKind.ANGLE or (kind is TokenKind.NUMBER and angle)
        if kind is TokenKind.NUMBER and not (turns and value >= 5):
            return None, self._say("ask.unit", said)
        if turns:
            return (
                (None, self._say("ask.turn_time", said))
                if kind is TokenKind.DURATION
                else self._turn(draft, value, said)
            )
        return self._move(draft, value, said)

    def _last_direction(self) -> Direction | None:
        """Return the direction of the last walk of the post, or else of the thread."""
        before = [step for plan in self.background.history for step in plan.steps] + self.reading.steps
        return next((step.direction for step in reversed(before) if step.translates), None)

    def _turned_to(self, side: Direction) -> bool:
        """Return whether the step before turned the robot to this side: "turn around, take a photo of what's behind
        you"."""
        turned = self.reading.steps[-1] if self.reading.steps and self.reading.steps[-1].rotates else None
        if side is Direction.BACKWARD:
            return turned is not None and turned.degrees == 180.0
        return turned is not None and turned.direction == side

    def _turn(self, draft: Draft, degrees: float, said: str) -> tuple[Primitive | None, str]:
        direction = draft.direction
        if draft.amount is None:
            if draft.vague or direction is None:
                return None, self._say("ask.angle" if direction else "ask.turn", said)
            degrees = 90.0
            self.reading.note(self._say("note.turn_90", said))
        if draft.slow or draft.faster or draft.speed_mps is not None:
            self.reading.note(say("note.turn_speed", self.language))
        if direction in _AHEAD:
            return None, self._say("ask.words", said)
        if direction is None and degrees % 180:
            return None, self._say("ask.side", said)
        if not 0 < degrees <= MAX_DEGREES:
            most = min(MAX_DEGREES, can.limits.step_deg) if (can := self.background.can) else MAX_DEGREES
            return None, say("ask.degrees_bound", self.language, degrees=f"{most:g}")
        return turn(direction or Direction.LEFT, round(degrees, 4)), ""

    def _move(self, draft: Draft, value: float, said: str) -> tuple[Primitive | None, str]:
        if draft.amount is None:
            return None, self._say("ask.distance", said)
        speed = draft.speed_mps if draft.speed_mps is not None else (SLOW_MPS if draft.slow else None)
        if speed is not None and not SLOW_FROM_MPS <= speed <= FAST_TO_MPS:
            return None, self._say("ask.speed", said)
        if unclear := self._unclear_way(draft, draft.amount):
            return None, unclear
        distance_m = value
        if draft.amount.kind is TokenKind.DURATION:
            speed = speed or min(self.background.pace_mps, SLOW_MPS if draft.slow else FAST_TO_MPS)
            distance_m = speed * value
            if 0 < distance_m <= MAX_DISTANCE_M:
                self.reading.note(self._converted("note.duration", said, distance_m, speed))
        elif draft.amount.kind is TokenKind.STEPS:
            if self.background.step_m is None:
                return None, self._say("ask.steps", said)
            distance_m = self.background.step_m * value
            self.reading.note(self._converted("note.steps", said, distance_m, self.background.step_m))
        if not 0 < distance_m <= MAX_DISTANCE_M:
            most = min(MAX_DISTANCE_M, can.limits.step_m) if (can := self.background.can) else MAX_DISTANCE_M
            return None, say("ask.distance_bound", self.language, metres=f"{most:g}")
        if draft.faster and speed is None:
            self.reading.note(say("note.own_speed", self.language))
        return walk(draft.direction or Direction.FORWARD, round(distance_m, 4), speed), ""

    def _unclear_way(self, draft: Draft, amount: Token) -> str:
        """Return a question if the words of a walk leave open where it goes: "walk 1 m that way", "… to the side"."""
        known, steps = locale(self.language), self.reading.steps
        clause = self.clause.lower().translate(known.words.twins)
        if re.search(known.circular, clause):
            return self._say("ask.path", self.clause)
        if draft.direction is not None:
            return ""
        if draft.sideways or re.search(known.some_side, clause):
            draft.sideways = True
            return self._say("ask.side", self.clause)
        goes_on = amount.more or (steps and (steps[-1].translates or steps[-1].rotates))  # "turn left and go that way"
        return self._say("ask.place", self.clause) if not goes_on and re.search(known.pointing, clause) else ""

    def _converted(self, key: str, said: str, distance_m: float, by: float) -> str:
        return say(key, self.language, words=quote(said), metres=f"{distance_m:.4g}", by=f"{by:.4g}")


def _is_length(amount: Token | None) -> bool:
    return amount is not None and amount.kind is TokenKind.LENGTH


def _is_denied(draft: Draft, denied: Draft) -> bool:
    """Return whether a walk or turn is the one that is denied, as far as that is described: "walk 1 m, don't walk".

    "Don't run", "don't go back" and "don't turn 180" leave another walk or turn.
    """
    if (
        draft.unknown
        or denied.unknown
        or denied.verb is None
        or draft.motion is not denied.verb
        or (denied.gait and not draft.gait)
    ):
        return False
    usual = Direction.FORWARD if draft.motion is TokenKind.MOVE else None
    towards = denied.direction in (None, draft.direction or usual)
    amount, other = draft.amount, denied.amount
    return towards and (
        other is None or (amount is not None and (amount.kind, amount.value) == (other.kind, other.value))
    )


def _repeats_gesture(again: Draft, draft: Draft, drafts: Sequence[Draft]) -> bool:
    """Return whether a bare "again" stands between a gesture and the same gesture."""
    repeats = again.verb is TokenKind.AGAIN and again.bare and not again.back
    return repeats and draft.op is not None and any(d.op is draft.op for d in drafts if d.start < again.start)


def _turns_again(before: Draft, draft: Draft) -> bool:
    """Return whether the same turn may be named twice in a row: 转圈，转两圈."""
    turns = [d for d in (before, draft) if d.verb is TokenKind.TURN and not d.direction and _is_whole(d.amount)]
    if (
        draft.joined and not draft.after_and and _is_half(before) and _is_half(draft)
    ):  # "spin round to face the other way"
        return True
    if draft.after_and:
        return False
    return len(turns) == 2 or (before.verb is TokenKind.TURN and _is_bare_angle(draft) and before.amount is not None)


def _is_half(draft: Draft) -> bool:
    """Return whether a draft is a half turn to no side in particular."""
    turns = draft.verb is TokenKind.TURN and not draft.direction
    return turns and draft.amount is not None and draft.amount.value == 180.0


def _is_bare_angle(draft: Draft) -> bool:
    """Return whether only an angle is said, which may be that of the turn before: "turn around, 90 degrees"."""
    angle = draft.amount if draft.verb is None and draft.direction is None else None
    return angle is not None and angle.kind is TokenKind.ANGLE and not angle.more and draft.fixes is None


def _is_whole(amount: Token | None) -> bool:
    value = amount.value if amount is not None and amount.kind is TokenKind.ANGLE else None
    return isinstance(value, float) and value > 0 and value % 360 == 0


def _in_whole_turns(step: Primitive, amount: Token | None) -> list[Primitive]:
    """Return a step for each turn of "two and a half turns": no step may turn further than once around."""
    if amount is None or amount.kind is not TokenKind.ANGLE or not step.rotates or not step.degrees:
        return [step]
    if amount.unit not in (0.0, _WHOLE_TURN_DEG):  # a word such as 一圈半 has no unit
        return [step]
    turns, rest_deg = divmod(step.degrees, _WHOLE_TURN_DEG)
    return [replace(step, degrees=_WHOLE_TURN_DEG)] * int(turns) + [replace(step, degrees=rest_deg)] * bool(rest_deg)


def _turn_to(side: Direction) -> Primitive:
    """Return the turn after which the camera shows this side."""
    return turn(side, 90.0) if side in _SIDES else turn(Direction.LEFT, 180.0)


def _hints(draft: Draft) -> list[list[Primitive]]:
    """Return steps of the kinds that may have been meant, with what was said about them."""
    kind = draft.amount.kind if draft.amount else None
    value = float(draft.amount.value) if draft.amount and isinstance(draft.amount.value, float) else 0.0
    degrees = value if kind in (TokenKind.ANGLE, TokenKind.NUMBER) and 5 <= value <= 360 else 90.0
    turned = turn(draft.direction if draft.direction in _SIDES and draft.direction else Direction.LEFT, degrees)
    if draft.verb is TokenKind.TURN or kind is TokenKind.ANGLE:
        return [[turned]]
    metres = value if kind in (TokenKind.LENGTH, TokenKind.NUMBER) and 0.1 <= value <= MAX_DISTANCE_M else 1.0
    if kind is TokenKind.NUMBER and metres > 5:  # nobody walks "twenty" metres in a room
        metres /= 100
    usual = Direction.LEFT if draft.sideways else Direction.FORWARD
    walked = walk(draft.direction or usual, metres)
    side, number = draft.direction in _SIDES, kind is TokenKind.NUMBER and value >= 5
    either = draft.verb is None and ((side and (number or kind is None)) or (number and draft.direction is None))
    return [[turned], [walked]] if either else [[walked]]


def _in_bounds(step: Primitive) -> bool:
    speeds = step.speed_mps is None or SLOW_FROM_MPS <= step.speed_mps <= FAST_TO_MPS
    return speeds and 0 < (step.distance_m or 1) <= MAX_DISTANCE_M and 0 < (step.degrees or 1) <= MAX_DEGREES


def _after_each(steps: Sequence[Primitive], after: TokenKind) -> list[Primitive]:
    """Insert a picture after every step, or only after every walk or turn, and remove other pictures."""
    wanted = _MOTION_OF.get(after)
    pictured: list[Primitive] = []
    for step in steps:
        if step != _PICTURE:
            pictured += [step, _PICTURE] if wanted in (None, step.base_motion) else [step]
    return pictured
