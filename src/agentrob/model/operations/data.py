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
    mapping = _mapping(data, "a declaration of an operation")
    try:
        return Operation(
            _text(mapping, "name"), ActionClass(_text(mapping, "class")), _words(mapping.get("words")),
            tuple(_argument(a) for a in _list(mapping, "arguments")), _words(mapping.get("done")),
            _number_or(mapping, "free_space_m", 0.0), _number(mapping, "travel_m"),
            _number_or(mapping, "takes_s", 5.0), _number_or(mapping, "time_limit_s", 60.0),
            tuple(_quantity(q) for q in _list(mapping, "measured")), mapping.get("picture") is True,
            mapping.get("harmless") is True, _text(mapping, "consent") if "consent" in mapping else "",
            BaseMotion(_text(mapping, "base_motion")) if "base_motion" in mapping else None,
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
    mapping = _mapping(data, "an argument")
    default = mapping.get("default")
    if "options" in mapping:
        options = tuple(
            Option(_text(one, "name"), _words(one["words"]))
            for one in (_mapping(option, "an option") for option in _list(mapping, "options"))
        )
        return Choice(_text(mapping, "name"), options, default if isinstance(default, str) else None)
    unit, least, most = Unit(_text(mapping, "unit")), _number(mapping, "least"), _number(mapping, "most")
    if least is None or most is None:
        raise ValueError("a number needs its bounds, least and most")
    optional = mapping.get("optional") is True
    return Number(_text(mapping, "name"), unit, least, most, _number(mapping, "default"), optional)


def _quantity(data: object) -> Quantity:
    mapping = _mapping(data, "a quantity")
    return Quantity(_text(mapping, "name"), Unit(_text(mapping, "unit")), _number_or(mapping, "tolerance", 0.0))


def _mapping(data: object, what: str) -> Mapping[str, Any]:
    if not isinstance(data, Mapping):
        raise ValueError(f"{what} must be an object")
    return data


def _words(data: object) -> dict[str, str]:
    words = _mapping(data or {}, "words")
    if not all(isinstance(key, str) and isinstance(value, str) for key, value in words.items()):
        raise ValueError("words must be strings by language")
    return dict(words)


def _text(mapping: Mapping[str, Any], key: str) -> str:
    value = mapping[key]
    if not isinstance(value, str):
        raise ValueError(f"{key} must be a string")
    return value


def _list(mapping: Mapping[str, Any], key: str) -> list[object]:
    value = mapping.get(key, [])
    if not isinstance(value, (list, tuple)):
        raise ValueError(f"{key} must be a list")
    return list(value)


def _number(mapping: Mapping[str, Any], key: str) -> float | None:
    value = mapping.get(key)
    if isinstance(value, bool) or not isinstance(value, (int, float, type(None))):
        raise ValueError(f"{key} must be a number")
    return None if value is None else float(value)


def _number_or(mapping: Mapping[str, Any], key: str, default: float) -> float:
    value = _number(mapping, key)
    return default if value is None else value
