"""Add a classifier's suspicion to a verdict: it may make the robot ask, and never refuses or allows (law 7). Pure."""

from __future__ import annotations

import re

from agentrob.language.messages.catalog import QUOTE_CHARS, quote, say
from agentrob.language.messages.plan_text import sentence
from agentrob.model import Decision, Language, Plan, Verdict

RULE = "opinion.harm"
_NOISE = re.compile(r"\W+")


def with_opinion(by_rules: Verdict, suspected: bool | None, plan: Plan | None, language: Language) -> Verdict:
    """Return the rules' verdict, or a question if they allow what a classifier suspects of harm.

    `suspected` is None if there is no opinion. The question offers the plan in our own words, and `is_own_words` says
    that no opinion is asked about those: a false alarm costs one more post. `plan` is None for a goal that needs
    eyes. A command that waits for an approval goes to a person anyway; everything else does not move.
    """
    if by_rules.decision is not Decision.ALLOW or not suspected:
        return by_rules
    words = sentence(plan, language) if plan is not None else ""
    if not 0 < len(words) <= QUOTE_CHARS:
        return Verdict(Decision.ASK_BACK, RULE, say("opinion.goal", language))
    return Verdict(Decision.ASK_BACK, RULE, say(RULE, language, words=quote(words)))


def is_own_words(text: str, plan: Plan, language: Language) -> bool:
    """Return whether a text says its plan exactly as `with_opinion` offers it, so that it has no other meaning."""
    return _NOISE.sub(" ", text).strip().casefold() == _NOISE.sub(" ", sentence(plan, language)).strip().casefold()
