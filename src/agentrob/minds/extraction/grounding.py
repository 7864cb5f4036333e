"""Check a model's extraction for inventions: every action, number and direction must be in the post. Pure.

A step must quote words of the post, and no clause of the post may be left over unless it is only politeness or a remark
(law 18). The clause around the quoted words, not the quotation alone, must name the action, the direction and the
amount. What it leaves open may come from a clause that nothing else uses ("turn right, 90 degrees") or, if it refers to
earlier steps ("again", "and now back"), from the previous plan. The plan's numbers are the post's own, converted by us,
never the model's. A doubtful word, "not" or "if", in the same sentence rejects the step.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, TypeVar

from agentrob.language.parser.grammar import asks_for_more, commands_nothing, reorders
from agentrob.language.registry import language_of
from agentrob.minds.extraction.declared import declared_step, with_declared
from agentrob.minds.extraction.evidence import Evidence, EvidenceKind, evidence_in
from agentrob.minds.extraction.schema import ExtractedStep
from agentrob.minds.extraction.units import MPS, degrees, metres, same
from agentrob.model import BUILT_IN, PHOTO, Capabilities, Direction, Plan, Primitive, turn, walk

T = TypeVar("T")
Lack = Literal["words", "action", "direction", "amount", "speed", "count", "denial", "condition", "left_out", "bounds"]
#: Limits on plausible distances and angles; the screen checks the robot's own limits.
MAX_DISTANCE_M, MAX_DEGREES, MAX_STEPS = 100.0, 3600.0, 50
SLOW_MPS = 0.2
#: The angle of a bare "turn left"; the reply states it.
BARE_TURN_DEG = 90.0
#: Smallest number without a unit that counts as degrees of a turn, as in the grammar.
LEAST_BARE_DEG = 5.0
_OPPOSITE = {
    Direction.FORWARD: Direction.BACKWARD,
    Direction.BACKWARD: Direction.FORWARD,
    Direction.LEFT: Direction.RIGHT,
    Direction.RIGHT: Direction.LEFT,
}
_MARKS = " \t\r\n.,;:!?\"'`~*_#-–—…。，！？；：、()（）[]【】“”‘’"


@dataclass(frozen=True, slots=True)
class Grounded:
    """The plan in the post's own numbers. `assumed_turn`: a turn without an angle was taken as 90°."""

    plan: Plan
    assumed_turn: bool = False


@dataclass(frozen=True, slots=True)
class Ungrounded:
    """Something that the post does not say, and the step that lacks it (None: the whole plan), counted as in the
    model's answer."""

    lack: Lack
    step: int | None = None


@dataclass
class _Clause:
    """A stretch of the text with at most one action, and what it says."""

    start: int
    end: int
    sentence: int
    mentions: list[Evidence] = field(default_factory=list)
    claims: int = 0
    bare: bool = False  # only an afterthought such as "90 degrees"
    used: bool = False  # … which completed a step

    def of(self, kind: EvidenceKind) -> list[Evidence]:
        return [m for m in self.mentions if m.kind is kind]

    @property
    def ops(self) -> set[str]:
        return {m.op for m in self.mentions if m.op is not None}

    @property
    def directions(self) -> set[Direction]:
        return {m.direction for m in self.mentions if m.direction is not None}

    @property
    def refers(self) -> bool:
        return bool(self.of(EvidenceKind.AGAIN) or self.of(EvidenceKind.BACK))


def ground(
    steps: Sequence[ExtractedStep], text: str, history: Sequence[Plan] = (), can: Capabilities | None = None
) -> Grounded | Ungrounded:
    """Check what a model extracted from `text` against the text itself and the earlier plans, newest last.

    `can`: what the robot can do, for the operations that it declares.
    """
    return _Check(text, history[-1].steps if history else (), can).run(steps)


def claimed(step: ExtractedStep) -> Primitive:
    """Return a step as the model reads it, to show what was understood; it is never executed."""
    amount_m = metres(step.amount, step.unit) if step.amount and step.unit else None
    amount_deg = degrees(step.amount, step.unit) if step.amount and step.unit else None
    if step.translates:
        speed = step.speed * MPS[step.speed_unit] if step.speed and step.speed_unit else None
        speed = SLOW_MPS if speed is None and step.slow else speed
        return walk(step.direction or Direction.FORWARD, amount_m, speed)
    if step.rotates:
        bare = BARE_TURN_DEG if step.amount is None else None
        return turn(step.direction or Direction.LEFT, amount_deg or bare)
    return Primitive(step.action)


class _Lacking(Exception):
    def __init__(self, lack: Lack) -> None:
        self.lack: Lack = lack


class _Check:
    """One text and the steps before it."""

    def __init__(self, text: str, before: Sequence[Primitive], can: Capabilities | None) -> None:
        self._text = text
        self._can = can
        self._language = language_of(text)
        self._before = before
        self._mentions = with_declared(evidence_in(text), text, can)
        self._clauses = _clauses_of(text, self._mentions)
        self._assumed_turn = False
        self._repeated: dict[int, list[Primitive]] = {}  # by the place of the clause that refers to what was before

    def run(self, steps: Sequence[ExtractedStep]) -> Grounded | Ungrounded:
        found: list[Primitive] = []
        places: list[_Clause] = []
        at = 0
        for number, step in enumerate(steps):
            try:
                at, place = self._place(step, at)
                places.append(place)
            except _Lacking as e:
                return Ungrounded(e.lack, number)
        for number, (step, clause) in enumerate(zip(steps, places, strict=True)):
            try:
                done = [self._primitive(step, clause, places)] * step.times
                found += done
                if clause.refers:
                    self._repeated.setdefault(clause.start, []).extend(done)
            except _Lacking as e:
                return Ungrounded(e.lack, number)
        if not 1 <= len(found) <= MAX_STEPS:
            return Ungrounded("count")
        if lack := self._of_the_whole(places):
            return Ungrounded(lack)
        return Grounded(Plan(tuple(found)), self._assumed_turn)

    # ------------------------------------------------------------ where a step stands
    def _place(self, step: ExtractedStep, at: int) -> tuple[int, _Clause]:
        """Return the clause that a step quotes and that names its action, not before the previous step's."""
        span = _find(self._text, step.words, at)
        if span is None:
            raise _Lacking("words")
        around = [c for c in self._clauses if c.start < span[1] and span[0] < c.end and c.start >= at]
        for clause in around:
            if self._names(step, clause) and clause.claims < self._most(clause):
                clause.claims += step.times
                if clause.claims > self._most(clause):
                    raise _Lacking("count")
                return clause.start, clause
        raise _Lacking("count" if any(self._names(step, c) for c in around) else "action")

    def _names(self, step: ExtractedStep, clause: _Clause) -> bool:
        if step.action in clause.ops:
            return True
        if clause.refers and not clause.ops and any(p.op is step.action for p in self._before):
            return True
        if step.rotates:  # "thirty degrees left", "move thirty degrees left"
            return bool(clause.of(EvidenceKind.ANGLE)) and not clause.of(EvidenceKind.LENGTH)
        return step.translates and bool(clause.of(EvidenceKind.LENGTH)) and not clause.ops  # "then 2 m back"

    def _most(self, clause: _Clause) -> int:
        """Return how many steps a clause can be: one, as many as it counts, or as many as it refers to."""
        most = self._counted(clause)
        return most * max(1, len(self._before)) if clause.refers else most

    def _counted(self, clause: _Clause) -> int:
        """Return how often a clause says to act, 1 by default.

        A number counts beside a word of counting ("three times", 三次), or right before what is counted ("three
        photos").
        """
        counts = {m.value for m in clause.of(EvidenceKind.TIMES)}
        for number in clause.of(EvidenceKind.NUMBER):
            after = next((m for m in self._mentions if m.start >= number.end), None)
            counted = after is not None and after.op is not None and not Primitive(after.op).walks
            if after is not None and counted and not self._text[number.end : after.start].strip():
                counts.add(number.value)
        if len(counts) > 1 or any(c != int(c) or not 1 <= c <= MAX_STEPS for c in counts):
            raise _Lacking("count")
        return int(counts.pop()) if counts else 1

    # ------------------------------------------------------------ what a step is
    def _primitive(self, step: ExtractedStep, clause: _Clause, places: Sequence[_Clause]) -> Primitive:
        if step.action not in BUILT_IN:
            own = declared_step(step.action, self._text[clause.start : clause.end], self._can)
            if own is None:
                raise _Lacking("left_out" if clause.of(EvidenceKind.NUMBER) else "action")
            return own
        if not (step.translates or step.rotates):
            if clause.of(EvidenceKind.LENGTH) or clause.of(EvidenceKind.ANGLE):  # "wave 2 m"
                raise _Lacking("left_out")
            return Primitive(step.action)
        if clause.of(EvidenceKind.LENGTH if step.rotates else EvidenceKind.ANGLE):  # "turn left 2 m"
            raise _Lacking("left_out")
        if clause.refers and (again := self._from_before(step, clause)):
            return self._with_speed(step, clause, again)
        free = [c for c in self._clauses if not any(c is p for p in places)]
        direction = _direction(step, clause, free)
        if step.translates:
            distance_m = _amount(step, clause, free, EvidenceKind.LENGTH)
            if not 0 < distance_m <= MAX_DISTANCE_M:
                raise _Lacking("bounds")
            moved = walk(direction or Direction.FORWARD, round(distance_m, 4))
            return self._with_speed(step, clause, moved)
        angle = self._angle(step, clause, free)
        if direction is None and angle not in (180.0, 360.0):
            raise _Lacking("direction")
        if not 0 < angle <= MAX_DEGREES:
            raise _Lacking("bounds")
        return turn(direction or Direction.LEFT, round(angle, 4))

    def _angle(self, step: ExtractedStep, clause: _Clause, free: Sequence[_Clause]) -> float:
        said = clause.of(EvidenceKind.ANGLE) or [m for c in free if c.bare for m in c.of(EvidenceKind.ANGLE)]
        bare = step.amount is None or same(_asked(step) or 0.0, BARE_TURN_DEG)
        if not said and bare and not clause.of(EvidenceKind.NUMBER):
            self._assumed_turn = True
            return BARE_TURN_DEG
        return _amount(step, clause, free, EvidenceKind.ANGLE)

    def _with_speed(self, step: ExtractedStep, clause: _Clause, move: Primitive) -> Primitive:
        near = [c for c in self._clauses if c.sentence == clause.sentence]
        if not move.translates:
            return move
        speeds = {m.value for c in near for m in c.of(EvidenceKind.SPEED)}
        if step.speed is not None and step.speed_unit is not None:
            asked = step.speed * MPS[step.speed_unit]
            if len(speeds) != 1 or not same(asked, next(iter(speeds))):
                raise _Lacking("speed")
            return replace(move, speed_mps=next(iter(speeds)))
        if speeds or step.speed is not None:
            raise _Lacking("speed")  # the post names a speed that the model left out, or the other way round
        if any(c.of(EvidenceKind.SLOW) for c in near):  # slower than asked is never wrong
            return replace(move, speed_mps=min(SLOW_MPS, move.speed_mps or SLOW_MPS))
        return move

    def _from_before(self, step: ExtractedStep, clause: _Clause) -> Primitive | None:
        """Return an earlier step, repeated or reversed, with the changes that the clause names."""
        back = bool(clause.of(EvidenceKind.BACK))
        kind = EvidenceKind.LENGTH if step.translates else EvidenceKind.ANGLE
        said = {m.value for m in clause.of(kind)}
        for before in self._before:
            if before.op is not step.action or before.direction is None:
                continue
            turned = _OPPOSITE[before.direction] if back else before.direction
            plain = clause.directions - ({Direction.BACKWARD} if back else set())
            directions = plain or {turned}
            amount = before.distance_m if step.translates else before.degrees
            amounts = said or {amount or 0.0}
            asked = _asked(step)
            if len(amounts) != 1 or (asked is not None and not same(asked, next(iter(amounts)))):
                continue
            if len(directions) != 1 or (step.direction is not None and step.direction not in directions):
                continue
            field_name = "distance_m" if step.translates else "degrees"
            return replace(before, direction=next(iter(directions)), **{field_name: next(iter(amounts))})  # type: ignore[arg-type]
        return None

    # ------------------------------------------------------------ the whole
    def _of_the_whole(self, places: Sequence[_Clause]) -> Lack | None:
        """Return what is wrong with the whole: denials and conditions in a used sentence, or clauses that were left
        out.
        """
        used = {c.sentence for c in places}
        named = {m.start for m in self._mentions if m.kind is EvidenceKind.ACTION}
        if max(len(places), len(named)) > 1 and reorders(self._text, self._language):
            return "condition"
        for clause in self._clauses:
            placed = any(clause is p for p in places)
            if clause.sentence in used and clause.of(EvidenceKind.NOT):
                return "denial"
            if clause.sentence in used and clause.of(EvidenceKind.IF):
                return "condition"
            rest = _without(self._text, clause, tuple(EvidenceKind))
            if placed and not clause.refers and asks_for_more(_MANNERS.sub("", rest), self._language):
                return "left_out"
            if placed and clause.refers:
                if not self._repeats_all(clause):
                    return "left_out"
            elif placed and clause.claims != self._counted(clause):
                return "count"
            elif not placed and not clause.used and not self._is_remark(clause):
                return "left_out"
        return None

    def _is_remark(self, clause: _Clause) -> bool:
        """Return whether a clause without a step is politeness, a remark, or a speed; an action with a side is not."""
        if clause.ops and clause.directions:
            return False
        words = _without(self._text, clause, (EvidenceKind.SLOW, EvidenceKind.SPEED))
        return commands_nothing(_MANNERS.sub("", words), self._language)

    def _repeats_all(self, clause: _Clause) -> bool:
        """Return whether everything a clause refers to is done in order, and nothing of the clause is left over.

        If it names a kind of step ("the same walk"), that must be the only one of its kind.
        """
        before = [step for step in self._before if not clause.ops or step.op in clause.ops]
        done = self._repeated.get(clause.start, [])
        if not before:  # "go another 2 m" where nothing was before: wholly said by itself
            return len(done) == self._counted(clause)
        if clause.ops and len(before) != 1:
            return len(done) == 1 and bool(clause.of(EvidenceKind.LENGTH) or clause.of(EvidenceKind.ANGLE))
        if clause.of(EvidenceKind.BACK):
            before = [step for step in reversed(before) if step.walks]
        own = bool(clause.ops) or len(before) == 1
        changed = clause.directions - ({Direction.BACKWARD} if clause.of(EvidenceKind.BACK) else set())
        if not own and (changed or clause.of(EvidenceKind.LENGTH) or clause.of(EvidenceKind.ANGLE)):
            return False
        left = _MANNERS.sub("", _without(self._text, clause, tuple(EvidenceKind)))
        whole = [step.op for step in done] == [step.op for step in before] * self._counted(clause)
        return whole and all(word.lower() in _WHOLE or commands_nothing(word, self._language) for word in left.split())


# ---------------------------------------------------------------------- parts of a step
def _asked(step: ExtractedStep) -> float | None:
    """Return the amount as the model reads it, in metres or degrees."""
    if step.amount is None or step.unit is None:
        return None
    return metres(step.amount, step.unit) if step.translates else degrees(step.amount, step.unit)


def _amount(step: ExtractedStep, clause: _Clause, free: Sequence[_Clause], kind: EvidenceKind) -> float:
    """Return the amount that the post says, if the model says the same."""
    values = {m.value for m in clause.of(kind)} or _completed_by(free, lambda c: {m.value for m in c.of(kind)})
    if not values and kind is EvidenceKind.ANGLE:  # "turn one eighty to the right"
        values = {m.value for m in clause.of(EvidenceKind.NUMBER) if m.value >= LEAST_BARE_DEG}
    asked = _asked(step)
    if len(values) != 1 or asked is None or not same(asked, next(iter(values))):
        raise _Lacking("amount")
    return next(iter(values))


def _completed_by(free: Sequence[_Clause], said: Callable[[_Clause], set[T]]) -> set[T]:
    """Return what afterthoughts say ("turn right and take a photo, 90 degrees"), and mark them as used."""
    found: set[T] = set()
    for clause in free:
        if clause.bare and (values := said(clause)):
            clause.used = True
            found |= values
    return found


def _direction(step: ExtractedStep, clause: _Clause, free: Sequence[_Clause]) -> Direction | None:
    """The direction that the post says, when the model says the same; None when neither says one."""
    said = clause.directions or _completed_by(free, lambda c: c.directions)
    elsewhere = {d for c in free for d in c.directions}
    if step.rotates:
        said &= {Direction.LEFT, Direction.RIGHT}
        if not said and (step.direction is None or (step.direction is Direction.LEFT and _whole(clause))):
            return None  # a whole or half turn without a side; the caller looks at the angle
    elif not said and not elsewhere and step.direction in (None, Direction.FORWARD):
        return None
    if len(said) != 1 or step.direction not in (None, *said):
        raise _Lacking("direction")
    return next(iter(said))


def _whole(clause: _Clause) -> bool:
    """A whole or half turn, of which the side does not matter."""
    return any(m.value in (180.0, 360.0) for m in clause.of(EvidenceKind.ANGLE))


# ---------------------------------------------------------------------- clauses and quotes
def _clauses_of(text: str, mentions: Sequence[Evidence]) -> list[_Clause]:
    """Cut at marks and joining words, and before each further verb of motion."""
    found: list[_Clause] = []
    current = _Clause(0, 0, 0)
    for mention in mentions:
        if mention.kind in (EvidenceKind.BREAK, EvidenceKind.END):
            current.end = mention.start
            found.append(current)
            current = _Clause(mention.end, mention.end, current.sentence + (mention.kind is EvidenceKind.END))
            continue
        if mention.kind is EvidenceKind.ACTION and _full(current, mention):
            current.end = mention.start
            found.append(current)
            current = _Clause(mention.start, mention.start, current.sentence)
        current.mentions.append(mention)
    current.end = len(text)
    found.append(current)
    for clause in found:
        clause.bare = _is_bare(text, clause)
    return [c for c in found if text[c.start : c.end].strip(_MARKS)]


#: Manners that the grammar does not read: somebody who is greeted by name, "be a dear", "this time".
_MANNERS = re.compile(
    r"^\W*(?:hey|hi|hello|thanks|thank you|嗨|你好|谢谢)\s+\w+\W*$|\b(?:just |only )?(?:this time|this once)\b"
    r"|\bbe (?:an?|my) (?:good \w+|dear|darling|angel|love|star|pal|sweetheart|sport|champ|hero|treasure|legend)\b",
    re.IGNORECASE,
)
#: Words beside "again" that mean the whole of it.
_WHOLE = frozenset(["very", "exact", "thing", "things", "whole", "sequence", "before"])
#: Words that may stand beside an amount or a side without changing it.
_SOFT = frozenset(
    """about around roughly exactly only just to the a an of by at please for over that is
    大约 大概 左右 约 的 请 就""".split()  # noqa: SIM905
)


def _is_bare(text: str, clause: _Clause) -> bool:
    if clause.ops and clause.directions:
        return False
    rest = _without(text, clause, tuple(EvidenceKind))
    return all(word.strip(".,;:!?~'\"").lower() in _SOFT | {""} for word in rest.split())


def _without(text: str, clause: _Clause, kinds: Sequence[EvidenceKind]) -> str:
    """Return the words of a clause with evidence of these kinds blanked out."""
    rest = list(text[clause.start : clause.end])
    for mention in clause.mentions:
        if mention.kind in kinds:
            rest[mention.start - clause.start : mention.end - clause.start] = " " * (mention.end - mention.start)
    return "".join(rest)


def _full(clause: _Clause, verb: Evidence) -> bool:
    """Return whether a clause is complete, so that a further verb begins another; "move, uh, move 2 m" is one."""
    if not any(m.kind is EvidenceKind.ACTION and m.end <= verb.start for m in clause.mentions):
        return False
    if verb.op in clause.ops:  # "snap three pictures" is one action, 挥手后挥手两次 two
        twice = verb.op != PHOTO and not Primitive(verb.op).walks and clause.directions
        return bool(twice or clause.of(EvidenceKind.LENGTH) or clause.of(EvidenceKind.ANGLE))
    return bool(
        any(not Primitive(op).walks for op in clause.ops)
        or clause.directions
        or clause.of(EvidenceKind.LENGTH)
        or clause.of(EvidenceKind.ANGLE)
    )


def _find(text: str, words: str, at: int) -> tuple[int, int] | None:
    """Find words in a text, ignoring case, spaces and marks at their ends; at or after `at`, or around it."""
    parts = words.strip(" \t\n.,;:!?\"'`。，！？；：").split()
    if not parts:
        return None
    pattern = re.compile(r"\s+".join(map(re.escape, parts)), re.IGNORECASE)
    match = pattern.search(text, at) or next((m for m in pattern.finditer(text) if m.end() > at), None)
    return match.span() if match else None
