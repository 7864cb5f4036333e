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
#: After a clause: it is a question, or it introduces what somebody said.
_LEADS_ON = re.compile(r"\s*[\"'“”‘’「『]?\s*[?？:：]")
_ACTIONS = (TokenKind.MOVE, TokenKind.TURN, TokenKind.OP, TokenKind.BEYOND, TokenKind.AGAIN)
_AMOUNTS = (TokenKind.LENGTH, TokenKind.ANGLE, TokenKind.STEPS, TokenKind.DURATION, TokenKind.NUMBER)
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
    found = [(start, end) for start, end in _clauses(part, locale) if _is_remark(part[start:end], locale)]
    blanked = part
    for start, end in found:
        blanked = blanked[:start] + " " * (end - start) + blanked[end:]
    return blanked, [part[start:end].strip() for start, end in found]


def _clauses(part: str, locale: Locale) -> Iterator[tuple[int, int]]:
    """Yield the clauses between punctuation marks, each split where a purpose or reason begins. Questions and
    what introduces a quotation are passed over."""
    purpose = _compiled(locale.purpose) if locale.purpose else None
    for match in _CLAUSE.finditer(part):
        if not match[0].strip() or _LEADS_ON.match(part, match.end()):
            continue
        begun = purpose.search(match[0]) if purpose else None
        if begun and match[0][: begun.start()].strip():
            yield match.start(), match.start() + begun.start()
            yield match.start() + begun.start(), match.end()
        elif told := _statement_before_action(match[0], locale):
            yield match.start(), match.start() + told
        else:
            yield match.start(), match.end()


def _statement_before_action(clause: str, locale: Locale) -> int:
    """Return the length of a statement that a command follows without a pause; 0 if there is none."""
    if not locale.run_on:
        return 0
    tokens, _ = tokens_of(clause, locale.words)
    first = next((t for t in tokens if t.kind in _ACTIONS and not _is_noun(clause, t, locale)), None)
    if first is None or first.kind is TokenKind.BEYOND:
        return 0
    said = " ".join(clause[: first.start].lower().replace("’", "'").split())
    return first.start if _compiled(locale.run_on).search(said) else 0


def _is_remark(clause: str, locale: Locale) -> bool:
    said = " ".join(clause.lower().replace("’", "'").translate(locale.words.twins).split())
    if not _compiled(locale.remark).search(said):
        return False
    return not _compiled(locale.weighty).search(said) and not _commands(clause, locale)


def _commands(clause: str, locale: Locale) -> bool:
    """Return whether a clause holds words that may command something."""
    tokens, _ = tokens_of(clause, locale.words)
    tokens = with_pictures(with_amounts(tokens, clause))
    kinds = [token.kind for token in tokens]
    if any(kind in _MEANT for kind in kinds):
        return True
    if TokenKind.DIR in kinds and any(kind in _AMOUNTS for kind in kinds):
        return True
    return any(not _is_noun(clause, token, locale) for token in _actions(tokens))


def names_deed(clause: str, locale: Locale) -> bool:
    """Return whether a clause names a deed: an action other than a noun, a request, or a direction with an amount."""
    tokens, _ = tokens_of(clause, locale.words)
    tokens = with_pictures(with_amounts(tokens, clause))
    kinds = [token.kind for token in tokens]
    if TokenKind.REQUEST in kinds or (TokenKind.DIR in kinds and any(kind in _AMOUNTS for kind in kinds)):
        return True
    return any(not _is_noun(clause, token, locale) for token in _actions(tokens))


def _actions(tokens: Sequence[Token]) -> Iterator[Token]:
    return (token for token in tokens if token.kind in _ACTIONS)


def _is_noun(clause: str, token: Token, locale: Locale) -> bool:
    """Return whether a word that may be an action is a noun or an adjective here: "my turn", "is wide open"."""
    return bool(locale.noun_after) and _compiled(locale.noun_after).search(clause[: token.start].lower()) is not None


@cache
def _compiled(pattern: str) -> re.Pattern[str]:
    return re.compile(pattern)
