"""Sorts tokens into clauses: one draft per deed, with talk, negations and reports of the past set aside.

People rarely punctuate, so a clause begins wherever a verb, direction or amount no longer fits the one before. A draft
only collects what was said; whether that is enough to move is decided in `steps`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum, auto

from agentrob.language.lexicon import Kind, Token
from agentrob.model import Direction, Op

_AMOUNTS = (Kind.LENGTH, Kind.ANGLE, Kind.STEPS, Kind.DURATION, Kind.NUMBER)


@dataclass
class Draft:
    """What was said of one deed. `verb` is MOVE, TURN, OP or None when only a direction or an amount was said."""

    start: int
    end: int
    verb: Kind | None = None
    op: Op | None = None
    direction: Direction | None = None
    amount: Token | None = None
    speed_mps: float | None = None
    slow: bool = False
    vague: bool = False
    times: int = 1
    counted: bool = False
    each: bool = False
    bare_picture: bool = False
    unknown: list[tuple[int, int]] = field(default_factory=list)
    stop_word: bool = False
    joined: bool = False  # nothing separated it from the draft before
    closed: bool = False

    @property
    def is_motion(self) -> bool:
        return self.verb in (Kind.MOVE, Kind.TURN) or (
            self.verb is None and (self.direction is not None or self.amount is not None)
        )

    @property
    def empty(self) -> bool:
        return not (self.verb or self.direction or self.amount or self.unknown or self.bare_picture or self.stop_word)


@dataclass
class Sentence:
    """Everything between two ends of sentences."""

    drafts: list[Draft] = field(default_factory=list)
    asked: bool = False
    requested: bool = False
    report: bool = False
    condition: Token | None = None
    denial_unclear: Token | None = None  # a "not" whose reach cannot be told
    denial_joined: bool = False  # … because an "and" stands within it
    talked: bool = False
    denied: bool = False
    help: bool = False
    status: bool = False


class _Mode(Enum):
    WANTED = auto()
    TALK = auto()
    DENIED = auto()
    SUBJECT = auto()  # what a picture is to be of


def sentences_of(tokens: Sequence[Token]) -> list[Sentence]:
    """Cut into sentences and read each."""
    found: list[Sentence] = []
    start = 0
    for at, token in enumerate([*tokens, Token(Kind.END)]):
        if token.kind is Kind.END:
            if at > start:
                found.append(_Reader().read(tokens[start:at]))
            start = at + 1
    return found


class _Reader:
    """Reads one sentence, token by token."""

    def __init__(self) -> None:
        self.sentence = Sentence()
        self.mode = _Mode.WANTED
        self.cur: Draft | None = None
        self.boundary = True  # whether a clause may begin here
        self.joined_by_and = False
        self.talk_has_motion = False
        self.denied: Token | None = None
        self.denial_used = False
        self.pending_slow = False
        self.pending_vague = False
        self.pending_speed: float | None = None

    def read(self, tokens: Sequence[Token]) -> Sentence:
        for token in tokens:
            self._take(token)
        self._end_denial()
        motions = [d for d in self.sentence.drafts if d.is_motion]
        if self.pending_slow and motions:  # "walk forward 2 m, slowly"
            motions[-1].slow = True
        self.sentence.drafts = [d for d in self.sentence.drafts if not d.empty]
        return self.sentence

    def _take(self, token: Token) -> None:
        kind = token.kind
        if kind is Kind.SOFT:
            return
        if kind in _MARKS:
            _MARKS[kind](self, token)
        elif self.mode is _Mode.TALK and not self._leaves_talk(token):
            self.talk_has_motion |= kind in (Kind.MOVE, Kind.TURN, Kind.OP)
        elif self.mode is _Mode.DENIED:
            self._deny(token)
        elif self.mode is _Mode.SUBJECT and kind not in (Kind.MOVE, Kind.TURN, Kind.OP, Kind.NOT):
            pass
        else:
            self.mode = _Mode.WANTED
            self._wanted(token)
        # A wish within talk ("I do not think you should walk") begins nothing.
        wished = kind is Kind.WISH and self.mode is _Mode.WANTED
        self.boundary = wished or kind in (Kind.AND, Kind.COMMA, Kind.REQUEST)

    # ------------------------------------------------------------ marks that work in every mode
    def _separate(self, token: Token) -> None:
        if self.mode is _Mode.DENIED and token.kind is Kind.COMMA:
            self._end_denial()
        if self.mode in (_Mode.SUBJECT,):
            self.mode = _Mode.WANTED
        if self.cur:
            self.cur.closed = True
        self.joined_by_and = token.kind is Kind.AND

    def _request(self, token: Token) -> None:
        self.sentence.requested = True
        if self.mode is not _Mode.DENIED:
            self.mode = _Mode.WANTED

    def _wish(self, token: Token) -> None:
        if self.mode is _Mode.SUBJECT:
            self.mode = _Mode.WANTED

    def _asked(self, token: Token) -> None:
        if self.mode is not _Mode.SUBJECT:
            self.sentence.asked = True

    def _report(self, token: Token) -> None:
        self.sentence.report |= self.mode is not _Mode.SUBJECT

    def _condition(self, token: Token) -> None:
        if self.mode is _Mode.WANTED or self.sentence.drafts:
            self.sentence.condition = self.sentence.condition or token

    def _not(self, token: Token) -> None:
        if self.mode is _Mode.TALK:
            return
        self._end_denial()
        self.mode, self.denied, self.denial_used = _Mode.DENIED, token, False
        self.sentence.denied = True
        if self.cur:
            self.cur.closed = True

    # ------------------------------------------------------------ talk and denials
    def _leaves_talk(self, token: Token) -> bool:
        """A verb after a comma begins a command again, unless the talk itself told of motion ("I stood up, …")."""
        if self.talk_has_motion or not self.boundary or self.joined_by_and:
            return False
        return token.kind in (Kind.MOVE, Kind.TURN, Kind.OP)

    def _deny(self, token: Token) -> None:
        """What is denied is dropped; with "and" within its reach nobody can tell what is meant."""
        if token.kind in (Kind.MOVE, Kind.TURN, Kind.OP, *_AMOUNTS, Kind.DIR):
            if self.joined_by_and and self.boundary and self.denial_used:
                self.sentence.denial_unclear, self.sentence.denial_joined = self.denied, True
            self.denial_used = True
        elif token.kind in (Kind.WORD, Kind.HELP, Kind.STATUS, Kind.MORE_STOP, Kind.VAGUE, Kind.SLOW, Kind.PICTURE):
            self.denial_used = True

    def _end_denial(self) -> None:
        if self.mode is _Mode.DENIED:
            if not self.denial_used:
                self.sentence.denial_unclear = self.denied
            self.mode = _Mode.WANTED
            self.cur = None

    # ------------------------------------------------------------ what is wanted
    def _wanted(self, token: Token) -> None:
        kind = token.kind
        if kind in (Kind.MOVE, Kind.TURN):
            self._verb(token)
        elif kind is Kind.DIR:
            self._direction(token)
        elif kind in _AMOUNTS:
            self._amount(token)
        elif kind is Kind.OP:
            self._new(token, Kind.OP).op = Op(str(token.value))
        elif kind in (Kind.TALK, Kind.TALK_START):
            self._talk(token)
        elif kind is Kind.HELP:
            self.sentence.help = True
        elif kind is Kind.STATUS:
            self.sentence.status = True
        else:
            self._qualify(token)

    def _talk(self, token: Token) -> None:
        if token.kind is Kind.TALK_START and not (self.boundary or self.cur is None):
            self._unknown(token)
            return
        if self.cur:
            self.cur.closed = True
        self.mode = _Mode.TALK
        self.sentence.talked = True
        self.talk_has_motion = False
        self.joined_by_and = False

    def _verb(self, token: Token) -> None:
        cur = self._open()
        fits = (
            cur is not None
            and cur.verb is None
            and not cur.unknown
            and not cur.bare_picture
            and (cur.amount is None or (cur.direction is None and _goes(token.kind, cur.amount.kind)))
        )
        if cur is not None and fits:
            cur.verb, cur.end = token.kind, token.end
        else:
            self._new(token, token.kind)

    def _direction(self, token: Token) -> None:
        direction = Direction(str(token.value))
        cur = self._open()
        if cur is None or cur.verb is Kind.OP or cur.unknown or cur.bare_picture:
            cur = self._new(token, None)
        elif cur.direction is Direction.BACKWARD and cur.amount is None and direction in _SIDES:
            pass  # "move back to your left ninety degrees": back means again
        elif cur.direction not in (None, direction) or (
            cur.amount is not None and cur.amount.kind is Kind.ANGLE and direction not in _SIDES
        ):
            cur = self._new(token, None)
        cur.direction, cur.end = direction, token.end

    def _amount(self, token: Token) -> None:
        cur = self._open()
        if cur is not None and cur.amount is not None and cur.end == token.end and cur.verb is Kind.TURN:
            return  # 一百八十度转身: the angle that a verb implies, where one was said before
        if (
            cur is None
            or cur.verb is Kind.OP
            or cur.unknown
            or cur.amount is not None
            or (cur.verb is not None and not _goes(cur.verb, token.kind))
        ):
            cur = self._new(token, None)
        cur.amount, cur.end = token, token.end

    def _qualify(self, token: Token) -> None:
        """Words that say how, how often, or are not known."""
        kind = token.kind
        last = self.sentence.drafts[-1] if self.sentence.drafts else None
        if kind is Kind.TIMES and last and self._open() is last and not last.unknown:
            last.times, last.counted, last.end = _count(token), True, token.end
        elif kind is Kind.EACH and last and last.op is Op.GET_FRONT_IMAGE:
            last.each, last.closed = True, True
        elif kind is Kind.OF:
            if self.cur and not self.cur.closed and self.cur.op is Op.GET_FRONT_IMAGE:
                self.mode = _Mode.SUBJECT
        elif kind in (Kind.SLOW, Kind.VAGUE, Kind.SPEED):
            self._manner(token)
        elif kind is Kind.PICTURE and (self._open() is None or (self._open() is last and last and last.bare_picture)):
            (self._open() or self._new(token, None)).bare_picture = True
        elif kind is Kind.MORE_STOP and self._open() is None:
            self._new(token, None).stop_word = True
        elif kind is Kind.PICTURE and last and self._open() is last and last.op is Op.GET_FRONT_IMAGE:
            pass  # "send a pic picture"
        else:
            self._unknown(token)

    def _manner(self, token: Token) -> None:
        cur = self._open()
        if cur is not None and cur.is_motion:
            cur.slow |= token.kind is Kind.SLOW
            cur.vague |= token.kind is Kind.VAGUE
            cur.speed_mps = _value(token) if token.kind is Kind.SPEED else cur.speed_mps
            cur.end = token.end
        else:
            self.pending_slow |= token.kind is Kind.SLOW
            self.pending_vague |= token.kind is Kind.VAGUE
            self.pending_speed = _value(token) if token.kind is Kind.SPEED else self.pending_speed

    def _unknown(self, token: Token) -> None:
        cur = self._open() or self._new(token, None)
        cur.unknown.append((token.start, token.end))
        cur.end = token.end

    def _open(self) -> Draft | None:
        return self.cur if self.cur and not self.cur.closed else None

    def _new(self, token: Token, verb: Kind | None) -> Draft:
        draft = Draft(token.start, token.end, verb, joined=self._open() is not None)
        draft.slow, draft.vague, draft.speed_mps = self.pending_slow, self.pending_vague, self.pending_speed
        self.pending_slow, self.pending_vague, self.pending_speed = False, False, None
        self.sentence.drafts.append(draft)
        self.cur = draft
        return draft


_SIDES = (Direction.LEFT, Direction.RIGHT)
_MARKS = {
    Kind.AND: _Reader._separate,
    Kind.COMMA: _Reader._separate,
    Kind.REQUEST: _Reader._request,
    Kind.WISH: _Reader._wish,
    Kind.ASKED: _Reader._asked,
    Kind.REPORT: _Reader._report,
    Kind.CONDITION: _Reader._condition,
    Kind.NOT: _Reader._not,
}


def _goes(verb: Kind, amount: Kind) -> bool:
    """Whether an amount can belong to a verb: nobody turns by metres, but people say "move thirty degrees left"."""
    return not (verb is Kind.TURN and amount in (Kind.LENGTH, Kind.STEPS))


def _value(token: Token) -> float:
    return token.value if isinstance(token.value, float) else 0.0


def _count(token: Token) -> int:
    """How often, 0 when that is no whole number."""
    value = _value(token)
    return int(value) if value == value // 1 and value < 1e6 else 0
