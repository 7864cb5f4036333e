"""What a screened command may use up at most (law 7)."""

from __future__ import annotations

from collections.abc import Sequence

from agentrob.model import ActionResult, Capabilities, Mandate, Plan, Primitive


def mandate_of(plan: Plan, capabilities: Capabilities) -> Mandate:
    """The mandate of a screened plan."""
    return Mandate()


def within(mandate: Mandate, used: Sequence[ActionResult], step: Primitive) -> str | None:
    """Why `step` would exceed the mandate after `used`, or None when it is within."""
    return "not built"
