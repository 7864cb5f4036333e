"""A robot's capabilities, from the card that its agent published, and examples of commands that it understands."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from itertools import islice
from typing import Any

from agentrob.language.messages.help import commands, examples, eye_examples, play_examples
from agentrob.language.messages.plan_text import operation_name, sentence
from agentrob.model import BUILT_IN, Capabilities, Direction, Limits, Operation
from agentrob.model.operations.data import operation_of

#: What models are, in words for people who have never seen one.
ABOUT = {
    "go2": "A robot dog by Unitree, with four legs: 15 kg, 70 cm long. It walks, turns and gestures, and has a camera "
    "in its head.",
    "g1": "A humanoid robot by Unitree, the height of a child: 35 kg, 1.3 m. It walks slowly and gestures with its "
    "arms.",
}
#: A limit beyond this is taken as unknown.
MOST_LIMIT = 1e6
#: How many operations of a robot's own a card may declare.
MOST_DECLARED = 20
#: How many examples a page shows.
EXAMPLES = 3


def capabilities_of(card: Mapping[str, Any]) -> Capabilities | None:
    """The capabilities on a card; None if it names no operation. Fields of the wrong type are left out.

    Agents before 0.2 do not name the directions; then all are assumed.
    """
    declared = _declared(card.get("operations"))
    own = {operation.name for operation in declared}
    ops = frozenset(op for op in _words(card.get("ops")) if op in BUILT_IN or op in own)
    if not ops:
        return None
    known = frozenset(Direction(word) for word in _words(card.get("directions")) if word in frozenset(Direction))
    directions = known or frozenset(Direction)
    model = card.get("model")
    return Capabilities(
        model=model if isinstance(model, str) else "",
        ops=ops,
        limits=_limits(card.get("limits")),
        move_directions=directions,
        simulated=card.get("simulated") is True,
        declared=tuple(operation for operation in declared if operation.name in ops),
    )


def op_in_words(op: str, can: Capabilities | None = None) -> str:
    """An operation of a card; one that is unknown here by its own name."""
    operation = (can and can.operation(op)) or BUILT_IN.get(op)
    return operation_name(operation, "en") if operation else op.replace("_", " ")[:40]


def _declared(data: object) -> tuple[Operation, ...]:
    """The operations that the robot declares, without those that are malformed or do not fit."""
    found: dict[str, Operation] = {}
    for one in data[:MOST_DECLARED] if isinstance(data, (list, tuple)) else ():
        try:
            (operation,) = Capabilities("", frozenset(), declared=(operation_of(one),)).declared
        except ValueError:
            continue
        found[operation.name] = operation
    return tuple(found.values())


def _words(data: object) -> Iterator[str]:
    for word in data[:40] if isinstance(data, (list, tuple)) else ():
        if isinstance(word, str):
            yield word


def _limits(data: object) -> Limits:
    numbers: dict[str, Any] = {}
    for field in fields(Limits):
        value = data.get(field.name) if isinstance(data, Mapping) else None
        if isinstance(value, (int, float)) and not isinstance(value, bool) and 0 < value < MOST_LIMIT:
            numbers[field.name] = int(value) if field.name == "command_steps" else value
    return Limits(**numbers)


def abilities_of(name: str, can: Capabilities | None, *, sees: bool = False) -> tuple[tuple[str, str], ...]:
    """Each operation of the robot of this name in words, with a post that asks for it; then its routines, the way home,
    and what it can be asked about its camera's picture (`sees`)."""
    if can is None:
        return ()
    singles = {step.op: step for step in reversed(examples(can))}
    known = [operation.name for operation in can.operations if operation.name in singles]
    steps = tuple((op_in_words(op, can), f"@{name} {sentence([singles[op]], 'en')}") for op in known)
    more = [*play_examples(can, "en"), *(eye_examples(can, "en") if sees else ())]
    return steps + tuple((words.rstrip("?"), f"@{name} {words}") for words in more)


def example_commands(robots: Sequence[tuple[str, Capabilities | None]]) -> tuple[str, ...]:
    """A few posts that these robots (name, abilities) carry out, from each of them in turn."""
    known = [(name, commands(can, "en")) for name, can in robots if can]

    def posts() -> Iterator[str]:
        for n in range(EXAMPLES * max(1, len(known))):
            name, sentences = known[n % len(known)]
            if n < len(sentences):
                yield f"@{name} {sentences[n]}"

    return tuple(islice(posts(), EXAMPLES)) if known else ()
