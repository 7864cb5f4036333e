"""The mind that needs no model: a thin face of the grammar."""

from __future__ import annotations

from collections.abc import Sequence

from agentrob.language.again import Background
from agentrob.language.grammar import parse
from agentrob.minds.mind import Listener
from agentrob.model import Plan, Understanding

#: How fast a robot walks "for two seconds" when no speed is said, if its limits allow.
PACE_MPS = 0.3


class RulesMind:
    """Understands by rules alone: the same post always means the same, within milliseconds."""

    name = "rules"

    async def understand(self, text: str, listener: Listener, history: Sequence[Plan] = ()) -> Understanding:
        can = listener.capabilities
        pace_mps = min(PACE_MPS, can.limits.speed_mps)
        background = Background(tuple(history), pace_mps, listener.step_m, can)
        return parse(text, listener.names, listener.others, can.ops, background)
