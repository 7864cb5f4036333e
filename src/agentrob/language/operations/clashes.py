"""Refuse the words of an operation that a robot declares where they already mean something, or are not understood.

A phrase that stops, approves or asks for something else today keeps its meaning: a robot cannot take it away.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from datetime import UTC, datetime

from agentrob.errors import ConfigError
from agentrob.language.approval import approval_in
from agentrob.language.messages.plan_text import amount_of, example_of, sentence
from agentrob.language.operations.words import phrases_of
from agentrob.language.parser.grammar import parse, talk_topic_of
from agentrob.language.parser.lexicon import TokenKind, pieces_of, tokens_of
from agentrob.language.parser.repetition import ParseContext
from agentrob.language.registry import DEFAULT, known, locale
from agentrob.language.schedule.reading import timed_text
from agentrob.language.stop.at_rest import stop_intent
from agentrob.language.stop.while_moving import stop_while_moving
from agentrob.model import BUILT_IN, Capabilities, Intent, Language, Number, Op, Operation, Primitive

_SLOT = re.compile(r"\{([a-z0-9_]+)\}")
_BUILT_IN = frozenset(Op)
_NOTHING_YET = (Intent.NOTHING, Intent.ASK_BACK)
#: A phrase needs at least one word that means nothing yet, or what robots cannot do: "open" in "open the gripper".
_FREE = {TokenKind.BEYOND, TokenKind.WORD}
#: Turning goes left or right, so "look up" and "look down" are free for a robot with a neck.
_FREE_TOGETHER = {TokenKind.TURN, TokenKind.ALONG}
#: What joins or ends clauses.
_JOINTS = {TokenKind.AND, TokenKind.COMMA, TokenKind.END}
_SOME_TIME = datetime(2026, 1, 5, 12, tzinfo=UTC)


def refuse_clashes(can: Capabilities) -> None:
    """Raise `ConfigError` with a sentence if a declaration takes words that mean something else, or cannot be said."""
    for clash in clashes(can):
        raise ConfigError(f"the robot {can.model!r} cannot start: {clash}")


def clashes(can: Capabilities) -> Iterator[str]:
    """Yield a sentence for each phrase of a robot's own operations that cannot be used."""
    for language in known():
        said = [one for one in can.declared if language in one.words or (language == DEFAULT and one.words)]
        owners: dict[str, str] = {}
        for operation in said:
            for phrase in phrases_of(operation, language):
                other = owners.setdefault(_plain(phrase), operation.name)
                if other != operation.name:
                    yield f"the operations {other!r} and {operation.name!r} are both asked for by “{phrase}”"
        for operation in said:
            for phrase in phrases_of(operation, language):
                plain = _filled(phrase, operation, language)
                why = _meaning(plain, language, operation) or _misunderstood(plain, operation, can, language)
                if why:
                    yield f"the operation {operation.name!r} is asked for by “{phrase}”, {why}; choose other words"
            if why := _misunderstood("", operation, can, language):
                yield f"the operation {operation.name!r} is said as “{_example(operation, language)}”, {why}"


def _plain(phrase: str) -> str:
    return " ".join(piece.text for piece in pieces_of(_SLOT.sub(" ", phrase)))


def _filled(phrase: str, operation: Operation, language: Language) -> str:
    """Return a phrase with an amount where a number belongs: "blow 3 s bubbles"."""
    step = example_of(operation)

    def amount(slot: re.Match[str]) -> str:
        argument, value = operation.argument(slot[1]), step.value(slot[1])
        shown = isinstance(argument, Number) and isinstance(value, float)
        return amount_of(value, argument.unit, language) if shown and isinstance(argument, Number) else slot[0]

    return _SLOT.sub(amount, phrase)


def _meaning(phrase: str, language: Language, operation: Operation) -> str:
    """Return what a phrase means without the declaration; empty if nothing."""
    if stop_intent(phrase) or stop_while_moving(phrase):
        return "which stops robots"
    if approval_in(phrase):
        return "which approves or denies commands"
    understood = parse(phrase, (), (), _BUILT_IN)
    steps = understood.plan.steps
    if understood.intent is Intent.COMMAND and any(step.op != operation.name for step in steps):
        return f"which already means “{sentence(steps, language)}”"
    if understood.intent not in (*_NOTHING_YET, Intent.COMMAND):
        return f"which already asks for {understood.intent}"
    if topic := talk_topic_of(phrase, (), ()):
        return f"which robots already answer (talk about “{topic}”)"
    if timed_text(phrase, _SOME_TIME, "UTC") is not None:
        return "which already says when something is to be done"
    kinds = {token.kind for token in tokens_of(phrase, locale(language).words)[0]}
    if operation.name not in BUILT_IN and (kinds & _JOINTS or not (kinds & _FREE or kinds >= _FREE_TOGETHER)):
        names = ", ".join(sorted(kinds - _FREE))
        return f"whose words all mean something else already ({names})"
    return ""


def _misunderstood(phrase: str, operation: Operation, can: Capabilities, language: Language) -> str:
    """Return how a phrase, or without one the robot's own sentence, is not understood as the operation."""
    text = phrase or _example(operation, language)
    understood = parse(text, (), (), can.ops, ParseContext(can=can))
    steps = understood.plan.steps
    needed = any(argument.needed for argument in operation.arguments)
    if len(steps) == 1 and steps[0].op == operation.name:
        return "" if phrase or steps[0] == example_of(operation) else "which is not understood as it is meant"
    if phrase and needed and understood.intent is Intent.ASK_BACK:
        return ""  # its argument is asked for
    return "which is not understood as that"


def _example(operation: Operation, language: Language) -> str:
    step: Primitive = example_of(operation)
    return sentence([step], language)
