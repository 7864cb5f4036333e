"""The declaration of an operation, from which everything else about it follows: the words that ask for it, its limits,
rights, checks, tools and reports (`docs/robots/add-a-robot.md`)."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from agentrob.model.accounts import ActionClass

_NAME = re.compile(r"[a-z][a-z0-9_]{1,39}")
_SLOT = re.compile(r"\{([a-z0-9_]*)\}")
_MOST_PHRASES, _LONGEST_PHRASE, MOST_ARGUMENTS, _MOST_OPTIONS = 60, 60, 4, 20
#: How far the body may be carried by an operation of a class that does not walk, in metres: more is a walk.
TRAVEL_OF_CLASS_M = {ActionClass.PHOTO: 0.1, ActionClass.GESTURE: 0.3}
#: The classes as people who declare operations call them.
CLASS_WORDS = {
    ActionClass.PHOTO: "look", ActionClass.GESTURE: "gesture", ActionClass.MOVE: "move", ActionClass.RISKY: "risky",
}  # fmt: skip


class BaseMotion(StrEnum):
    """How an operation carries the base along a path that its arguments lay down, so that plans can compute with it.

    A translation has `direction` and `distance_m`, and perhaps `speed_mps`: it goes straight, without turning. A
    rotation has `direction`, left or right, and `degrees`: it turns on the spot.
    """

    TRANSLATION = "translation"
    ROTATION = "rotation"


#: What an argument is set to: a number in its unit, or the name of an option.
Value = float | str


class Unit(StrEnum):
    """Units of numbers. `COUNT` is a number without a unit."""

    METRES = "m"
    DEGREES = "deg"
    SECONDS = "s"
    METRES_PER_SECOND = "m/s"
    PERCENT = "%"
    COUNT = "count"


@dataclass(frozen=True, slots=True)
class Number:
    """A number that an operation takes, from `least` to `most` in its unit. Without a `default` it must be given,
    unless it is `optional`."""

    name: str
    unit: Unit
    least: float
    most: float
    default: float | None = None
    optional: bool = False

    def __post_init__(self) -> None:
        check_name(self.name, "argument")
        bounds = (self.least, self.most, *(() if self.default is None else (self.default,)))
        if not all(map(math.isfinite, bounds)) or not self.least <= self.most:
            raise ValueError(f"the bounds of the argument {self.name!r} must be finite, the least one first")
        if not self.allows(self.most if self.default is None else self.default):
            raise ValueError(
                f"the default of the argument {self.name!r} must be from {self.least:g} to {self.most:g} {self.unit}"
            )

    def allows(self, value: Value | None) -> bool:
        """Return whether a value is a number within the bounds; NaN is not."""
        return isinstance(value, (int, float)) and not isinstance(value, bool) and self.least <= value <= self.most

    @property
    def range(self) -> str:
        """The valid values as text: "1 to 10 s"."""
        return f"{self.least:g} to {self.most:g}" + ("" if self.unit is Unit.COUNT else f" {self.unit}")

    @property
    def needed(self) -> bool:
        """Whether a step without it is not complete."""
        return self.default is None and not self.optional


@dataclass(frozen=True, slots=True)
class Option:
    """One of the values of a choice, with the words for it by language, alternatives separated by |."""

    name: str
    words: Mapping[str, str] = field(hash=False)

    def __post_init__(self) -> None:
        check_name(self.name, "option")
        _check_words(self.words, f"the option {self.name!r}")


@dataclass(frozen=True, slots=True)
class Choice:
    """One of a few named values that an operation takes. Without a `default` it must be given."""

    name: str
    options: tuple[Option, ...]
    default: str | None = None

    def __post_init__(self) -> None:
        check_name(self.name, "argument")
        known = [option.name for option in self.options]
        if not known or len(known) > _MOST_OPTIONS or len(set(known)) < len(known):
            raise ValueError(f"the argument {self.name!r} needs 1 to {_MOST_OPTIONS} options of different names")
        if self.default is not None and self.default not in known:
            raise ValueError(f"the default of the argument {self.name!r} must be one of {', '.join(known)}")

    def allows(self, value: Value | None) -> bool:
        """Return whether a value is the name of an option."""
        return any(option.name == value for option in self.options)

    @property
    def range(self) -> str:
        """The valid values as text: "left, right"."""
        return ", ".join(option.name for option in self.options)

    @property
    def needed(self) -> bool:
        """Whether a step without it is not complete."""
        return self.default is None


Argument = Number | Choice


@dataclass(frozen=True, slots=True)
class Quantity:
    """A quantity that a robot measures during an operation. If it has the name of an argument, it is compared with the
    requested value: a difference of more than `tolerance` is a failure, whatever the robot reports (law 18)."""

    name: str
    unit: Unit
    tolerance: float = 0.0

    def __post_init__(self) -> None:
        check_name(self.name, "measured quantity")
        if not self.tolerance >= 0 or not math.isfinite(self.tolerance):
            raise ValueError(f"the tolerance of the quantity {self.name!r} must be a positive number or 0")


@dataclass(frozen=True, slots=True)
class Operation:
    """An ability of a robot.

    `action_class`: what it does, and so who may ask for it: look (`ActionClass.LOOK`: nothing but a sensor moves),
    gesture (the body moves and stays in its place), move (it leaves its place) or risky (it needs the owner's consent
    besides). `words`: the phrases that ask for it by language, alternatives separated by |, the first of which robots
    use themselves; `{name}` in a phrase is where an argument may stand ("吹{seconds}泡泡"), and arguments are
    understood behind a phrase without that. Those of the built-in operations are in the tables of `agentrob.language`.
    `done`: what robots report ("blew bubbles"), by language.

    `free_space_m`: how far from the middle of the body everything must be while it is done, on each side; 0 checks
    nothing. `travel_m`: how far at most it takes the body from its place; the guard ends it where it goes farther, and
    the classes look and gesture allow 0.1 m and 0.3 m. `takes_s`: how long it usually takes, besides its arguments in
    seconds. `time_limit_s`: after this long, and its arguments in seconds, the guard ends it. `measured`: what its
    results measure. `picture`: its result has a picture. `harmless`: no remark beside it makes it dangerous, as with a
    wave; a robot that asks back about remarks does it all the same. `consent`: what the owner's consent to a risky
    operation is called in the configuration, by default its name. `base_motion`: how the built-in walk and
    turn move the base; a robot's own operation has none.

    Raises `ValueError` with a sentence for a declaration that is not possible.
    """

    name: str
    action_class: ActionClass
    words: Mapping[str, str] = field(default_factory=dict, hash=False)
    arguments: tuple[Argument, ...] = ()
    done: Mapping[str, str] = field(default_factory=dict, hash=False)
    free_space_m: float = 0.0
    travel_m: float | None = None
    takes_s: float = 5.0
    time_limit_s: float = 60.0
    measured: tuple[Quantity, ...] = ()
    picture: bool = False
    harmless: bool = False
    consent: str = ""
    base_motion: BaseMotion | None = None

    def __post_init__(self) -> None:
        check_name(self.name, "operation")
        if len(self.arguments) > MOST_ARGUMENTS or len({a.name for a in self.arguments}) < len(self.arguments):
            raise ValueError(f"the operation {self.name!r} may have {MOST_ARGUMENTS} arguments of different names")
        for words in (self.words, self.done):
            _check_words(words, f"the operation {self.name!r}", (a.name for a in self.arguments))
        for what, amount, least in (
            ("free_space_m", self.free_space_m, 0.0), ("travel_m", self.most_travel_m, 0.0),
            ("takes_s", self.takes_s, 0.0), ("time_limit_s", self.time_limit_s, 0.1),
        ):  # fmt: skip
            if not math.isfinite(amount) or amount < least:
                raise ValueError(f"{what} of the operation {self.name!r} must be a number of at least {least:g}")
        most_m = TRAVEL_OF_CLASS_M.get(self.action_class, math.inf)
        if self.most_travel_m > most_m:
            raise ValueError(
                f"the operation {self.name!r} is declared as {CLASS_WORDS[self.action_class]}, which stays within "
                f"{most_m:g} m, and travels {self.most_travel_m:g} m: declare it as move or risky"
            )

    @property
    def moves(self) -> bool:
        """Whether the robot's body moves at all."""
        return self.action_class is not ActionClass.PHOTO

    @property
    def needed_consent(self) -> str:
        """The consent that its owner must have given on a real robot; empty if none is needed."""
        return (self.consent or self.name) if self.action_class is ActionClass.RISKY else ""

    @property
    def most_travel_m(self) -> float:
        """How far at most it takes the body from its place, in metres."""
        return TRAVEL_OF_CLASS_M.get(self.action_class, 0.0) if self.travel_m is None else self.travel_m

    def argument(self, name: str) -> Argument | None:
        return next((argument for argument in self.arguments if argument.name == name), None)

    def phrases(self, language: str) -> tuple[str, ...]:
        """Return the phrases that ask for it in a language, the robot's own first; English ones where it has none."""
        return tuple(filter(None, (p.strip() for p in self.words.get(language, self.words.get("en", "")).split("|"))))

    def objection(self, values: Iterable[tuple[str, Value]]) -> tuple[Argument | None, Value | None] | None:
        """Return the argument that is not as declared, with its value; None if all are.

        (argument, None): it is needed and not set. (None, name): there is no argument of this name.
        """
        given = dict(values)
        if unknown := [name for name in given if self.argument(name) is None]:
            return None, unknown[0]
        for argument in self.arguments:
            value = given.get(argument.name)
            if (value is None and argument.needed) or (value is not None and not argument.allows(value)):
                return argument, value
        return None

    def complete(self, values: Mapping[str, Value]) -> tuple[tuple[str, Value], ...]:
        """Return values as the arguments of a step, in the order of the declaration, with the defaults."""
        settled = {a.name: values.get(a.name, a.default) for a in self.arguments}
        return tuple((k, v if isinstance(v, str) else float(v)) for k, v in settled.items() if v is not None)

    def seconds_asked(self, values: Iterable[tuple[str, Value]]) -> float:
        """Return the sum of its arguments in seconds."""
        units = {argument.name: argument.unit for argument in self.arguments if isinstance(argument, Number)}
        return sum(float(v) for name, v in values if units.get(name) is Unit.SECONDS and isinstance(v, (int, float)))


def check_name(name: str, what: str) -> None:
    """Raise `ValueError` for what is not the name of an operation, argument, option or quantity."""
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise ValueError(f"{name!r} is not a valid name ({what}): use 2 to 40 of a-z, 0-9 and _, a letter first")


def _check_words(words: Mapping[str, str], whose: str, slots: Iterable[str] = ()) -> None:
    known = frozenset(slots)
    if words and "en" not in words:
        raise ValueError(f"{whose} needs words in English (en) besides {', '.join(sorted(words))}")
    for language, given in words.items():
        phrases = [phrase.strip() for phrase in given.split("|")]
        if not given.isprintable() or not all(phrases) or len(phrases) > _MOST_PHRASES:
            raise ValueError(f"{whose} needs 1 to {_MOST_PHRASES} printable phrases in {language!r}, separated by |")
        for phrase in phrases:
            if len(phrase) > _LONGEST_PHRASE:
                raise ValueError(f"a phrase of {whose} is longer than {_LONGEST_PHRASE} characters: {phrase!r}")
            if unknown := [slot for slot in _SLOT.findall(phrase) if slot not in known]:
                names = ", ".join(sorted(known)) or "none"
                raise ValueError(f"{whose} has no argument {unknown[0]!r} for {phrase!r}; its arguments: {names}")
