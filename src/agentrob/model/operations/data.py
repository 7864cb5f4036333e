"""Declarations of operations as JSON data and back: over the driver's API, and on the card of a robot."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from agentrob.model.accounts import ActionClass
from agentrob.model.operations.declaration import (
    Argument,
    BaseMotion,
    Choice,
    Number,
    Operation,
    Option,
    Quantity,
    Unit,
)


def as_data(operation: Operation) -> dict[str, Any]:
    """Return the declaration as JSON data, without what is not set."""
    optional = {
        "done": dict(operation.done), "arguments": [_argument_data(a) for a in operation.arguments],
        "free_space_m": operation.free_space_m, "picture": operation.picture,
        "harmless": operation.harmless, "consent": operation.consent, "base_motion": operation.base_motion,
        "measured": [{"name": q.name, "unit": str(q.unit), "tolerance": q.tolerance} for q in operation.measured],
    }  # fmt: skip
    return {
        "name": operation.name, "class": str(operation.action_class), "words": dict(operation.words),
        "takes_s": operation.takes_s, "time_limit_s": operation.time_limit_s,
        **({} if operation.travel_m is None else {"travel_m": operation.travel_m}),
        **{key: value for key, value in optional.items() if value},
    }  # fmt: skip


def operation_of(data: object) -> Operation:
    """Read a declaration. Raises `ValueError` with a sentence for one that is malformed; unknown keys are ignored."""
    told = _mapping(data, "a declaration of an operation")
    try:
        return Operation(
            _text(told, "name"), ActionClass(_text(told, "class")), _words(told.get("words")),
            tuple(_argument(a) for a in _list(told, "arguments")), _words(told.get("done")),
            _number_or(told, "free_space_m", 0.0), _number(told, "travel_m"),
            _number_or(told, "takes_s", 5.0), _number_or(told, "time_limit_s", 60.0),
            tuple(_quantity(q) for q in _list(told, "measured")), told.get("picture") is True,
            told.get("harmless") is True, _text(told, "consent") if "consent" in told else "",
            BaseMotion(_text(told, "base_motion")) if "base_motion" in told else None,
        )  # fmt: skip
    except (TypeError, KeyError) as e:
        raise ValueError(f"a declaration of an operation lacks {e}") from None


def _argument_data(argument: Argument) -> dict[str, Any]:
    default = {} if argument.default is None else {"default": argument.default}
    if isinstance(argument, Choice):
        options = [{"name": option.name, "words": dict(option.words)} for option in argument.options]
        return {"name": argument.name, "options": options, **default}
    bounds = {"least": argument.least, "most": argument.most, **({"optional": True} if argument.optional else {})}
    return {"name": argument.name, "unit": str(argument.unit), **bounds, **default}


def _argument(data: object) -> Argument:
    told = _mapping(data, "an argument")
    default = told.get("default")
    if "options" in told:
        options = tuple(
            Option(_text(one, "name"), _words(one["words"]))
            for one in (_mapping(option, "an option") for option in _list(told, "options"))
        )
        return Choice(_text(told, "name"), options, default if isinstance(default, str) else None)
    unit, least, most = Unit(_text(told, "unit")), _number(told, "least"), _number(told, "most")
    if least is None or most is None:
        raise ValueError("a number needs its bounds, least and most")
    optional = told.get("optional") is True
    return Number(_text(told, "name"), unit, least, most, _number(told, "default"), optional)


def _quantity(data: object) -> Quantity:
    told = _mapping(data, "a quantity")
    return Quantity(_text(told, "name"), Unit(_text(told, "unit")), _number_or(told, "tolerance", 0.0))


def _mapping(data: object, what: str) -> Mapping[str, Any]:
    if not isinstance(data, Mapping):
        raise ValueError(f"{what} must be an object")
    return data


def _words(data: object) -> dict[str, str]:
    words = _mapping(data or {}, "words")
    if not all(isinstance(key, str) and isinstance(value, str) for key, value in words.items()):
        raise ValueError("words must be strings by language")
    return dict(words)


def _text(told: Mapping[str, Any], key: str) -> str:
    value = told[key]
    if not isinstance(value, str):
        raise ValueError(f"{key} must be a string")
    return value


def _list(told: Mapping[str, Any], key: str) -> list[object]:
    value = told.get(key, [])
    if not isinstance(value, (list, tuple)):
        raise ValueError(f"{key} must be a list")
    return list(value)


def _number(told: Mapping[str, Any], key: str) -> float | None:
    value = told.get(key)
    if isinstance(value, bool) or not isinstance(value, (int, float, type(None))):
        raise ValueError(f"{key} must be a number")
    return None if value is None else float(value)


def _number_or(told: Mapping[str, Any], key: str, default: float) -> float:
    value = _number(told, key)
    return default if value is None else value
