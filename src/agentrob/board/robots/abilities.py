"""What a robot can do, from the card that its agent published, and examples of commands that it understands."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from itertools import islice
from typing import Any

from agentrob.language.messages.help import examples, eye_examples, play_examples
from agentrob.language.messages.plan_text import operation_name, sentence
from agentrob.model import Capabilities, Direction, Limits, Op, Primitive

#: What models are, in words for people who have never seen one.
ABOUT = {
    "go2": "A robot dog by Unitree, with four legs: 15 kg, 70 cm long. It walks, turns and gestures, and has a camera "
    "in its head.",
    "g1": "A humanoid robot by Unitree, the height of a child: 35 kg, 1.3 m. It walks slowly and gestures with its "
    "arms.",
}
#: A limit beyond this is taken as unknown.
MOST_LIMIT = 1e6
#: How many examples a page shows.
EXAMPLES = 3
_GESTURES = (Op.HEART, Op.CLAP, Op.STRETCH, Op.SHAKE, Op.HELLO, Op.SIT)
_CHAIN = (Op.MOVE, Op.TURN, Op.HELLO)


def capabilities_of(card: Mapping[str, Any]) -> Capabilities | None:
    """What the card says that the robot can do; None if it names no operation. Fields of the wrong type are left out.

    Agents before 0.2 do not name the directions; then all are assumed.
    """
    ops = frozenset(_members(Op, card.get("ops")))
    if not ops:
        return None
    directions = frozenset(_members(Direction, card.get("directions"))) or frozenset(Direction)
    model = card.get("model")
    return Capabilities(
        model=model if isinstance(model, str) else "",
        ops=ops,
        limits=_limits(card.get("limits")),
        move_directions=directions,
        simulated=card.get("simulated") is True,
    )


def op_in_words(op: str) -> str:
    """An operation of a card; one that is unknown here by its own name."""
    return operation_name(Op(op), "en") if op in frozenset(Op) else op.replace("_", " ")[:40]


def _members(kind: type[Op] | type[Direction], told: object) -> Iterator[Any]:
    for word in told[:40] if isinstance(told, (list, tuple)) else ():
        if isinstance(word, str) and word in frozenset(kind):
            yield kind(word)


def _limits(told: object) -> Limits:
    numbers: dict[str, Any] = {}
    for field in fields(Limits):
        value = told.get(field.name) if isinstance(told, Mapping) else None
        if isinstance(value, (int, float)) and not isinstance(value, bool) and 0 < value < MOST_LIMIT:
            numbers[field.name] = int(value) if field.name == "command_steps" else value
    return Limits(**numbers)


def commands_of(can: Capabilities) -> list[str]:
    """Sentences that a robot with these abilities understands: several steps at once, a gesture, a photo, one step of
    each kind."""
    singles = {step.op: step for step in reversed(examples(can))}
    chain = [singles[op] for op in _CHAIN if op in singles] or [singles[op] for op in _GESTURES if op in singles][:2]
    plans: list[Sequence[Primitive]] = [chain] if len(chain) > 1 else []
    plans += [[singles[op]] for op in _GESTURES if op in singles][:1]
    plans += [[singles[Op.GET_FRONT_IMAGE]]] if Op.GET_FRONT_IMAGE in singles else []
    plans += [[step] for step in examples(can)]
    return list(dict.fromkeys(sentence(plan, "en") for plan in plans))


def abilities_of(name: str, can: Capabilities | None, *, sees: bool = False) -> tuple[tuple[str, str], ...]:
    """Each operation of the robot of this name in words, with a post that asks for it; then its routines, the way home,
    and what it can be asked about its camera's picture (`sees`)."""
    if can is None:
        return ()
    singles = {step.op: step for step in reversed(examples(can))}
    known = [op for op in Op if op in singles]
    steps = tuple((op_in_words(op), f"@{name} {sentence([singles[op]], 'en')}") for op in known)
    more = [*play_examples(can, "en"), *(eye_examples(can, "en") if sees else ())]
    return steps + tuple((words.rstrip("?"), f"@{name} {words}") for words in more)


def example_commands(robots: Sequence[tuple[str, Capabilities | None]]) -> tuple[str, ...]:
    """A few posts that these robots (name, abilities) carry out, from each of them in turn."""
    known = [(name, commands_of(can)) for name, can in robots if can]

    def posts() -> Iterator[str]:
        for n in range(EXAMPLES * max(1, len(known))):
            name, sentences = known[n % len(known)]
            if n < len(sentences):
                yield f"@{name} {sentences[n]}"

    return tuple(islice(posts(), EXAMPLES)) if known else ()
