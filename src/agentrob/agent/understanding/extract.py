"""Read the visible text of a post: by the configured mind, or by the rules if the mind fails."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import structlog

from agentrob.errors import MindError
from agentrob.language.goal import Goal
from agentrob.language.joint.reading import joint_command
from agentrob.language.parser.grammar import parse, small_talk_of
from agentrob.minds.extraction.mind import ModelMind
from agentrob.minds.llm.errors import ModelError
from agentrob.minds.protocol import Addressee, ManagedMind, Mind, Reading, read
from agentrob.minds.rules import RulesMind
from agentrob.minds.safety_review import SafetyReview
from agentrob.minds.usage import Usage
from agentrob.model import Intent, Plan, Schedule, Understanding, Verdict

#: Posts that need large numerals, or that are read again as idioms, lists and remarks.
WARM_UP = ("一千零五米", "1. do a full turn and finish with a wave, my dog loves it", "最后伸个懒腰，我家狗可喜欢了")
#: How long a mind may take; configured models have their own limits.
LIMIT_S = 60.0
#: Why a mind did not answer, besides the words of `minds.llm.errors.ErrorKind`: it failed and did not say how; the post
#: may not move anything any more (stopped, edited, …); its account is over its limits, so it is refused anyway.
FAILED, OVER, RATE = "failed", "over", "rate"
_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class Assessment:
    """How a post was understood, and by which mind, and how it was judged, before anything moves (law 19).

    `mind` is who read it in the end; `fallback` says why that was not the mind of the configuration (a word of
    `ErrorKind`, or one of those above), empty when it was. `usage` is one entry per question to a model,
    failed ones included. `screened` is what a model had against the command, None where none was asked; `goal` is what
    needs eyes, and then the plan has only the steps that it names. `schedule` is when the command is to be carried out,
    None for at once; `untimed` is then the text of the post without the time. `previews`: the command is only
    rehearsed, and moves nothing.
    """

    understanding: Understanding
    mind: str
    verdict: Verdict | None = None
    usage: tuple[Usage, ...] = ()
    fallback: str = ""
    screened: SafetyReview | None = None
    goal: Goal | None = None
    schedule: Schedule | None = None
    untimed: str = ""
    previews: bool = False


async def extract(mind: Mind, text: str, addressee: Addressee, history: Sequence[Plan] = ()) -> Assessment:
    """Read a post. If the mind fails, the rules read it, which can only understand less."""
    try:
        async with asyncio.timeout(mind.limit_s + 1.0 if isinstance(mind, ModelMind) else LIMIT_S):
            return _assessment(await read(mind, text, addressee, history))
    except (MindError, TimeoutError) as e:
        _log.warning("mind failed, reading by rules", mind=mind.name, error=str(e) or type(e).__name__)
        fallback = "timeout" if isinstance(e, TimeoutError) else FAILED
        if isinstance(e, ModelError):
            return await by_rules(text, addressee, history, e.kind, e.usage)
        return await by_rules(text, addressee, history, fallback)


async def by_rules(
    text: str, addressee: Addressee, history: Sequence[Plan], fallback: str = "", usage: Sequence[Usage] = ()
) -> Assessment:
    """Read a post by the rules; `fallback` says why the configured mind did not."""
    rules = RulesMind()
    understood = await rules.understand(text, addressee, history)
    return _assessment(Reading(understood, rules.name, tuple(usage), fallback))


async def prepare(mind: Mind) -> None:
    """Load the mind's library, and what the rules import and compile at the first use, so that the first post does not
    wait for it, and no stop meanwhile."""
    await asyncio.to_thread(warm_up_rules)
    if isinstance(mind, ManagedMind):
        await mind.prepare()


@cache
def warm_up_rules() -> None:
    """Import and compile what the rules need, once in a process. Blocks for about half a second."""
    for text in WARM_UP:
        parse(text, (), (), frozenset())
        small_talk_of(text, (), ())
    joint_command("@rex wave, then @bot wave")


def _assessment(reading: Reading) -> Assessment:
    understood = _checked(reading.understanding)
    return Assessment(understood, reading.mind, usage=tuple(reading.usage), fallback=reading.fallback)


def _checked(understood: Understanding) -> Understanding:
    """Ask back for a command without steps, and drop the steps of anything else."""
    if understood.intent is Intent.COMMAND and not understood.plan.steps:
        return Understanding(Intent.ASK_BACK, understood.language, question=understood.question)
    return understood
