"""Say what a routine consists of, or which sizes and counts fit a robot's limits."""

from __future__ import annotations

from collections.abc import Sequence

from agentrob.language.messages.catalog import can_say, say
from agentrob.language.routines import Routine, largest_size_m, most_times, sides_of
from agentrob.model import Capabilities, Language, Primitive


def routine_note(routine: Routine, steps: Sequence[Primitive], times: int, language: Language, words: str) -> str:
    """Return the note that says which steps a routine was taken as."""
    sides, side_m = sides_of(steps)
    values = {"words": words, "sides": sides // times, "side": f"{side_m:.4g}", "times": times}
    key = f"note.routine.{_key(routine)}"
    return say(f"{key}.times" if times > 1 and can_say(f"{key}.times") else key, language, **values)


def unfit(routine: Routine, can: Capabilities, language: Language, words: str, size_m: float | None, times: int) -> str:
    """Return why a routine cannot be done like this, and what could be."""
    if times > 1 and (most := most_times(routine, can, size_m)):
        return say("ask.routine.times", language, words=words, times=most)
    if routine.has_size and (largest := largest_size_m(routine, can)):
        return say(f"ask.routine.{routine}", language, words=words, metres=f"{largest:g}")
    limits = can.limits
    return say(
        "ask.routine.not_here", language, words=words, steps=limits.command_steps, seconds=f"{limits.command_s:g}",
        metres=f"{limits.command_m:g}",
    )  # fmt: skip


def _key(routine: Routine) -> str:
    return "circle" if routine is Routine.CIRCLE_RADIUS else str(routine)
