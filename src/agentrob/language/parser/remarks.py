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
from functools import cache

from agentrob.language.locale import Locale
from agentrob.language.parser.amounts import with_amounts, with_pictures
from agentrob.language.parser.lexicon import Token, TokenKind, tokens_of

_CLAUSE = re.compile(r"(?:[^,.!?;:…—，。！？；：、()（）\n]|(?<=\d)[.,:](?=\d)|(?<=\w)\.(?=\w))+")
_SENTENCE_END = re.compile(r"[.!?;\n]")
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
_AMOUNTS = (TokenKind.LENGTH, TokenKind.ANGLE, TokenKind.STEPS, TokenKind.DURATION, TokenKind.NUMBER)
#: Longer clauses are not split, so that parsing stays fast.
_LONGEST_RUN_ON = 200
#: Of a longer clause only the first verbs are tried.
_MOST_BEGINNINGS = 4
#: Tokens that ask for something, or change what is asked.
_MEANT = (
    TokenKind.REQUEST,
    TokenKind.WISH,
    TokenKind.CONDITION,
    TokenKind.FIX,
    TokenKind.CANCEL,
    TokenKind.HELP,
    TokenKind.EACH,
    TokenKind.MORE_STOP,
    TokenKind.GO_AHEAD,
    TokenKind.TIMES,
    TokenKind.MORE_TIMES,
    TokenKind.SPEED,
    TokenKind.SLOW,
    TokenKind.FASTER,
)


def without_remarks(part: str, locale: Locale) -> tuple[str, list[str]]:
    """Blank out the remarks of a post; also return them, in order."""
    if not locale.remark:
        return part, []
    spans = list(clauses_of(part, locale))
    found = [
        (start, end)
        for start, end in spans
        if _is_remark(part[start:end], locale) or _is_aside(part, start, end, locale)
    ]
    if any(_says_where(part, end, spans, locale) for _, end in found):
        return part, []
    blanked = part
    for start, end in found:
        if introduces := _LEADS_ON.match(part, end):
            blanked = blanked[:start] + " " * (introduces.end() - start) + blanked[introduces.end() :]
        blanked = blanked[:start] + " " * (end - start) + blanked[end:]
    return blanked, [part[start:end].strip() for start, end in found]


def holds_action(words: str, locale: Locale, *, asked: bool = False) -> bool:
    """Return whether a remark holds an action, which may be meant: "it's sunny make a heart".

    In a question only a direction with an amount counts: "is fine and 5 feet forward". Elsewhere that says where a
    thing is, which the screen judges, unless the direction is never said of a place: "it's fun ten feet forward".
    """
    tokens = _tokens(words, locale)
    kinds = [token.kind for token in tokens if not _is_noun(words, token, locale)]
    if TokenKind.DIR in kinds and any(kind in _AMOUNTS for kind in kinds):
        sides = (words[t.start : t.end].lower() for t in tokens if t.kind is TokenKind.DIR)
        if asked or any(side in locale.never_where.split("|") for side in sides):
            return True
    return not asked and any(kind in (TokenKind.MOVE, TokenKind.TURN, TokenKind.OP) for kind in kinds)


def unsettles(words: str, locale: Locale) -> bool:
    """Return whether a remark in words of the grammar may change what a command means."""
    return _compiled(locale.unsettling).search(_plain(words, locale)) is not None


def _says_where(part: str, end: int, spans: Sequence[tuple[int, int]], locale: Locale) -> bool:
    """Return whether a clause without a verb follows, which may say where: "there is a wall, five metres ahead"."""
    following = next(((start, stop) for start, stop in spans if start >= end), None)
    if following is None or not locale.run_on or _LEADS_ON.match(part, end):
        return False
    clause = part[slice(*following)]
    tokens = _tokens(clause, locale)
    kinds = [token.kind for token in tokens]
    sides = [clause[token.start : token.end].lower() for token in tokens if token.kind is TokenKind.DIR]
    if TokenKind.ANGLE in kinds or any(side in locale.never_where.split("|") for side in sides):
        return False
    verbless = TokenKind.DIR in kinds and not any(kind in _BEGINNING for kind in kinds)
    sentence_ends = _SENTENCE_END.search(part, end, following[0]) is not None
    return verbless and (not sentence_ends or kinds[0] in _AMOUNTS)


def clauses_of(part: str, locale: Locale) -> Iterator[tuple[int, int]]:
    """Yield the clauses between punctuation marks, each split where a purpose or a reason begins, or where a statement
    and a command meet. Questions and what introduces a quotation are passed over."""
    purpose = _compiled(locale.purpose) if locale.purpose else None
    for match in _CLAUSE.finditer(part):
        if not match[0].strip() or _ASKED.match(part, match.end()):
            continue
        if _LEADS_ON.match(part, match.end()) and not _introduces(match[0], locale):
            continue
        begun = purpose.search(match[0].lower()) if purpose else None
        at = begun.start() if begun and match[0][: begun.start()].strip() else _meeting(match[0], locale)
        if at:
            yield match.start(), match.start() + at
            yield match.start() + at, match.end()
        else:
            yield match.start(), match.end()


def _meeting(clause: str, locale: Locale) -> int:
    """Return where a statement and a command meet without a pause, in either order; 0 if nowhere."""
    if not locale.run_on or len(clause) > _LONGEST_RUN_ON:
        return 0
    tokens = _tokens(clause, locale)
    first = 0
    for found in [at for at in range(len(tokens)) if _begins_command(clause, tokens, at, locale)][:_MOST_BEGINNINGS]:
        first = first or tokens[found].end
        at = found
        while at and _belongs(clause, tokens[at - 1], locale):
            at -= 1
        if at and tokens[at - 1].kind is TokenKind.CONDITION:  # "what a day after sending me a picture"
            return 0
        before = clause[: tokens[at].start]
        if before.strip() and _compiled(locale.run_on).search(_plain(before, locale)):
            return tokens[at].start
    if not first:
        return 0
    for begun in _compiled(locale.begins).finditer(clause.lower(), first):
        statement = clause[begun.start() :]
        if _compiled(locale.open_end).search(_plain(clause[: begun.start()], locale)):
            continue  # "go forward once the light is green"
        if any(token.kind is TokenKind.DIR for token in _tokens(statement, locale)):
            continue  # "move one metre to the left beforehand"
        if _compiled(locale.run_on).search(_plain(statement, locale)) and _is_remark(statement, locale):
            return begun.start()
    return 0


def _belongs(clause: str, token: Token, locale: Locale) -> bool:
    """Return whether a token before the first word of a command may belong to it: "… and turn", "… slowly walk"."""
    acts = token.kind in _ACTIONS
    return token.kind in _BEFORE_BEGINNING and not (acts and _is_noun(clause, token, locale))


def _begins_command(clause: str, tokens: Sequence[Token], at: int, locale: Locale) -> bool:
    """Return whether a command may begin with this token: a verb, or a direction that is never said of a place."""
    token, following = tokens[at], tokens[at + 1].kind if at + 1 < len(tokens) else TokenKind.END
    if token.kind is TokenKind.DIR:
        if at and tokens[at - 1].kind in _ACTIONS:
            return False
        return following in _AMOUNTS and clause[token.start : token.end].lower() in locale.never_where.split("|")
    return token.kind in _BEGINNING and not _is_noun(clause, token, locale)


def _tokens(clause: str, locale: Locale) -> list[Token]:
    tokens = with_pictures(with_amounts(tokens_of(clause, locale.words)[0], clause))
    return locale.phrases(tokens, clause) if locale.phrases else tokens


def _plain(words: str, locale: Locale) -> str:
    return " ".join(words.lower().replace("’", "'").translate(locale.words.twins).split())


def _introduces(clause: str, locale: Locale) -> bool:
    """Return whether a clause before a colon introduces the command, and not the words of somebody else."""
    return _compiled(locale.introduction).search(_plain(clause, locale)) is not None


def _is_remark(clause: str, locale: Locale) -> bool:
    said = _plain(clause, locale)
    if not _compiled(locale.remark).search(said) and not _compiled(locale.introduction).search(said):
        return False
    aside = _compiled(locale.aside)
    if _compiled(locale.weighty).search(aside.sub(" ", said)):
        return False
    clause = aside.sub(
        lambda found: " " * len(found[0]), clause.lower().replace("’", "'").translate(locale.words.twins)
    )
    fragment = _compiled(locale.fragment).search(said) is not None
    return not _commands(clause, locale) and not (fragment and _has_side(clause, locale))


def _is_aside(part: str, start: int, end: int, locale: Locale) -> bool:
    """Return whether a clause stands in parentheses and holds only words that ask for nothing: "(much uglier)"."""
    if part[start - 1 : start] not in _OPENING or part[end : end + 1] not in _CLOSING or not start:
        return False
    clause = part[start:end]
    known = any(token.kind not in (TokenKind.WORD, TokenKind.SOFT) or token.value for token in _tokens(clause, locale))
    return not known and not _compiled(locale.weighty).search(_plain(clause, locale))


def _has_side(clause: str, locale: Locale) -> bool:
    """Return whether a clause names a direction, other than as its first word: "right, my friends"."""
    tokens = _tokens(clause, locale)
    return any(t.kind in _SIDES for t in tokens[1:]) or [t.kind for t in tokens] in ([TokenKind.DIR], [TokenKind.BACK])


def _commands(clause: str, locale: Locale) -> bool:
    """Return whether a clause holds words that may command something."""
    tokens = _tokens(clause, locale)
    kinds = [token.kind for token in tokens]
    if any(token.kind in _MEANT and token.value != "after" for token in tokens):  # "… after the night" is a time
        return True
    if TokenKind.DIR in kinds and any(kind in _AMOUNTS for kind in kinds):
        return True
    return any(not _is_noun(clause, token, locale) for token in _actions(tokens))


def names_deed(clause: str, locale: Locale) -> bool:
    """Return whether a clause names a deed: an action other than a noun, a request, or a direction with an amount."""
    tokens = _tokens(clause, locale)
    kinds = [token.kind for token in tokens]
    if TokenKind.REQUEST in kinds or (TokenKind.DIR in kinds and any(kind in _AMOUNTS for kind in kinds)):
        return True
    return any(not _is_noun(clause, token, locale) for token in _actions(tokens))


def _actions(tokens: Sequence[Token]) -> Iterator[Token]:
    return (token for token in tokens if token.kind in _ACTIONS)


def _is_noun(clause: str, token: Token, locale: Locale) -> bool:
    """Return whether a word that may be an action is a noun or an adjective here: "my turn", "is wide open"."""
    if " " in clause[token.start : token.end]:  # in "filming this turn around" the turn is commanded
        return False
    return bool(locale.noun_after) and _compiled(locale.noun_after).search(clause[: token.start].lower()) is not None


@cache
def _compiled(pattern: str) -> re.Pattern[str]:
    return re.compile(pattern)
