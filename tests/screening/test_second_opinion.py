"""Law 7: a classifier's suspicion may make the robot ask, and never refuses or allows anything."""

from __future__ import annotations

import pytest

from agentrob.model import Decision, Verdict
from agentrob.screening.second_opinion import RULE, with_opinion


@pytest.mark.parametrize("decision", [d for d in Decision if d is not Decision.ALLOW])
@pytest.mark.parametrize("suspected", [True, False])
def test_law_7_an_opinion_changes_nothing_that_the_rules_do_not_allow(decision: Decision, suspected: bool) -> None:
    by_rules = Verdict(decision, "some.rule", "why")
    assert with_opinion(by_rules, suspected, "en") is by_rules


@pytest.mark.parametrize(("language", "word"), [("en", "dangerous"), ("zh", "危险")])
def test_a_suspicion_asks_back_in_the_language_of_the_post(language: str, word: str) -> None:
    verdict = with_opinion(Verdict(Decision.ALLOW, "screen.passed"), True, language)
    assert (verdict.decision, verdict.rule) == (Decision.ASK_BACK, RULE)
    assert word in verdict.reason


def test_without_a_suspicion_the_rules_decide() -> None:
    allowed = Verdict(Decision.ALLOW, "screen.passed")
    assert with_opinion(allowed, False, "en") is allowed
