"""From the visible text of a post to what is wanted: asks the mind, and the rules when the mind fails."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass

import structlog

from agentrob.errors import MindError
from agentrob.minds.mind import Listener, Mind
from agentrob.minds.rules import RulesMind
from agentrob.model import Intent, Plan, Understanding

#: A mind that takes longer is as good as none.
LIMIT_S = 60.0
_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class Extracted:
    """What was understood, and by which mind (law 19)."""

    understanding: Understanding
    mind: str


async def extract(mind: Mind, text: str, listener: Listener, history: Sequence[Plan] = ()) -> Extracted:
    """Never raises for a mind that fails: then the rules read the post, which can only understand less."""
    try:
        async with asyncio.timeout(LIMIT_S):
            understood = await mind.understand(text, listener, history)
        return Extracted(_checked(understood), mind.name)
    except (MindError, TimeoutError) as e:
        _log.warning("mind failed, reading by rules", mind=mind.name, error=str(e) or type(e).__name__)
        rules = RulesMind()
        return Extracted(_checked(await rules.understand(text, listener, history)), rules.name)


def _checked(understood: Understanding) -> Understanding:
    """A command without steps is nothing to do, and steps without a command are not wanted."""
    if understood.intent is Intent.COMMAND and not understood.plan.steps:
        return Understanding(Intent.ASK_BACK, understood.language, question=understood.question)
    return understood
