"""Operations that a robot declares, where a model reads posts: the schema with their names, and the words as evidence.

A model only names such an operation. Its arguments are read by the grammar from the clause that the model quotes.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, create_model

from agentrob.language.operations.words import phrases_of
from agentrob.language.parser.grammar import parse
from agentrob.language.parser.repetition import ParseContext
from agentrob.language.registry import known
from agentrob.minds.extraction.evidence import Evidence, EvidenceKind
from agentrob.minds.extraction.schema import ExtractedStep, Wants
from agentrob.model import Capabilities, Operation, Primitive
from agentrob.model.operations.built_in import named

_SLOT = re.compile(r"\\\{[a-z0-9_]+\\\}")


def wants_of(can: Capabilities) -> type[Wants]:
    """Return the schema of a model's answer for this robot: with the names of the operations that it declares."""
    return _schema(tuple(operation.name for operation in can.operations)) if can.declared else Wants


@lru_cache(maxsize=64)
def _schema(names: tuple[str, ...]) -> type[Wants]:
    action: Any = Annotated[Literal[names], AfterValidator(named)]
    step: Any = create_model("ExtractedStep", __base__=ExtractedStep, action=(action, ...))
    steps: Any = Annotated[tuple[step, ...], Field(max_length=20)]
    return create_model("Wants", __base__=Wants, steps=(steps, ()))


def with_declared(mentions: Sequence[Evidence], text: str, can: Capabilities | None) -> tuple[Evidence, ...]:
    """Return what a text says, with the phrases of the robot's own operations as actions; the words in them say nothing
    else, apart from amounts."""
    if can is None or not can.declared:
        return tuple(mentions)
    found: list[Evidence] = []
    for operation, pattern in _patterns(can.declared):
        for match in pattern.finditer(text):
            if not any(match.start() < one.end and one.start < match.end() for one in found):
                found.append(Evidence(EvidenceKind.ACTION, match.start(), match.end(), op=operation))
    kept = [m for m in mentions if m.kind in _AMOUNTS or not any(f.start <= m.start and m.end <= f.end for f in found)]
    return tuple(sorted([*kept, *found], key=lambda m: (m.start, m.end)))


_AMOUNTS = (EvidenceKind.LENGTH, EvidenceKind.ANGLE, EvidenceKind.SPEED, EvidenceKind.NUMBER)


@lru_cache(maxsize=64)
def _patterns(declared: tuple[Operation, ...]) -> tuple[tuple[str, re.Pattern[str]], ...]:
    """Return each phrase as a pattern, the longest first; an amount may stand where a number belongs."""
    said = {
        (phrase, operation.name) for operation in declared for language in known()
        for phrase in phrases_of(operation, language)
    }  # fmt: skip
    found = []
    for phrase, name in sorted(said, key=lambda one: (-len(one[0]), one)):
        words = _SLOT.sub(r"[^,.;!?，。；！？]{1,24}?", re.escape(phrase))
        found.append((name, re.compile(rf"(?<![a-z']){words}(?![a-z'])" if phrase.isascii() else words, re.IGNORECASE)))
    return tuple(found)


def declared_step(action: str, clause: str, can: Capabilities | None) -> Primitive | None:
    """Return the step of a robot's own operation that a clause asks for, by the grammar; None if it asks for less or
    for more."""
    if can is None:
        return None
    steps = parse(clause, (), (), can.ops, ParseContext(can=can)).plan.steps
    return steps[0] if steps and all(step.op == action and step == steps[0] for step in steps) else None
