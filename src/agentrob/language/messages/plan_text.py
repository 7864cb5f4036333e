"""Render steps and plans as text: as commands that the grammar reads back, and as labels for reports."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import groupby

from agentrob.language.messages.catalog import can_say, say
from agentrob.model import BUILT_IN, Choice, Language, Number, Operation, Plan, Primitive, Unit
from agentrob.model.operations.declaration import Argument, Value

_OUTLINED = 10
_MEASURED = {
    Unit.METRES: "{:.2f} m", Unit.DEGREES: "{:.1f}°", Unit.SECONDS: "{:.1f} s", Unit.METRES_PER_SECOND: "{:.2f} m/s",
    Unit.PERCENT: "{:.0f} %", Unit.COUNT: "{:g}",
}  # fmt: skip
_SLOT = re.compile(r"\s*\{[a-z0-9_]*\}\s*")
_NAMED = re.compile(r"\{([a-z0-9_]+)\}")


def sentence(plan: Plan | Sequence[Primitive], language: Language) -> str:
    """Return all steps in order, with equal ones combined ("wave 2 times"); empty for an empty plan."""
    steps = plan.steps if isinstance(plan, Plan) else plan
    parts = []
    for step, run in groupby(steps):
        times = len(list(run))
        one = step_sentence(step, language)
        parts.append(one if times == 1 else say("step.times", language, step=one, times=times))
    return say("step.joint", language).join(parts)


def outline(steps: Sequence[Primitive], language: Language) -> str:
    """Return the same for at most ten steps."""
    return sentence(steps[:_OUTLINED], language) + (" …" if len(steps) > _OUTLINED else "")


@lru_cache(maxsize=64)
def operation_names(operations: Sequence[Operation], language: Language) -> str:
    """Return the names of what a robot with these operations can do: "walk, turn, wave"."""
    return say("list.joint", language).join(operation_name(operation, language) for operation in operations)


def operation_name(operation: Operation, language: Language) -> str:
    """Return an operation as a verb without amounts: "walk", "take a photo"."""
    if can_say(key := f"verb.{operation.name}") or can_say(key := f"step.{operation.name}"):
        return say(key, language)
    return _in_words(operation, language)


def example_of(operation: Operation, said: Mapping[str, Value] | None = None) -> Primitive:
    """Return a step of an operation that does not walk: with what was `said`, or else its defaults, or else an amount
    in the middle of its bounds or its first option."""
    settled = {a.name: _usual(a) for a in operation.arguments if a.needed} | dict(said or {})
    declared = None if BUILT_IN.get(operation.name) == operation else operation
    return Primitive(operation.name, arguments=operation.complete(settled), declared=declared)


def _usual(argument: Argument) -> Value:
    if isinstance(argument, Choice):
        return argument.options[0].name
    middle = (argument.least + argument.most) / 2
    return next((n for n in (float(f"{middle:.1g}"), float(round(middle))) if argument.allows(n)), middle)


def range_of(argument: Argument, language: Language) -> str:
    """Return what an argument may be set to, in words: "1 to 10 s", "red, blue"."""
    if isinstance(argument, Choice):
        return say("list.joint", language).join(_option(argument, option.name, language) for option in argument.options)
    amount = amount_of(argument.most, argument.unit, language)
    return say("argument.range", language, least=_number(argument.least), most=amount)


def amount_of(value: float, unit: Unit, language: Language) -> str:
    """Return an amount with its unit, as reports and limits show it: "3 s", "1.5 m", "90°", "50 %"."""
    return say(f"amount.{unit.name.lower()}", language, value=_number(value))


def measured_text(value: float, unit: Unit) -> str:
    """Return a measured value with its unit, as reports show it in every language."""
    return _MEASURED[unit].format(value)


def _in_words(operation: Operation, language: Language) -> str:
    """Return the robot's own phrase for an operation that it declares."""
    return _SLOT.sub(" ", next(iter(operation.phrases(language)), operation.name.replace("_", " "))).strip()


def _declared_sentence(step: Primitive, language: Language) -> str:
    """Return a step of an operation that a robot declares as a command: "blow bubbles for 3 seconds"."""
    operation = step.operation
    phrase = next(iter(operation.phrases(language)), operation.name.replace("_", " "))
    within = {a.name for a in operation.arguments if isinstance(a, Choice) and f"{{{a.name}}}" in phrase}
    for name in within:
        phrase = phrase.replace(f"{{{name}}}", _option_said(operation, name, step, language))
    words = _SLOT.sub(" ", phrase).strip()
    for name, value in step.arguments:
        argument = operation.argument(name)
        if name in within:
            continue
        if isinstance(argument, Choice):
            words = say("argument.option", language, step=words, value=_option(argument, str(value), language))
        elif isinstance(argument, Number) and isinstance(value, int | float):
            key = f"argument.{argument.unit.name.lower()}"
            words = say(key, language, step=words, value=_number(float(value)))
        else:
            words = f"{words} {value}"
    return words


def done_sentence(step: Primitive, language: Language) -> str:
    """Return what the declaration of a step's operation says when it is done, with the arguments that it names: "went
    to the kitchen". Empty if it says nothing."""
    operation = step.operation
    said = operation.done.get(language, operation.done.get("en", ""))

    def argument(slot: re.Match[str]) -> str:
        named, value = operation.argument(slot[1]), step.value(slot[1])
        if isinstance(named, Number) and isinstance(value, int | float):
            return amount_of(float(value), named.unit, language)
        return _option_said(operation, slot[1], step, language)

    return _NAMED.sub(argument, said)


def _option_said(operation: Operation, name: str, step: Primitive, language: Language) -> str:
    choice, said = operation.argument(name), step.value(name)
    return _option(choice, str(said), language) if isinstance(choice, Choice) and said is not None else ""


def _option(choice: Choice, name: str, language: Language) -> str:
    words = next((option.words for option in choice.options if option.name == name), {"en": name})
    return words.get(language, words.get("en", name)).split("|")[0].strip()


def step_sentence(step: Primitive, language: Language) -> str:
    """Return one step as a command that the grammar reads as this step: "walk forward 1.5 m"."""
    at_speed = "_at" if step.translates and step.speed_mps is not None else ""
    return _render(f"step.{step.op}{at_speed}", step, language)


def step_label(step: Primitive, language: Language) -> str:
    """Return one step as reports show it: "walk forward 1 m", "turn left 90°"."""
    label = _render(f"label.{step.op}", step, language)
    return say("label.speed", language, step=label, speed=f"{step.speed_mps:g}") if step.speed_mps else label


def _render(key: str, step: Primitive, language: Language) -> str:
    """Fill a step's amounts into the sentence `key`; show an operation without a sentence by its name."""
    if not can_say(key):
        return _declared_sentence(step, language)
    direction = say(f"direction.{step.direction}", language) if step.direction else ""
    amounts = {"metres": step.distance_m, "degrees": step.degrees, "speed": step.speed_mps}
    return say(key, language, direction=direction, **{name: _number(amount) for name, amount in amounts.items()})


def _number(value: float | None) -> str:
    """Format a number without exponent or trailing zeros, to four decimals."""
    return f"{value:.4f}".rstrip("0").rstrip(".") if value else "0"
