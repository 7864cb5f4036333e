"""Handle words that affect a whole clause: and, not, if, no wait, never mind, after each.

`clauses` reads the words around them; both share `SentenceState`.
"""

from __future__ import annotations

from enum import Enum, auto

from agentrob.language.parser.drafts import Draft, Remark, RemarkKind, Sentence
from agentrob.language.parser.lexicon import Soft, Token, TokenKind, Value
from agentrob.model import PHOTO

AMOUNTS = (TokenKind.LENGTH, TokenKind.ANGLE, TokenKind.STEPS, TokenKind.DURATION, TokenKind.NUMBER)
_VERBS = ([TokenKind.MOVE], [TokenKind.TURN])
#: The kind of a remark, by its first token.
_KINDS: dict[Value, RemarkKind] = {"question": RemarkKind.QUESTION, "ask": RemarkKind.WISH, "tell": RemarkKind.WISH}
#: Tokens that may be requested even within talk.
_ACTIONS = (TokenKind.MOVE, TokenKind.TURN, TokenKind.OP, TokenKind.AGAIN, TokenKind.BACK)
#: Amounts that may say how far off a thing is.
_DISTANCES = (TokenKind.LENGTH, TokenKind.STEPS)
#: Tokens that may begin a further clause of talk.
_TELLING = (TokenKind.TALK, TokenKind.TALK_START, TokenKind.IS, TokenKind.ASKED, TokenKind.THANKS, TokenKind.REPORT)
#: Tokens that can follow a "no" that corrects.
_CORRECTING = (
    TokenKind.MOVE,
    TokenKind.TURN,
    TokenKind.OP,
    TokenKind.DIR,
    TokenKind.AGREE,
    TokenKind.BACK,
    TokenKind.FIX,
    TokenKind.NO,
    *AMOUNTS,
)


class Mode(Enum):
    WANTED = auto()
    TALK = auto()
    DENIED = auto()
    SUBJECT = auto()  # the subject of a picture


class SentenceState:
    """The state while one sentence is read, and what each clause word does to it."""

    def __init__(self) -> None:
        self.sentence = Sentence()
        self.mode = Mode.WANTED
        self.cur: Draft | None = None
        self.boundary = True  # a clause may begin here
        self.begins = True  # the same within talk, also after words such as "and you should …"
        self.joined_by_and = False
        self.talk_has_motion = False
        self.talk_doubts = False  # a question, or something is denied in it
        self.denied: Token | None = None
        self.denial_used = False
        self.pending = Draft(0, 0)  # manners before their verb
        self.fixing: Token | None = None
        self.way_back = False
        self.each: Token | None = None
        self.faster: Token | None = None
        self.agreed: Token | None = None
        self.named: Token | None = None
        self.remark: Remark | None = None  # the most recent stretch of talk or denial
        self.tokens: list[Token] = []
        #: Tokens without meaning before and after each position in `tokens`.
        self.soft_before: dict[int, list[Token]] = {}
        self.soft_after: dict[int, list[Token]] = {}
        self.at = 0

    def _next(self, steps: int = 1) -> TokenKind:
        """Return the kind of the token `steps` positions ahead."""
        return self.tokens[self.at + steps].kind if self.at + steps < len(self.tokens) else TokenKind.END

    def _separate(self, token: Token) -> None:
        if self.mode is Mode.DENIED and token.kind is TokenKind.COMMA:
            self._end_denial()
        if self.mode in (Mode.SUBJECT,):
            self.mode = Mode.WANTED
        if self.cur:
            self.cur.closed = True
            again = self.cur.verb is TokenKind.AGAIN and self.cur.counted and not self.cur.back
            self.cur.ahead |= again and token.value == "colon" and len(self.sentence.drafts) == 1
        after_and = (
            self.joined_by_and and self.at > 0 and self.tokens[self.at - 1].kind is TokenKind.AND
        )  # "then finally"
        self.joined_by_and = token.kind is TokenKind.AND or after_and

    def _request(self, token: Token) -> None:
        if self.mode is Mode.TALK and token.value == "stated" and self.talk_doubts:
            return  # "I do not think I want you to …", "do you think we should …"
        if token.value == "tag" and not any(draft.is_action for draft in self.sentence.drafts):
            return  # 天气好吗
        if self.mode is Mode.TALK and self._asks_how():
            return  # "how far can you walk"
        self.sentence.requested = True
        if self.mode is not Mode.DENIED:
            self.mode = Mode.WANTED

    def _asks_how(self) -> bool:
        """Return whether a question word precedes, possibly with a manner between: "how", "how far"."""
        before = self.tokens[max(0, self.at - 2) : self.at]
        if len(before) > 1 and before[1].kind in (TokenKind.VAGUE, TokenKind.SLOW, TokenKind.FASTER):
            before = before[:1]
        return before[-1:] != [] and before[-1].kind is TokenKind.TALK and before[-1].value == "question"

    def _wish(self, token: Token) -> None:
        if self.mode is Mode.SUBJECT:
            self.mode = Mode.WANTED

    def _asked(self, token: Token) -> None:
        if self.mode is not Mode.SUBJECT:
            self.sentence.asked = True

    def _report(self, token: Token) -> None:
        if self.mode is not Mode.SUBJECT:
            self.sentence.report = True
            at = self.sentence.reported_at
            self.sentence.reported_at = token.start if at is None else at

    def _condition(self, token: Token) -> None:
        before = self.sentence.condition
        if token.value == "later":  # 等五秒后, 五秒后: with what is said of the time
            number = self.tokens[self.at - 1] if self.at else token
            start = (
                before if before and before.value == "wait" else number if number.kind is TokenKind.NUMBER else token
            )
            token, before = token._replace(start=start.start), None if start is before else before
        ends_denial = token.value == "ends" and self.mode is Mode.DENIED  # 没人的话
        if self.mode is Mode.WANTED or self.sentence.drafts or ends_denial:
            self.sentence.condition = before or token

    def _not(self, token: Token) -> None:
        if self.mode is Mode.TALK:
            self.talk_doubts = True
            return
        if token.value == "no" and self._next() is TokenKind.COMMA and self.sentence.drafts:  # 前进两米，不，三米
            self._fix(token)
            return
        self._end_denial()
        self.mode, self.denied, self.denial_used = Mode.DENIED, token, False
        self._besides(RemarkKind.DENIED, token)
        self.sentence.denied = True
        if self.cur:
            self.cur.closed = True

    def _fix(self, token: Token) -> None:
        """Note that what follows corrects what was said; at the beginning of a sentence it has no meaning."""
        if self.mode is Mode.DENIED:
            self._end_denial()
        if self.mode is not Mode.TALK:
            self.mode = Mode.WANTED
            self.fixing = token
        if self.cur:
            self.cur.closed = True

    def _no(self, token: Token) -> None:
        following = self._next()
        if following in (TokenKind.COMMA, TokenKind.END) or (self.sentence.drafts and following in _CORRECTING):
            self._fix(token)
        elif self.mode is not Mode.TALK:  # "no turn left": nobody can tell
            self.sentence.denial_unclear = self.sentence.denial_unclear or token

    def _cancel(self, token: Token) -> None:
        if self.mode is Mode.WANTED and self.sentence.drafts:  # "turn left, never mind", perhaps ", just wave"
            self.fixing = token
            if self.cur:
                self.cur.closed = True
        elif self.mode is not Mode.TALK:
            self.sentence.cancelled = self.sentence.cancelled or token

    def _is(self, token: Token) -> None:
        if self.mode is Mode.WANTED and self.sentence.drafts and self._next() in _CORRECTING:
            self._fix(token)
        elif self.mode is Mode.WANTED:
            self._begin_talk(token)

    def _each(self, token: Token) -> None:
        """Handle "… and take a photo after each" and "after each turn, take a photo"."""
        last = self.sentence.drafts[-1] if self.sentence.drafts else None
        after = TokenKind(str(token.value)) if token.value else TokenKind.END
        if self.mode is Mode.DENIED:
            self.denial_used = True
        elif last is not None and last.op is PHOTO and last is self.cur:
            last.each, last.closed, self.mode = after, True, Mode.WANTED
        elif self.mode is not Mode.TALK:
            self.mode, self.pending.each, self.each = Mode.WANTED, after, token
            if self.cur:
                self.cur.closed = True

    def _thanks(self, token: Token) -> None:
        """Handle a name after thanks: "Thank you, Henry"."""
        self.sentence.thanked = True
        at = 2 if self._next() is TokenKind.COMMA else 1
        wishes = at > 1 and self.soft_before.get(self.at + at)  # "thanks, show me your teeth" names nobody
        if not wishes and self._next(at) is TokenKind.WORD and self._next(at + 1) in (TokenKind.END, TokenKind.COMMA):
            self.named = self.tokens[self.at + at]

    def _agree(self, token: Token) -> None:
        """Handle "right, take a photo": "right" is not a direction if a command of its own follows."""
        if self.at or self.mode is not Mode.WANTED:
            return
        rest = [t.kind for t in self.tokens[self.at + 2 :]]
        clause = (
            rest[1 : rest.index(TokenKind.AND) if TokenKind.AND in rest else None]
            if rest[:1] == [TokenKind.COMMA]
            else []
        )
        if (
            rest[:1] == [TokenKind.OP]
            or clause[:1] == [TokenKind.OP]
            or (clause[:1] in _VERBS and TokenKind.DIR in clause)
        ):
            self.agreed = self.tokens[self.at + 1]

    def _begin_talk(self, token: Token) -> None:
        if self.cur:
            self.cur.closed = True
        self.mode = Mode.TALK
        self._besides(self._kind(token, RemarkKind.REMARK), token)
        self.sentence.talked = True
        self.sentence.question |= token.value in ("question", "ask")
        self.sentence.somebody = token if token.value == "somebody" else self.sentence.somebody
        self.talk_has_motion = False
        self.talk_doubts = token.value in ("question", "ask")
        self.joined_by_and = False

    def _kind(self, token: Token, otherwise: RemarkKind) -> RemarkKind:
        """Return the kind of remark that begins with this token."""
        soft = self.soft_before.get(self.at, [])
        before = self.tokens[self.at - 1].kind if self.at else TokenKind.END
        helped = before is TokenKind.REQUEST and token.kind is TokenKind.TALK and token.value is None  # 帮他挥手
        for_somebody = helped or any(s.value in (Soft.OBJECT, Soft.TOWARDS, Soft.FOR) for s in soft)  # 给他挥手
        return RemarkKind.WISH if for_somebody else _KINDS.get(token.value, otherwise)

    def _besides(self, kind: RemarkKind, token: Token) -> None:
        """Begin a remark here."""
        self.remark = Remark(kind, token.start, token.end)
        self.sentence.remarks.append(self.remark)

    def _goes_on(self, token: Token) -> None:
        """Extend the current remark to this token."""
        if self.remark is None:
            return
        after = self.soft_after.get(self.at)
        self.remark.end = after[-1].end if after else token.end
        self.remark.beyond |= token.kind is TokenKind.MORE_STOP  # 有人就停，走两米
        self.remark.actions |= self.mode is Mode.TALK and self._runs_on(token)
        if self.mode is Mode.TALK and (self.begins or self.remark.kind is RemarkKind.WISH):
            goes = token.kind is TokenKind.DIR and self._next() in (*_ACTIONS, *AMOUNTS)  # 往前走
            self.remark.actions |= token.kind in _ACTIONS or goes
            self.remark.beyond |= token.kind not in _TELLING
            if token.kind in (TokenKind.HELP, TokenKind.STATUS):
                self.remark.kind = RemarkKind.WISH
            elif token.kind is TokenKind.TALK and self.remark.kind is not RemarkKind.WISH:
                self.remark.kind = self._kind(token, self.remark.kind)

    def _runs_on(self, token: Token) -> bool:
        """Return whether a whole motion or a gesture stands within talk, where a command may have begun without a
        pause: "so I can see better spin ninety degrees".

        A length and a direction may say where a thing is: see `remarks.holds_action`.
        """
        before = self.tokens[self.at - 1].kind if self.at else TokenKind.END
        if token.kind is TokenKind.OP:
            return before is TokenKind.WORD and not self.soft_before.get(self.at)
        if token.kind is TokenKind.DIR:
            return any(kind in AMOUNTS and kind not in _DISTANCES for kind in (before, self._next()))
        if token.kind in (TokenKind.MOVE, TokenKind.TURN):
            return any(kind in AMOUNTS for kind in (self._next(), self._next(2)))
        return False

    def _end_denial(self) -> None:
        if self.mode is Mode.DENIED:
            if not self.denial_used:
                self.sentence.denial_unclear = self.denied
            self.mode = Mode.WANTED
            self.cur = None


HANDLERS = {
    TokenKind.AND: SentenceState._separate,
    TokenKind.COMMA: SentenceState._separate,
    TokenKind.REQUEST: SentenceState._request,
    TokenKind.WISH: SentenceState._wish,
    TokenKind.ASKED: SentenceState._asked,
    TokenKind.REPORT: SentenceState._report,
    TokenKind.CONDITION: SentenceState._condition,
    TokenKind.NOT: SentenceState._not,
    TokenKind.NO: SentenceState._no,
    TokenKind.FIX: SentenceState._fix,
    TokenKind.CANCEL: SentenceState._cancel,
    TokenKind.IS: SentenceState._is,
    TokenKind.EACH: SentenceState._each,
    TokenKind.AGREE: SentenceState._agree,
    TokenKind.THANKS: SentenceState._thanks,
}
