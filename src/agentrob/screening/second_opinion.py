"""Add a classifier's suspicion to a verdict: it may make the robot ask, and never refuses or allows (law 7). Pure."""

from __future__ import annotations

from agentrob.language.messages.catalog import say
from agentrob.model import Decision, Language, Verdict

RULE = "opinion.harm"


def with_opinion(by_rules: Verdict, suspected: bool, language: Language) -> Verdict:
    """Return the rules' verdict, or a question if they allow what a classifier suspects of harm.

    A command that waits for an approval goes to a person anyway; everything else does not move.
    """
    if by_rules.decision is not Decision.ALLOW or not suspected:
        return by_rules
    return Verdict(Decision.ASK_BACK, RULE, say(RULE, language))
