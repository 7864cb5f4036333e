"""Group tokens into clauses: one draft per step; talk, negations and reports of the past are set aside.

People rarely punctuate, so a clause begins wherever a verb, direction or amount does not fit the one before. A draft
only collects what was said; `steps` decides whether that is enough to move.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from agentrob.language.operations.spoken import FOR_SOMEBODY
from agentrob.language.parser.clause_words import AMOUNTS, HANDLERS, Mode, SentenceState
from agentrob.language.parser.drafts import Draft, RemarkKind, Sentence, actions_of
from agentrob.language.parser.lexicon import Soft, Token, TokenKind
from agentrob.model import PHOTO, BaseMotion, Choice, Direction, Number, Operation, Unit
from agentrob.model.operations.declaration import Argument, Value

#: What an argument in each unit is said with.
_SAID_IN = {
    Unit.METRES: TokenKind.LENGTH, Unit.DEGREES: TokenKind.ANGLE, Unit.SECONDS: TokenKind.DURATION,
    Unit.METRES_PER_SECOND: TokenKind.SPEED, Unit.PERCENT: TokenKind.NUMBER, Unit.COUNT: TokenKind.NUMBER,
}  # fmt: skip
_NONE_DECLARED: Mapping[str, Operation] = {}


def sentences_of(tokens: Sequence[Token], declared: Mapping[str, Operation] = _NONE_DECLARED) -> list[Sentence]:
    """Split tokens into sentences and read each; `declared` are the operations that the robot declares, by name."""
    found: list[Sentence] = []
    start = 0
    for at, token in enumerate([*tokens, Token(TokenKind.END)]):
        if token.kind is TokenKind.END:
            if at > start:
                found.append(_Reader(declared).read(tokens[start:at]))
            start = at + 1
    return found


class _Reader(SentenceState):
    """Reads one sentence, token by token."""

    def __init__(self, declared: Mapping[str, Operation]) -> None:
        super().__init__()
        self.declared = declared

    def read(self, tokens: Sequence[Token]) -> Sentence:
        self._set_aside(tokens)
        for at, token in enumerate(self.tokens):
            self.at = at
            self._take(token)
        self._end_denial()
        self.sentence.fix_unclear = self.sentence.fix_unclear or self.fixing
        if self.pending.each and self.each:  # after each, and nothing to do then
            self._unknown(self.each)
        if self.faster and not self.sentence.drafts:  # "faster!"
            self._unknown(self.faster)
        able = [d for d in self.sentence.drafts if d.takes_manner]
        if able:  # "walk forward 2 m, slowly"
            _hand_over(self.pending, able[-1])
        self.sentence.drafts = [d for d in self.sentence.drafts if not d.empty]
        return self.sentence

    def _set_aside(self, tokens: Sequence[Token]) -> None:
        """Remove tokens without meaning, and keep each beside the token before or after it."""
        self.sentence.start, self.sentence.end = tokens[0].start, tokens[-1].end
        self.tokens, self.soft_before, self.soft_after = [], {}, {}
        soft: list[Token] = []
        for token in tokens:
            self.sentence.greeted |= token.value == Soft.HELLO
            asks = token.kind is TokenKind.REQUEST and token.value is None
            self.sentence.assents |= asks or token.value == Soft.ASSENT
            self.sentence.sent = token if token.value == Soft.SEND else self.sentence.sent
            if token.kind is TokenKind.SOFT:
                soft.append(token)
                continue
            self.soft_before[len(self.tokens)] = self.soft_after[len(self.tokens) - 1] = soft
            self.tokens.append(token)
            # "Walk, uh, walk": the comma between does not matter; "walk and uh walk" are two.
            soft = [s for s in soft if s.value == Soft.UH] if token.kind is TokenKind.COMMA else []
        self.soft_after[len(self.tokens) - 1] = soft

    def _take(self, token: Token) -> None:
        kind = token.kind
        if kind in HANDLERS:
            HANDLERS[kind](self, token)
        elif self.mode is Mode.TALK and not self._leaves_talk(token):
            self.talk_has_motion |= kind in _ACTIONS
            self._goes_on(token)
            self.sentence.somebody_does |= kind in _ACTIONS and self.sentence.somebody is not None
            self.sentence.status_asked |= kind is TokenKind.STATUS and token.value is not None
        elif self.mode is Mode.DENIED:
            self._deny(token)
        elif self.mode is Mode.SUBJECT and kind not in (
            TokenKind.MOVE,
            TokenKind.TURN,
            TokenKind.OP,
            TokenKind.NOT,
            TokenKind.AGAIN,
        ):
            described = kind is TokenKind.TALK_START and token.value == "question" and self._is_said_of_picture()
            elsewhere = kind is TokenKind.OF and token.value == "from"  # "a photo of the cup from above"
            distant = self.cur and self.cur.scene and kind in AMOUNTS  # "what you see forward 3 feet"
            if described or elsewhere or distant:
                self._unknown(token)
            elif kind is TokenKind.DIR and self.cur and self.cur.is_picture:
                self._view(self.cur, token)
        elif self.mode is Mode.SUBJECT and self.cur and (self.cur.op in FOR_SOMEBODY or self.cur.watched):
            self._unknown(token)  # "wave to those who walk 2 m", 让我看看你坐下
        else:
            self.mode = Mode.WANTED
            self._wanted(token)
        # A wish within talk ("I do not think you should walk") begins nothing.
        wished = kind in (TokenKind.WISH, TokenKind.REQUEST) and self.mode is not Mode.TALK
        self.boundary = wished or kind in (TokenKind.AND, TokenKind.COMMA)
        separates = kind in (TokenKind.AND, TokenKind.COMMA) and token.value != "word"
        self.begins = separates or (self.begins and kind in HANDLERS)

    def _leaves_talk(self, token: Token) -> bool:
        """Return whether a verb after a comma begins a command again; not if the talk described motion ("I stood up,
        …").
        """
        if self.talk_has_motion or not self.boundary or self.joined_by_and:
            return False
        return token.kind in (TokenKind.MOVE, TokenKind.TURN, TokenKind.OP)

    def _deny(self, token: Token) -> None:
        """Drop what is denied; an "and" within a denial makes its extent unclear."""
        self._goes_on(token)
        if self.remark and token.kind in (TokenKind.WORD, TokenKind.ARGUMENT):
            self.remark.unknown = True
        if token.kind is TokenKind.OP:
            self.sentence.denied_ops.add(actions_of(token.value)[0])
        if token.kind is TokenKind.MOVE and self.denied and token.start == self.denied.start:
            self.sentence.stays = self.denied
        elif self.denied:
            self._deny_motion(token, self.denied)
        if token.kind in (
            TokenKind.MOVE,
            TokenKind.TURN,
            TokenKind.OP,
            TokenKind.AGAIN,
            TokenKind.BEYOND,
            *AMOUNTS,
            TokenKind.DIR,
        ):
            if self.joined_by_and and self.boundary and self.denial_used:
                self.sentence.denial_unclear, self.sentence.denial_joined = self.denied, True
            self.denial_used = True
        elif token.kind in (
            TokenKind.WORD,
            TokenKind.HELP,
            TokenKind.STATUS,
            TokenKind.MORE_STOP,
            TokenKind.VAGUE,
            TokenKind.SLOW,
            TokenKind.PICTURE,
        ):
            self.denial_used = True

    def _deny_motion(self, token: Token, denied: Token) -> None:
        """Collect what walk or turn is denied; "don't walk into it" denies another than "don't walk"."""
        motions, kind = self.sentence.denied_motions, token.kind
        if not motions or motions[-1].start != denied.start or (motions[-1].verb and kind in _GOING):
            motions.append(Draft(denied.start, token.end))
        motion = motions[-1]
        motion.end = token.end
        if kind in _GOING:
            motion.verb, motion.gait = kind, token.value == "gait"
        elif kind is TokenKind.DIR:
            motion.direction = Direction(str(token.value))
        elif kind in AMOUNTS:
            motion.amount = token
        elif kind is TokenKind.AGAIN and token.value == "this" and self.sentence.drafts:  # "don't do it"
            self.sentence.denial_unclear = denied
        elif kind is not TokenKind.BACK:
            motion.unknown.append((token.start, token.end))

    # ------------------------------------------------------------ what is wanted
    def _wanted(self, token: Token) -> None:
        kind = token.kind
        if (read := _WANTED.get(kind)) is not None:
            read(self, token)
        elif kind is TokenKind.BACK:
            self.way_back = True
        elif kind is TokenKind.TALK or (kind is TokenKind.TALK_START and (self.boundary or self.cur is None)):
            self._begin_talk(token)
        elif kind is TokenKind.HELP:
            self.sentence.help = True
            self._besides(RemarkKind.HELP, token)
        elif kind is TokenKind.STATUS:
            self._status(token)
        else:
            self._qualify(token)

    def _operation(self, token: Token) -> None:
        self._another()
        before = self._open()
        draft = self._new(token, TokenKind.OP)
        draft.op, *others = actions_of(token.value)
        draft.or_else = tuple(others)
        draft.further = token.more
        self._take_amount_before(draft, before)

    # ------------------------------------------------------------ arguments of operations that the robot declares
    def _option(self, token: Token) -> None:
        name, _, option = str(token.value).partition("=")
        if not self._is_argument(token, lambda one: isinstance(one, Choice) and one.name == name, option):
            self._unknown(token)

    def _is_argument(self, token: Token, fits: Callable[[Argument], bool], value: Value) -> bool:
        """Set an argument of the operation that was said last, if it has one that `fits` and is not set.

        It may stand after a comma: 发红光，百分之三十.
        """
        behind_comma = self.at > 0 and self.tokens[self.at - 1].kind is TokenKind.COMMA and self.fixing is None
        cur = self.cur if behind_comma else self._open()
        operation = self.declared.get(str(cur.op)) if cur is not None and cur.verb is TokenKind.OP else None
        if cur is None or operation is None or cur.unknown:
            return False
        found = next((one for one in operation.arguments if one.name not in cur.arguments and fits(one)), None)
        if found is None:
            return False
        cur.arguments[found.name] = value
        cur.end = token.end
        return True

    def _is_amount_of_operation(self, token: Token) -> bool:
        return self._is_argument(
            token, lambda one: isinstance(one, Number) and _SAID_IN[one.unit] is token.kind, _value(token)
        )

    def _take_amount_before(self, draft: Draft, before: Draft | None) -> None:
        """Handle "for 3 seconds blow bubbles": an amount alone that stands before its operation."""
        alone = before is not None and before.verb is None and not (before.direction or before.unknown or before.more)
        if before is None or not alone or before.amount is None or not self._is_amount_of_operation(before.amount):
            return
        draft.start, draft.end, draft.joined = before.start, max(draft.end, self.tokens[self.at].end), before.joined
        draft.after_and, draft.fixes = before.after_and, before.fixes
        self.sentence.drafts.remove(before)

    def _status(self, token: Token) -> None:
        if token.value == "asked":
            self.sentence.status_asked = True
            self._unknown(token)
        else:
            self.sentence.status = True
            self._besides(RemarkKind.WISH, token)

    def _beyond(self, token: Token) -> None:
        cur = self._open()
        # "Walk in a circle", 把报纸拿来, 往前走到门口: what was said before it belongs to it.
        belongs = cur is not None and (
            cur.vaguely_begun
            or (cur.is_motion and token.value == "path")
            or (cur.verb is TokenKind.MOVE and cur.bare and cur.amount is None)  # "go fetch"
        )
        draft = cur if cur is not None and belongs else self._new(token, TokenKind.BEYOND)
        draft.verb, draft.beyond = TokenKind.BEYOND, str(token.value)
        soft = self.soft_after[self.at]
        draft.end = soft[-1].end if soft else token.end
        draft.unknown.append((token.start, draft.end))

    def _again(self, token: Token) -> None:
        cur = self._open()
        if cur is not None and cur.verb is TokenKind.AGAIN and cur.back:  # "undo come back"
            cur.vague = True
            return
        if cur is not None and not cur.unknown and token.value is None:
            cur.again = True
            return  # "turn left 90 degrees again"
        if self.at and self.tokens[self.at - 1].kind is TokenKind.THANKS and token.value is None:
            return  # "hello again"
        draft = self._new(token, TokenKind.AGAIN)
        draft.back, draft.more = token.value == "back", token.value == "more"
        draft.only = _REPEATED.get(str(token.value))
        # "Do it" needs to say how often; "again, turn left" may mean one thing or two.
        draft.vague = token.value == "this" or (self._next() is TokenKind.COMMA and self._next(2) in _ACTIONS)

    def _verb(self, token: Token) -> None:
        self._another()
        cur = self._open()
        if token.value == "sideways" and cur is not None and cur.verb is TokenKind.MOVE and not cur.unknown:
            cur.sideways, cur.end = True, token.end  # "walk 1 m sideways"
            return
        fits = (
            cur is not None
            and cur.verb is None
            and not cur.unknown
            and not (cur.bare_picture or cur.stop_word)
            and (cur.amount is None or (cur.direction is None and _goes(token.kind, cur.amount.kind)))
        )
        if cur is not None and fits:
            cur.verb, cur.end = token.kind, token.end
        else:
            cur = self._new(token, token.kind)
        cur.sideways |= token.value == "sideways"
        cur.gait |= token.value == "gait"
        cur.spun |= token.value == "spin"
        cur.place |= token.value == "to"

    def _direction(self, token: Token) -> None:
        if token is self.agreed:
            return
        direction = Direction(str(token.value))
        if self._is_argument(token, lambda one: isinstance(one, Choice) and one.allows(str(direction)), str(direction)):
            return
        cur = self._open()
        if cur is not None and cur.beyond:  # "raise your left hand"
            cur.end = token.end
            return
        if cur is None or cur.verb is TokenKind.OP or cur.unknown or cur.bare_picture:
            cur = self._new(token, None)
        elif cur.direction is Direction.BACKWARD and cur.amount is None and direction in _SIDES:
            pass  # "move back to your left ninety degrees": back means again
        elif cur.direction not in (None, direction) or (
            cur.amount is not None and cur.amount.kind is TokenKind.ANGLE and direction not in _SIDES
        ):
            cur = self._new(token, None)
        cur.direction, cur.end = direction, token.end
        cur.back, self.way_back = self.way_back, False

    def _amount(self, token: Token) -> None:
        if self._is_amount_of_operation(token):
            return
        cur = self._open()
        if cur is not None and cur.beyond and token.kind is not TokenKind.NUMBER:  # "sleep five seconds"
            cur.end = token.end
            return
        if cur is not None and cur.amount is not None and cur.end == token.end and cur.verb is TokenKind.TURN:
            return  # 一百八十度转身: the angle that a verb implies, where one was said before
        if cur is not None and cur.lacks_size and not cur.unknown and _sizes_figure(token):
            pass  # "walk a square of 1 m", 巡逻两圈
        elif (
            cur is None
            or cur.verb is TokenKind.OP
            or cur.unknown
            or cur.amount is not None
            or (cur.verb is not None and not _goes(cur.verb, token.kind))
        ):
            cur = self._new(token, None)
        cur.amount, cur.end = token, token.end

    def _another(self) -> None:
        """Handle "again wave" or 再来个后空翻: a new step, not a repetition followed by a step."""
        cur = self._open()
        if cur is not None and cur.verb is TokenKind.AGAIN and cur.bare and not cur.back:
            self.sentence.drafts.remove(cur)
            self.cur = None
        elif cur is not None and cur.back and cur.verb is TokenKind.AGAIN:  # "undo walk forward 1 m"
            cur.vague = True

    def _qualify(self, token: Token) -> None:
        """Handle words that say how or how often, and unknown words."""
        kind = token.kind
        if kind is TokenKind.PICTURE:
            self._another()
            self._picture(token)
            return
        last = self.sentence.drafts[-1] if self.sentence.drafts else None
        if kind in _TIMES and last is None and [t.value for t in self.tokens[self.at + 1 : self.at + 2]] == ["colon"]:
            last = self._new(token, TokenKind.AGAIN)  # "three times: …"
        if kind in _TIMES and last and self._counts(last):
            self._count(last, token)
        elif (
            kind is TokenKind.ALONG
            and last
            and self._open() is last
            and last.verb is TokenKind.MOVE
            and not last.direction
        ):
            last.direction, last.end = Direction.FORWARD, token.end
        elif kind is TokenKind.OF:
            self._of(token)
        elif kind in (TokenKind.SLOW, TokenKind.FASTER, TokenKind.VAGUE, TokenKind.SPEED):
            self._manner(token)
        elif kind is TokenKind.MORE_STOP and (
            self._open() is None or self._next() in (TokenKind.END, TokenKind.COMMA, TokenKind.AND)
        ):
            # "Turn right, wait, no, left" waits for nothing.
            if not (self._next() is TokenKind.COMMA and self._next(2) in (TokenKind.NO, TokenKind.FIX)):
                draft = self._new(token, None)
                draft.stop_word, draft.waits = True, token.value == "wait"
        elif kind in _UNITS and last and last.vague and self._open() is last:
            last.end = token.end  # "a few metres"
        else:
            self._unknown(token)

    def _of(self, token: Token) -> None:
        """Handle the subject of a picture or a greeting."""
        cur = self.cur
        if cur is None:
            return
        cur.scene = token.start == cur.start
        if token.value == "every":  # "a photo of every door": one photo does not show them
            self._unknown(token)
            self.mode = Mode.SUBJECT
            return
        if token.value == "from" and cur.is_picture and not cur.closed:  # "a photo from above"
            self._unknown(token)
            self.mode = Mode.SUBJECT
            return
        if token.value not in (None, "from"):
            cur.watched = True
            if token.value in ("watch", "others") and cur.joined:
                self._watch(cur, self.sentence.drafts[-2], token)
                cur = self.cur or cur
        if not cur.closed and (cur.is_picture or cur.op in FOR_SOMEBODY):
            self.mode = Mode.SUBJECT

    def _view(self, picture: Draft, token: Token) -> None:
        """Note the side that a picture should show: "take a look to your left", but not "the back of the box"."""
        side = Direction(str(token.value))
        if side is not Direction.FORWARD and self._next() is not TokenKind.OF:
            picture.view, picture.end = side, token.end

    def _is_said_of_picture(self) -> bool:
        """Return whether a verb after a picture says something of it: "the photo from earlier was upside down"."""
        described = any(token.kind is TokenKind.TALK for token in self.tokens[: self.at])  # "of what is ahead"
        return self.cur is not None and self.cur.bare_picture and not described

    def _watch(self, cur: Draft, before: Draft, token: Token) -> None:
        """Handle what others are to look at: a turn is seen itself, 转一圈给大家看看; 挥手给大家看看 is asked back."""
        amount = before.amount
        whole = amount is not None and amount.kind is TokenKind.ANGLE and not _value(amount) % 360
        turns = before.is_motion and before.verb is TokenKind.TURN and amount is not None and not before.unknown
        if turns and (whole or token.value == "others"):
            self.sentence.drafts.remove(cur)
            before.watched, self.cur = True, before
            self.mode = Mode.SUBJECT
        elif before.op is not cur.op:
            cur.unknown.append((before.start, token.end))

    def _picture(self, token: Token) -> None:
        cur = self._open()
        ends = self._next() in (TokenKind.END, TokenKind.COMMA, TokenKind.AND)
        if cur is not None and ends and cur.is_motion and cur.amount is not None and not cur.unknown:
            cur = self._new(token, None)  # "turn right ninety degrees picture"
            cur.bare_picture = True
        elif cur is None or cur.bare_picture:
            (cur or self._new(token, None)).bare_picture = True
        elif cur.op is not PHOTO:  # "send a pic picture" is one
            self._unknown(token)

    def _count(self, last: Draft, token: Token) -> None:
        if len(self.sentence.drafts) > 1 and (self._open() is not last or self._is_pair(last)):
            self.sentence.times_unclear = token
        last.times, last.counted, last.end = _count(token), True, token.end
        last.more |= token.kind is TokenKind.MORE_TIMES
        if last.spun and last.amount and last.amount.value == 180.0:
            last.amount = last.amount._replace(value=360.0)

    def _is_pair(self, last: Draft) -> bool:
        """Return whether two gestures are joined by "and": "sit and stand twice" may mean both."""
        gestures = all(d.op not in (None, PHOTO) and not d.counted for d in self.sentence.drafts[-2:])
        return gestures and last.paired

    def _counts(self, last: Draft) -> bool:
        """Return whether a count applies to the last draft: "wave twice", "wave, twice"."""
        afterwards = self.at > 0 and self.tokens[self.at - 1].kind is TokenKind.COMMA and not last.counted
        return not last.unknown and (self._open() is last or afterwards)

    def _manner(self, token: Token) -> None:
        if token.kind is TokenKind.SPEED and self._is_amount_of_operation(token):
            return
        cur = self._open()
        draft = cur if cur is not None and cur.takes_manner else self.pending
        draft.slow |= token.kind is TokenKind.SLOW
        draft.slower |= token.kind is TokenKind.SLOW and token.value == "er"
        draft.faster |= token.kind is TokenKind.FASTER
        self.faster = token if token.value == "er" else self.faster
        draft.vague |= token.kind is TokenKind.VAGUE
        draft.speed_mps = _value(token) if token.kind is TokenKind.SPEED else draft.speed_mps
        draft.start, draft.end = (draft.start if draft.end else token.start), token.end

    def _unknown(self, token: Token) -> None:
        if token is self.named:
            return
        cur = self._open() or self._new(token, None)
        soft = self.soft_before[self.at]
        towards = any(s.value == Soft.TOWARDS for s in soft) and not cur.unknown
        goes = cur.is_motion and any(s.value in (Soft.TO, Soft.THE, Soft.TOWARDS) for s in soft)
        cur.place |= goes or towards or token.value == "place"
        cur.unknown.append((token.start, token.end))
        cur.odd_number |= token.value == "number"
        after = self.soft_after[self.at]
        cur.end = after[-1].end if cur.place and after else token.end

    def _open(self) -> Draft | None:
        return self.cur if self.cur and not self.cur.closed else None

    def _new(self, token: Token, verb: TokenKind | None) -> Draft:
        soft = self.soft_before[self.at]
        start = next((s.start for s in soft if s.value in (Soft.OBJECT, Soft.TOWARDS)), token.start)
        draft = Draft(start, token.end, verb, joined=self._open() is not None, fixes=self.fixing)
        joined_by_and = self.at > 0 and self.tokens[self.at - 1].kind is TokenKind.AND
        draft.after_and = self.joined_by_and and not draft.joined
        draft.paired = joined_by_and and self.at > 1 and self.tokens[self.at - 2].kind is TokenKind.OP
        draft.hesitant = not joined_by_and and any(s.value == Soft.UH for s in soft)
        _hand_over(self.pending, draft)
        if verb is TokenKind.OP and token.value == PHOTO:
            draft.each, self.pending.each = self.pending.each, None
        self.fixing = None
        self.sentence.drafts.append(draft)
        self.cur = draft
        return draft


_WANTED: Mapping[TokenKind, Callable[[_Reader, Token], None]] = {
    TokenKind.MOVE: _Reader._verb, TokenKind.TURN: _Reader._verb, TokenKind.DIR: _Reader._direction,
    TokenKind.OP: _Reader._operation, TokenKind.ARGUMENT: _Reader._option, TokenKind.BEYOND: _Reader._beyond,
    TokenKind.AGAIN: _Reader._again, **dict.fromkeys(AMOUNTS, _Reader._amount),
}  # fmt: skip


def _hand_over(pending: Draft, draft: Draft) -> None:
    """Apply manners that were said before the verb to a draft."""
    draft.slow, draft.slower = draft.slow or pending.slow, draft.slower or pending.slower
    draft.faster, draft.vague = draft.faster or pending.faster, draft.vague or pending.vague
    draft.speed_mps = pending.speed_mps if draft.speed_mps is None else draft.speed_mps
    if pending.end:  # what is quoted of it has its manner
        draft.start, draft.end = min(draft.start, pending.start), max(draft.end, pending.end)
    pending.slow = pending.slower = pending.faster = pending.vague = False
    pending.speed_mps, pending.start, pending.end = None, 0, 0


_UNITS = (TokenKind.LENGTH_UNIT, TokenKind.ANGLE_UNIT, TokenKind.STEP_UNIT)
_GOING = (TokenKind.MOVE, TokenKind.TURN)
#: What is repeated by "one more turn".
_REPEATED = {"move": BaseMotion.TRANSLATION, "turn": BaseMotion.ROTATION}
_ACTIONS = (TokenKind.MOVE, TokenKind.TURN, TokenKind.OP)
_TIMES = (TokenKind.TIMES, TokenKind.MORE_TIMES)
_SIDES = (Direction.LEFT, Direction.RIGHT)


def _sizes_figure(amount: Token) -> bool:
    """Whether an amount can be the size of a figure, or the rounds of it."""
    rounds = amount.kind is TokenKind.ANGLE and isinstance(amount.value, float) and not amount.value % 360
    return amount.kind is TokenKind.LENGTH or rounds


def _goes(verb: TokenKind, amount: TokenKind) -> bool:
    """Return whether an amount can belong to a verb: nobody turns by metres, but people say "move thirty degrees
    left".
    """
    return not (verb is TokenKind.TURN and amount in (TokenKind.LENGTH, TokenKind.STEPS))


def _value(token: Token) -> float:
    return token.value if isinstance(token.value, float) else 0.0


def _count(token: Token) -> int:
    """Return the count as a whole number, 0 if it is not one."""
    value = _value(token)
    return int(value) if value == value // 1 and value < 1e6 else 0
