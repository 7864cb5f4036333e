"""The mind that needs no model: a thin face of the grammar."""

from __future__ import annotations

from collections.abc import Sequence

from agentrob.language.grammar import parse
from agentrob.minds.mind import Listener
from agentrob.model import Plan, Understanding


class RulesMind:
    """Understands by rules alone: the same post always means the same, within milliseconds."""

    name = "rules"

    async def understand(self, text: str, listener: Listener, history: Sequence[Plan] = ()) -> Understanding:
        return parse(text, listener.names, listener.others, listener.capabilities.ops)
