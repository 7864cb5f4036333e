"""Run one text through a mind and the screen."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from itertools import takewhile

from agentrob.config.load import Config
from agentrob.errors import MindError
from agentrob.evals.understanding import never_answered, one_by_one
from agentrob.language.registry import language_of
from agentrob.language.visible_text import mentions, visible_text
from agentrob.minds.extraction.trial import reviewed_verdict
from agentrob.minds.protocol import Addressee, ManagedMind, Mind, read
from agentrob.minds.usage import Usage
from agentrob.model import Account, Capabilities, Decision, Intent, Limits, Plan, Role, Verdict
from agentrob.screening.audience import text_for_robot
from agentrob.screening.screen import harm_in_words, prepare, screen
from agentrob.screening.second_opinion import with_opinion
from agentrob.semantic.harm_classifier import HarmDetector
from agentrob.wiring import app

#: No limits, so that a dangerous command is judged by its meaning and not stopped by its length.
LIFTED = Limits(10, 3600, 100, 3600, 100, 3600, 100)
#: The author of every post may command.
AUTHOR = Account("1", "author", role=Role.OPERATOR)
NAME = "robot"


@dataclass(frozen=True, slots=True)
class Outcome:
    """`kind`: executed, refused (by a rule), asked (not understood, or in doubt) or ignored (not read as a command).

    `rule` is the rule that refused or asked, `said` the answer, `plan` what moves or would have moved. `usage` is what
    models cost, `failed` why the requested mind did not read or review it. `suspected` is what the harm classifier says
    about the words, None if it was not asked.
    """

    kind: str
    rule: str = ""
    said: str = ""
    plan: Plan = Plan()
    usage: tuple[Usage, ...] = ()
    failed: str = ""
    suspected: bool | None = None


def capabilities_of(robot: str) -> Capabilities:
    """Return what a kind of robot (`go2`, `g1`) can do, simulated and without limits."""
    return replace(app.capabilities_of(robot), limits=LIFTED, simulated=True)


def outcomes(
    posts: Sequence[tuple[str, str]], mind: str, robot: str, config: Config | None = None, classifier: bool = False
) -> list[Outcome]:
    """Return the outcome of each post (body, description of the scene or empty), as with an agent's usual settings.

    The mind reads it, the rules judge it, and the model reviews what they allow. With `classifier` the harm classifier
    judges every text, and what it suspects is not executed. Returns fewer outcomes when interrupted. Raises
    `ConfigError` for an unknown mind or robot or a missing classifier, `MindError` if the mind answered no question.
    """
    prepare()
    found = asyncio.run(_all(posts, app.make_mind(mind, config), capabilities_of(robot)))
    if not classifier:
        return found
    with closing(HarmDetector()) as detector:
        return [_with_opinion(one, _suspected(detector, body)) for one, (body, _) in zip(found, posts, strict=False)]


def _suspected(detector: HarmDetector, body: str) -> bool:
    text = visible_text(body)
    return detector.suspects(text, language_of(text))


def _with_opinion(outcome: Outcome, suspected: bool) -> Outcome:
    if outcome.kind == "executed":
        verdict = with_opinion(Verdict(Decision.ALLOW, outcome.rule), suspected, outcome.plan, "en")
        judged = _judged(verdict, outcome.plan)
        outcome = replace(outcome, kind=judged.kind, rule=judged.rule, said=judged.said)
    return replace(outcome, suspected=suspected)


async def _all(posts: Sequence[tuple[str, str]], mind: Mind, can: Capabilities) -> list[Outcome]:
    if isinstance(mind, ManagedMind):
        await mind.prepare()
    try:
        known = await one_by_one(posts, lambda post: _one(*post, mind, can))
    finally:
        if isinstance(mind, ManagedMind):
            await mind.close()
    found = [known[post] for post in takewhile(known.__contains__, posts)]
    if why := never_answered([outcome.usage for outcome in found]):
        raise MindError(f"the mind {mind.name!r} answered no question ({why}); see: agentrob mind check {mind.name}")
    return found


async def _one(body: str, scene: str, mind: Mind, can: Capabilities) -> Outcome:
    text = visible_text(body)
    others = tuple(name for name in mentions(text) if name != NAME)
    addressee = Addressee((NAME,), others, can)
    reading = await read(mind, text, addressee)
    found, usage, failed = reading.understanding, reading.usage, reading.fallback
    if found.intent is Intent.COMMAND:
        verdict = screen(
            found.plan, text=text, author=AUTHOR, capabilities=can, language=found.language, scene=scene,
            part=text_for_robot(text, (NAME,), others),
        )  # fmt: skip
        verdict, screened = await reviewed_verdict(mind, reading, verdict, text, addressee, scene)
        if screened is not None:
            usage, failed = (*usage, *screened.usage), failed or screened.failed
        outcome = _judged(verdict, found.plan)
    elif found.intent is not Intent.ASK_BACK:
        outcome = Outcome("ignored", said=str(found.intent))
    elif refused := harm_in_words(text, scene, found.language):
        outcome = _judged(refused, Plan())
    else:
        outcome = Outcome("asked", said=found.question)
    return replace(outcome, usage=usage, failed=failed)


def _judged(verdict: Verdict, plan: Plan) -> Outcome:
    kinds = {Decision.ALLOW: "executed", Decision.ASK_BACK: "asked"}
    return Outcome(kinds.get(verdict.decision, "refused"), verdict.rule, verdict.reason, plan)


def unanswered_line(found: Sequence[Outcome], mind: str) -> list[str]:
    """Return a line that says how often a mind did not answer itself, so that the figures are not only its own."""
    why = Counter(outcome.failed for outcome in found if outcome.failed)
    reasons = ", ".join(f"{kind} {count}" for kind, count in why.most_common())
    return [f"{why.total()} posts that {mind} did not answer ({reasons}): other minds read them"] if why else []
