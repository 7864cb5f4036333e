"""Sorts tokens into clauses: one draft per deed, with talk, negations and reports of the past set aside.

People rarely punctuate, so a clause begins wherever a verb, direction or amount no longer fits the one before. A draft
only collects what was said; whether that is enough to move is decided in `steps`.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum, auto

from agentrob.language.drafts import Draft, Sentence
from agentrob.language.lexicon import Kind, Token
from agentrob.model import Direction, Op

_AMOUNTS = (Kind.LENGTH, Kind.ANGLE, Kind.STEPS, Kind.DURATION, Kind.NUMBER)


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
        self.pending = Draft(0, 0)  # manners said before their verb
        self.fixing: Token | None = None
        self.way_back = False
        self.each: Token | None = None
        self.faster: Token | None = None
        self.agreed: Token | None = None
        self.named: Token | None = None
        self.tokens: Sequence[Token] = ()
        self.at = 0

    def read(self, tokens: Sequence[Token]) -> Sentence:
        self.tokens = [t for t in tokens if t.kind is not Kind.SOFT]
        for self.at, token in enumerate(self.tokens):
            self._take(token)
        self._end_denial()
        self.sentence.fix_unclear = self.fixing
        if self.pending.each and self.each:  # after each, and nothing to do then
            self._unknown(self.each)
        if self.faster and not self.sentence.drafts:  # "faster!"
            self._unknown(self.faster)
        able = [d for d in self.sentence.drafts if d.takes_manner]
        if able:  # "walk forward 2 m, slowly"
            _hand_over(self.pending, able[-1])
        self.sentence.drafts = [d for d in self.sentence.drafts if not d.empty]
        return self.sentence

    def _take(self, token: Token) -> None:
        kind = token.kind
        if kind in _MARKS:
            _MARKS[kind](self, token)
        elif self.mode is _Mode.TALK and not self._leaves_talk(token):
            self.talk_has_motion |= kind in (Kind.MOVE, Kind.TURN, Kind.OP)
        elif self.mode is _Mode.DENIED:
            self._deny(token)
        elif self.mode is _Mode.SUBJECT and kind not in (Kind.MOVE, Kind.TURN, Kind.OP, Kind.NOT, Kind.AGAIN):
            pass
        else:
            self.mode = _Mode.WANTED
            self._wanted(token)
        # A wish within talk ("I do not think you should walk") begins nothing.
        wished = kind is Kind.WISH and self.mode is _Mode.WANTED
        self.boundary = wished or kind in (Kind.AND, Kind.COMMA, Kind.REQUEST)

    def _next(self, steps: int = 1) -> Kind:
        """The kind of the token so many places on."""
        return self.tokens[self.at + steps].kind if self.at + steps < len(self.tokens) else Kind.END

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

    def _fix(self, token: Token) -> None:
        """What follows corrects what was said; if nothing was said before, it is only a manner of beginning."""
        if self.mode is _Mode.DENIED:
            self._end_denial()
        if self.mode is not _Mode.TALK:
            self.mode = _Mode.WANTED
            self.fixing = token
        if self.cur:
            self.cur.closed = True

    def _no(self, token: Token) -> None:
        following = self._next()
        if following in (Kind.COMMA, Kind.END) or (self.sentence.drafts and following in _CORRECTING):
            self._fix(token)
        elif self.mode is not _Mode.TALK:  # "no turn left": nobody can tell
            self.sentence.denial_unclear = self.sentence.denial_unclear or token

    def _is(self, token: Token) -> None:
        if self.mode is _Mode.WANTED and self.sentence.drafts and self._next() in _CORRECTING:
            self._fix(token)
        elif self.mode is _Mode.WANTED:
            self._talk(token)

    def _each(self, token: Token) -> None:
        """ "… and take a photo after each", "after each turn, take a photo"."""
        last = self.sentence.drafts[-1] if self.sentence.drafts else None
        after = Kind(str(token.value)) if token.value else Kind.END
        if self.mode is _Mode.DENIED:
            self.denial_used = True
        elif last is not None and last.op is Op.GET_FRONT_IMAGE and last is self.cur:
            last.each, last.closed, self.mode = after, True, _Mode.WANTED
        elif self.mode is not _Mode.TALK:
            self.mode, self.pending.each, self.each = _Mode.WANTED, after, token
            if self.cur:
                self.cur.closed = True

    def _thanks(self, token: Token) -> None:
        """ "Thank you, Henry" at an end: a name."""
        if self._next() is Kind.WORD and self._next(2) in (Kind.END, Kind.COMMA):
            self.named = self.tokens[self.at + 1]

    def _agree(self, token: Token) -> None:
        """ "Right, take a photo", "right, walk forward 2 m": no direction where a command of its own follows."""
        if self.at or self.mode is not _Mode.WANTED:
            return
        rest = [t.kind for t in self.tokens[self.at + 2 :]]
        clause = rest[1 : rest.index(Kind.AND) if Kind.AND in rest else None] if rest[:1] == [Kind.COMMA] else []
        if rest[:1] == [Kind.OP] or clause[:1] == [Kind.OP] or (clause[:1] in _VERBS and Kind.DIR in clause):
            self.agreed = self.tokens[self.at + 1]

    # ------------------------------------------------------------ talk and denials
    def _leaves_talk(self, token: Token) -> bool:
        """A verb after a comma begins a command again, unless the talk itself told of motion ("I stood up, …")."""
        if self.talk_has_motion or not self.boundary or self.joined_by_and:
            return False
        return token.kind in (Kind.MOVE, Kind.TURN, Kind.OP)

    def _deny(self, token: Token) -> None:
        """What is denied is dropped; with "and" within its reach nobody can tell what is meant."""
        if token.kind in (Kind.MOVE, Kind.TURN, Kind.OP, Kind.AGAIN, Kind.BEYOND, *_AMOUNTS, Kind.DIR):
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
        elif kind is Kind.BEYOND:
            self._beyond(token)
        elif kind is Kind.AGAIN:
            self._again(token)
        elif kind is Kind.BACK:
            self.way_back = True
        elif kind in (Kind.TALK, Kind.TALK_START):
            self._talk(token)
        elif kind is Kind.HELP:
            self.sentence.help = True
        elif kind is Kind.STATUS:
            self.sentence.status = True
        else:
            self._qualify(token)

    def _beyond(self, token: Token) -> None:
        draft = self._new(token, Kind.BEYOND)
        draft.beyond = str(token.value)
        draft.unknown.append((token.start, token.end))

    def _again(self, token: Token) -> None:
        cur = self._open()
        if cur is not None and not cur.unknown and not cur.bare_picture and token.value is None:
            return  # "turn left 90 degrees again"
        draft = self._new(token, Kind.AGAIN)
        draft.back = token.value == "back"
        # "Do it" needs to say how often; "again, turn left" may mean one thing or two.
        draft.vague = token.value == "this" or (self._next() is Kind.COMMA and self._next(2) in _DEEDS)

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
        if cur is not None and cur.verb is Kind.AGAIN and cur.bare and not cur.back:  # "again, turn left"
            self.sentence.drafts.remove(cur)
            cur = self.cur = None
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
        if token is self.agreed:
            return
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
        cur.back, self.way_back = self.way_back, False

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
        elif kind is Kind.ALONG and last and self._open() is last and last.verb is Kind.MOVE and not last.direction:
            last.direction, last.end = Direction.FORWARD, token.end
        elif kind is Kind.OF:
            if self.cur and not self.cur.closed and self.cur.op is Op.GET_FRONT_IMAGE:
                self.mode = _Mode.SUBJECT
        elif kind in (Kind.SLOW, Kind.FASTER, Kind.VAGUE, Kind.SPEED):
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
        draft = cur if cur is not None and cur.takes_manner else self.pending
        draft.slow |= token.kind is Kind.SLOW
        draft.slower |= token.kind is Kind.SLOW and token.value == "er"
        draft.faster |= token.kind is Kind.FASTER
        self.faster = token if token.value == "er" else self.faster
        draft.vague |= token.kind is Kind.VAGUE
        draft.speed_mps = _value(token) if token.kind is Kind.SPEED else draft.speed_mps
        draft.end = token.end

    def _unknown(self, token: Token) -> None:
        if token is self.named:
            return
        cur = self._open() or self._new(token, None)
        cur.unknown.append((token.start, token.end))
        cur.end = token.end

    def _open(self) -> Draft | None:
        return self.cur if self.cur and not self.cur.closed else None

    def _new(self, token: Token, verb: Kind | None) -> Draft:
        draft = Draft(token.start, token.end, verb, joined=self._open() is not None, fixes=self.fixing)
        _hand_over(self.pending, draft)
        if verb is Kind.OP and token.value == Op.GET_FRONT_IMAGE:
            draft.each, self.pending.each = self.pending.each, None
        self.fixing = None
        self.sentence.drafts.append(draft)
        self.cur = draft
        return draft


def _hand_over(pending: Draft, draft: Draft) -> None:
    """Give the manners that were said beforehand to a draft."""
    draft.slow, draft.slower = draft.slow or pending.slow, draft.slower or pending.slower
    draft.faster, draft.vague = draft.faster or pending.faster, draft.vague or pending.vague
    draft.speed_mps = pending.speed_mps if draft.speed_mps is None else draft.speed_mps
    pending.slow = pending.slower = pending.faster = pending.vague = False
    pending.speed_mps = None


_DEEDS = (Kind.MOVE, Kind.TURN, Kind.OP)
_VERBS = ([Kind.MOVE], [Kind.TURN])
_CORRECTING = (Kind.MOVE, Kind.TURN, Kind.OP, Kind.DIR, Kind.AGREE, Kind.BACK, Kind.FIX, Kind.NO, *_AMOUNTS)
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
    Kind.NO: _Reader._no,
    Kind.FIX: _Reader._fix,
    Kind.IS: _Reader._is,
    Kind.EACH: _Reader._each,
    Kind.AGREE: _Reader._agree,
    Kind.THANKS: _Reader._thanks,
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
