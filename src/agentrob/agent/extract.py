"""From the visible text of a post to what is wanted: asks the mind, and the rules when the mind fails."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass

import structlog

from agentrob.errors import MindError
from agentrob.language.grammar import parse
from agentrob.minds.mind import Listener, Mind
from agentrob.minds.rules import RulesMind
from agentrob.model import Intent, Plan, Understanding, Verdict

#: A mind that takes longer is as good as none.
LIMIT_S = 60.0
_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class Thought:
    """What was made of a post before anything moves: understood by which mind (law 19), and judged how."""

    understanding: Understanding
    mind: str
    verdict: Verdict | None = None


async def extract(mind: Mind, text: str, listener: Listener, history: Sequence[Plan] = ()) -> Thought:
    """Never raises for a mind that fails: then the rules read the post, which can only understand less."""
    try:
        async with asyncio.timeout(LIMIT_S):
            understood = await mind.understand(text, listener, history)
        return Thought(_checked(understood), mind.name)
    except (MindError, TimeoutError) as e:
        _log.warning("mind failed, reading by rules", mind=mind.name, error=str(e) or type(e).__name__)
        rules = RulesMind()
        return Thought(_checked(await rules.understand(text, listener, history)), rules.name)


def warm_up() -> None:
    """Read a sentence with a large numeral once: what that imports takes too long for the first post."""
    parse("一千零五米", (), (), frozenset())


def _checked(understood: Understanding) -> Understanding:
    """A command without steps is nothing to do, and steps without a command are not wanted."""
    if understood.intent is Intent.COMMAND and not understood.plan.steps:
        return Understanding(Intent.ASK_BACK, understood.language, question=understood.question)
    return understood
