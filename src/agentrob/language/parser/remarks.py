"""Find the clauses of a post that are remarks: statements, purposes and reasons that ask nothing of the robot.

The grammar knows the words of commands; what people say beside a command is in words that no table holds ("the cat is
in another room", 前方很空旷). A clause is a remark only by its form: it has a subject and a verb, or begins with a word
of purpose or reason. It is none if it holds an action, a direction with an amount, a request, a condition or a
correction, or if it may change what the command means (`Locale.weighty`). Such clauses stay with the grammar, which
asks back. The screen judges the whole post, remarks included.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import cache, cached_property
from itertools import pairwise

from agentrob.language.locale import Locale
from agentrob.language.parser.lexicon import Token, TokenKind
from agentrob.language.remarks.classifier import Confidence, begins_as_order, joins_order

_CLAUSE = re.compile(r"(?:[^,.!?;:…—，。！？；：、()（）\n]|(?<=\d)[.,:](?=\d)|(?<=\w)\.(?=\w))+")
_SENTENCE_END = re.compile(r"[.!?;。！？；\n]")
#: After a clause: it is a question, or it introduces what somebody said.
_ASKED = re.compile(r"\s*[\"'“”‘’「『]?\s*[?？]")
_LEADS_ON = re.compile(r"\s*[\"'“”‘’「『]?\s*[:：]")
_OPENING, _CLOSING = ("(", "（"), (")", "）")
_ACTIONS = (TokenKind.MOVE, TokenKind.TURN, TokenKind.OP, TokenKind.BEYOND, TokenKind.AGAIN)
#: Tokens with which a command may begin after a statement.
_BEGINNING = (
    TokenKind.MOVE,
    TokenKind.TURN,
    TokenKind.OP,
    TokenKind.SHOW,
    TokenKind.REQUEST,
    TokenKind.GO_AHEAD,
)
#: Tokens that belong to them: "… and turn", "… slowly walk".
_BEFORE_BEGINNING = (
    TokenKind.AND,
    TokenKind.COMMA,
    TokenKind.SLOW,
    TokenKind.FASTER,
    TokenKind.MOVE,
    TokenKind.TURN,
    TokenKind.OP,
)
_SIDES = (TokenKind.DIR, TokenKind.BACK, TokenKind.AGREE)
_MEASURES = (TokenKind.LENGTH, TokenKind.ANGLE, TokenKind.STEPS)
_AMOUNTS = (TokenKind.LENGTH, TokenKind.ANGLE, TokenKind.STEPS, TokenKind.DURATION, TokenKind.NUMBER)
#: Tokens that ask for nothing.
_PLAIN = (TokenKind.WORD, TokenKind.SOFT, TokenKind.TALK, TokenKind.TALK_START)
#: Longer clauses are not split, so that parsing stays fast.
_LONGEST_RUN_ON = 200
#: Of a longer clause only the first verbs are tried.
_MOST_BEGINNINGS = 4
_NAMED_ACTIONS = (TokenKind.MOVE, TokenKind.TURN, TokenKind.OP)
#: Tokens that ask for something or take it back; a clause that holds one is left out only if it certainly is harmless.
_ASKED_FOR = (
    TokenKind.REQUEST,
    TokenKind.FIX,
    TokenKind.CANCEL,
    TokenKind.MORE_STOP,
    TokenKind.GO_AHEAD,
    TokenKind.HELP,
    TokenKind.AGAIN,
    TokenKind.WISH,
)
#: Other tokens that may ask for something, or change what is asked.
_MEANT = (
    TokenKind.EACH,
    TokenKind.TIMES,
    TokenKind.MORE_TIMES,
    TokenKind.SPEED,
    TokenKind.SLOW,
    TokenKind.FASTER,
)


class Clauses(dict[str, "Clause"]):
    """The clauses of one post by their words; each is read once."""

    def __init__(self, known: Locale) -> None:
        super().__init__()
        self.known = known

    def __missing__(self, words: str) -> Clause:
        clause = self[words] = Clause(words, self.known)
        return clause


class Clause:
    """The possible readings of a clause: a remark, an action, or a statement and a command without a pause between
    them."""

    def __init__(self, words: str, known: Locale) -> None:
        self.words = words
        self.known = known

    @cached_property
    def tokens(self) -> Sequence[Token]:
        return self.known.tokens(self.words)

    @cached_property
    def plain(self) -> str:
        return " ".join(self._straight.split())

    @property
    def _straight(self) -> str:
        return self.words.lower().replace("’", "'").translate(self.known.words.twins)

    @cached_property
    def is_remark(self) -> bool:
        known, said = self.known, self.plain
        if known.says_path_is_clear(said):
            return True
        formed = self.introduces or known.has_form_of_remark(said)
        if formed and _found(known.fragment, said) and self.without_asides.has_side:
            return False
        if self.introduces:
            return self._asks_nothing
        if not formed and (self.has_amount or self.has_side or joins_order(said)):
            return False
        needed = max(self._needed_beside_words, Confidence.NONE if formed else self._needed_without_form)
        return self.harmless >= max(needed, Confidence.POSSIBLE)

    @cached_property
    def harmless(self) -> Confidence:
        """How surely it may be left out beside a command, by its words."""
        return self.known.harmless(self.plain)

    @property
    def _needed_without_form(self) -> Confidence:
        if begins_as_order(self.plain):
            return Confidence.NEVER
        return Confidence.LIKELY if self.known.reads_as_statement(self.plain) else Confidence.CERTAIN

    @property
    def _needed_beside_words(self) -> Confidence:
        """How sure one must be although it holds words that may ask for something or change what is asked."""
        if joins_order(self.plain):
            return Confidence.NEVER
        said = self.without_asides
        weighs = _found(self.known.weighty, said.plain)
        if said.needed_to_leave_out is Confidence.NONE and not weighs:
            return Confidence.NONE
        measured = any(token.kind in _MEASURES for token in self.tokens)
        if weighs and (measured or _found(self.known.crucial, said.plain)):
            return Confidence.NEVER
        grave = weighs and _found(self.known.grave, said.plain)
        needed = Confidence.CERTAIN if grave else Confidence.STRONG if weighs else Confidence.NONE
        return max(said.needed_to_leave_out, needed)

    @property
    def may_be_statement(self) -> bool:
        """Whether a clause in a form that no pattern knows may be a remark: it names no direction, amount or action."""
        return not self.has_amount and not self.has_side and self._asks_nothing

    @property
    def goes_on(self) -> bool:
        """Whether it may go on about the remark before it: the grammar knows none of its words."""
        known = all(token.kind in _PLAIN and not token.value for token in self.tokens)
        asks = joins_order(self.plain) or not self.may_be_statement
        return known and not asks and self.known.may_be_talk(self.plain)

    @property
    def _asks_nothing(self) -> bool:
        weighs = self._weighs(self.known.weighty, _compiled(self.known.aside).sub(" ", self.plain))
        return not weighs and not self.without_asides.commands

    @cached_property
    def introduces(self) -> bool:
        """Whether it introduces the command before a colon, and not the words of somebody else."""
        return _found(self.known.introduction, self.plain)

    @property
    def may_lead_on(self) -> bool:
        """Whether it may stand before a colon and a command: it introduces it, or is surely harmless."""
        quotes = not self.known.quotes or _found(self.known.quotes, self.plain)
        return self.introduces or (not quotes and self.harmless >= Confidence.STRONG and self.is_remark)

    @property
    def weighs(self) -> bool:
        """Whether it may change the meaning or the danger of a command."""
        return self._weighs(self.known.weighty, self.plain)

    @property
    def unsettles(self) -> bool:
        """Whether it may change what a command means, if the grammar knows its words."""
        if not _found(self.known.unsettling, self.plain):
            return False
        return self.commands or self.harmless < Confidence.CERTAIN or _found(self.known.crucial, self.plain)

    def _weighs(self, words: str, said: str) -> bool:
        """Return whether any of these words weighs."""
        if not _found(words, said):
            return False
        needed = Confidence.CERTAIN if _found(self.known.grave, said) else Confidence.STRONG
        return self.introduces or self.harmless < needed or _found(self.known.crucial, said)

    @property
    def has_side(self) -> bool:
        """Whether it names a direction, other than as its first word: "right, my friends"."""
        kinds = [token.kind for token in self.tokens]
        return any(kind in _SIDES for kind in kinds[1:]) or kinds in ([TokenKind.DIR], [TokenKind.BACK])

    @property
    def has_amount(self) -> bool:
        """Whether it names a distance, an angle, a duration or a number of steps."""
        return any(token.kind in _AMOUNTS and token.kind is not TokenKind.NUMBER for token in self.tokens)

    @property
    def commands(self) -> bool:
        """Whether it holds words that may command something."""
        return self.needed_to_leave_out > Confidence.NONE

    @cached_property
    def needed_to_leave_out(self) -> Confidence:
        """How sure one must be that it is harmless, to leave it out although its words may ask for something."""
        kinds = {token.kind for token in self.tokens}
        if self.directs or (TokenKind.PICTURE in kinds and kinds & {TokenKind.WISH, TokenKind.REQUEST}):
            return Confidence.NEVER
        return max((self._needed_for(at, token) for at, token in enumerate(self.tokens)), default=Confidence.NONE)

    def _needed_for(self, at: int, token: Token) -> Confidence:
        if token.value == "after" or (token.kind in _ACTIONS and self.is_noun(token)):  # "after the night": a time
            return Confidence.NONE
        if token.kind in _NAMED_ACTIONS:
            reported = (at > 0 and self._follows_subject(token)) or self._looks(token)
            return Confidence.STRONG if reported and not _found(self.known.weighty, self.plain) else Confidence.NEVER
        if token.kind is TokenKind.CONDITION:
            return Confidence.CERTAIN if at else Confidence.NEVER
        if token.kind in _ASKED_FOR:
            return Confidence.CERTAIN
        if token.kind in _MEANT:
            return Confidence.STRONG
        return Confidence.LIKELY if token.kind in (TokenKind.BEYOND, TokenKind.PICTURE) else Confidence.NONE

    def _follows_subject(self, token: Token) -> bool:
        """Return whether the word before a verb is its subject or governs it: "I drive", "we used to dance"."""
        return _found(self.known.after_subject, self._straight[: token.start])

    def _looks(self, token: Token) -> bool:
        return self.words[token.start : token.end].lower() in self.known.looks.split("|")

    @property
    def names_action(self) -> bool:
        """Whether it names an action by a verb, a request, or a direction with an amount."""
        return any(token.kind is TokenKind.REQUEST for token in self.tokens) or self.directs or self._acts

    @cached_property
    def without_asides(self) -> Clause:
        """The clause without words that only look like an action or a condition: 好看, "wondering if"."""
        words = _compiled(self.known.aside).sub(lambda found: " " * len(found[0]), self._straight)
        return Clause(words, self.known)

    @property
    def directs(self) -> bool:
        """Whether it names a direction with an amount."""
        kinds = [token.kind for token in self.tokens]
        return TokenKind.DIR in kinds and any(kind in _AMOUNTS for kind in kinds)

    @property
    def _acts(self) -> bool:
        return any(token.kind in _ACTIONS and not self.is_noun(token) for token in self.tokens)

    def holds_action(self, *, asked: bool = False) -> bool:
        """Return whether a remark holds an action, which may be meant: "it's sunny make a heart".

        In a question only a direction with an amount counts: "is fine and 5 feet forward". Elsewhere that says where a
        thing is, which the screen judges, unless the direction is never said of a place: "it's fun ten feet forward".
        """
        kinds = [token.kind for token in self.tokens if not self.is_noun(token)]
        directs = TokenKind.DIR in kinds and any(kind in _AMOUNTS for kind in kinds)
        if directs and (asked or any(self.is_never_where(token) for token in self.tokens)):
            return True
        return not asked and any(kind in (TokenKind.MOVE, TokenKind.TURN, TokenKind.OP) for kind in kinds)

    def is_noun(self, token: Token) -> bool:
        """Return whether a word that may be an action is a noun or an adjective here: "my turn", "is wide open"."""
        if " " in self.words[token.start : token.end]:  # in "filming this turn around" the turn is commanded
            return False
        return bool(self.known.noun_after) and _found(self.known.noun_after, self.words[: token.start].lower())

    def is_never_where(self, token: Token) -> bool:
        """Return whether a token is a direction that is never said of a place."""
        side = self.words[token.start : token.end].lower()
        return token.kind is TokenKind.DIR and side in self.known.never_where.split("|")

    @cached_property
    def meeting(self) -> int:
        """Where a statement and a command meet without a pause, in either order; 0 if nowhere."""
        known = self.known
        if not known.run_on or len(self.words) > _LONGEST_RUN_ON:
            return 0
        tokens = self.tokens
        masked = self.without_asides.words
        beginnings = [
            at for at, token in enumerate(tokens) if not masked[token.start].isspace() and self._begins_command(at)
        ][:_MOST_BEGINNINGS]
        for at in map(self._first_of_command, beginnings):
            if at and tokens[at - 1].kind is TokenKind.CONDITION:  # "what a day after sending me a picture"
                return 0
            before = self.words[: tokens[at].start]
            if before.strip() and _found(known.run_on, _plain(before, known)):
                return tokens[at].start
        return self._statement_after(tokens[beginnings[0]].end) if beginnings else 0

    def _statement_after(self, first: int) -> int:
        """Return where a statement begins after the first word of a command; 0 if none does."""
        known = self.known
        for begun in _compiled(known.begins).finditer(self.words.lower(), first):
            statement = Clause(self.words[begun.start() :], known)
            if _found(known.open_end, _plain(self.words[: begun.start()], known)):
                continue  # "go forward once the light is green"
            if any(token.kind is TokenKind.DIR for token in statement.tokens):
                continue  # "move one metre to the left beforehand"
            if _found(known.run_on, statement.plain) and statement.is_remark:
                return begun.start()
        return 0

    def _first_of_command(self, at: int) -> int:
        while at and self._belongs(self.tokens[at - 1]):
            at -= 1
        return at

    def _belongs(self, token: Token) -> bool:
        """Return whether a token before the first word of a command may belong to it: "… and turn", "… slowly walk"."""
        return token.kind in _BEFORE_BEGINNING and not (token.kind in _ACTIONS and self.is_noun(token))

    def _begins_command(self, at: int) -> bool:
        """Return whether a command may begin here: with a verb, or with a direction that is never said of a place."""
        token, following = self.tokens[at], self.tokens[at + 1].kind if at + 1 < len(self.tokens) else TokenKind.END
        if token.kind is TokenKind.DIR:
            after_action = at > 0 and self.tokens[at - 1].kind in _ACTIONS
            return not after_action and following in _AMOUNTS and self.is_never_where(token)
        return token.kind in _BEGINNING and not self.is_noun(token)


def without_remarks(part: str, clauses: Clauses) -> tuple[str, list[str]]:
    """Blank out the remarks of a post; also return them, in order."""
    if not clauses.known.remark:
        return part, []
    spans = list(_spans(part, clauses))
    found = [
        (start, end)
        for start, end in spans
        if clauses[part[start:end]].is_remark or _is_aside(part, start, end, clauses)
    ]
    found = _with_what_follows(part, spans, found, clauses)
    if any(_says_where(part, end, spans, clauses) for _, end in found):
        return part, []
    blanked = part
    for start, end in found:
        if introduces := _LEADS_ON.match(part, end):
            blanked = blanked[:start] + " " * (introduces.end() - start) + blanked[introduces.end() :]
        blanked = blanked[:start] + " " * (end - start) + blanked[end:]
    return blanked, [part[start:end].strip() for start, end in found]


def _with_what_follows(
    part: str, spans: Sequence[tuple[int, int]], found: Sequence[tuple[int, int]], clauses: Clauses
) -> list[tuple[int, int]]:
    """Return the remarks with the clauses that go on about them: "I read it all, very clear"."""
    remarks = set(found)
    for before, span in pairwise(spans):
        if (
            before in remarks
            and not _SENTENCE_END.search(part, before[1], span[0])
            and clauses[part[slice(*span)]].goes_on
        ):
            remarks.add(span)
    return [span for span in spans if span in remarks]


def clauses_of(part: str, clauses: Clauses) -> list[str]:
    """Return the words of the clauses of a post, as remarks are looked for in them."""
    return [part[start:end] for start, end in _spans(part, clauses)]


def _spans(part: str, clauses: Clauses) -> Iterator[tuple[int, int]]:
    """Yield the clauses between punctuation marks, each split where a purpose or a reason begins, or where a statement
    and a command meet. Questions and what introduces a quotation are passed over."""
    purpose = clauses.known.purpose
    for match in _CLAUSE.finditer(part):
        clause = clauses[match[0]]
        if not match[0].strip() or _ASKED.match(part, match.end()):
            continue
        if _LEADS_ON.match(part, match.end()) and not clause.may_lead_on:
            continue
        begun = _compiled(purpose).search(match[0].lower()) if purpose else None
        at = begun.start() if begun and match[0][: begun.start()].strip() else clause.meeting
        if at:
            yield match.start(), match.start() + at
            yield match.start() + at, match.end()
        else:
            yield match.start(), match.end()


def _says_where(part: str, end: int, spans: Sequence[tuple[int, int]], clauses: Clauses) -> bool:
    """Return whether a clause without a verb follows, which may say where: "there is a wall, five metres ahead"."""
    following = next(((start, stop) for start, stop in spans if start >= end), None)
    if following is None or not clauses.known.run_on or _LEADS_ON.match(part, end):
        return False
    clause = clauses[part[slice(*following)]]
    kinds = [token.kind for token in clause.tokens]
    if TokenKind.ANGLE in kinds or any(clause.is_never_where(token) for token in clause.tokens):
        return False
    verbless = TokenKind.DIR in kinds and not any(kind in _BEGINNING for kind in kinds)
    sentence_ends = _SENTENCE_END.search(part, end, following[0]) is not None
    return verbless and (not sentence_ends or kinds[0] in _AMOUNTS)


def _is_aside(part: str, start: int, end: int, clauses: Clauses) -> bool:
    """Return whether a clause stands in parentheses and holds only words that ask for nothing: "(much uglier)"."""
    if part[start - 1 : start] not in _OPENING or part[end : end + 1] not in _CLOSING or not start:
        return False
    clause = clauses[part[start:end]]
    known = any(token.kind not in (TokenKind.WORD, TokenKind.SOFT) or token.value for token in clause.tokens)
    return not known and not clause.weighs


def _plain(words: str, known: Locale) -> str:
    return " ".join(words.lower().replace("’", "'").translate(known.words.twins).split())


def _found(pattern: str, text: str) -> bool:
    return _compiled(pattern).search(text) is not None


@cache
def _compiled(pattern: str) -> re.Pattern[str]:
    return re.compile(pattern)
