"""Law 7: a classifier's suspicion may make the robot ask back; it never refuses or allows anything."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.language.messages.plan_text import sentence
from agentrob.language.parser.grammar import parse
from agentrob.model import Decision, Direction, Op, Plan, Primitive, Verdict
from agentrob.screening.second_opinion import RULE, is_own_words, with_opinion

PLAN = Plan((Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.5), Primitive(Op.HELLO)))
LANGUAGES = st.sampled_from(["en", "zh"])
SIDES = st.sampled_from([Direction.LEFT, Direction.RIGHT])
#: From the strictest to the most permissive.
STRICT = {Decision.REFUSE: 0, Decision.ASK_BACK: 1, Decision.NEEDS_APPROVAL: 2, Decision.ALLOW: 3}

moves = st.builds(
    lambda direction, cm: Primitive(Op.MOVE, direction, distance_m=cm / 100),
    st.sampled_from([Direction.FORWARD, Direction.BACKWARD, Direction.LEFT, Direction.RIGHT]),
    st.integers(1, 500),
)
turns = st.builds(lambda side, degrees: Primitive(Op.TURN, side, degrees=float(degrees)), SIDES, st.integers(1, 360))
gestures = st.sampled_from([Op.HELLO, Op.SIT, Op.STAND, Op.STRETCH, Op.GET_FRONT_IMAGE]).map(Primitive)
plans = st.lists(moves | turns | gestures, min_size=1, max_size=4).map(lambda steps: Plan(tuple(steps)))
verdicts = st.builds(Verdict, st.sampled_from(list(Decision)), st.text(max_size=20), st.text(max_size=20))


@given(verdicts, st.sampled_from([True, False, None]), plans | st.none(), LANGUAGES)
def test_law_7_an_opinion_never_refuses_and_never_allows(
    by_rules: Verdict, suspected: bool | None, plan: Plan | None, language: str
) -> None:
    verdict = with_opinion(by_rules, suspected, plan, language)
    assert STRICT[verdict.decision] <= STRICT[by_rules.decision]
    if by_rules.decision is Decision.ALLOW and suspected:
        assert (verdict.decision, verdict.rule) == (Decision.ASK_BACK, RULE)
        assert verdict.reason
    else:
        assert verdict is by_rules


@pytest.mark.parametrize(("language", "word"), [("en", "dangerous"), ("zh", "危险")])
def test_a_suspicion_asks_back_in_the_language_of_the_post_and_offers_the_plan(language: str, word: str) -> None:
    verdict = with_opinion(Verdict(Decision.ALLOW, "screen.passed"), True, PLAN, language)
    assert word in verdict.reason
    assert f"`{sentence(PLAN, language)}`" in verdict.reason
    goal = with_opinion(Verdict(Decision.ALLOW, "screen.passed"), True, None, language)
    assert word in goal.reason
    assert "`" not in goal.reason
    walks = tuple(Primitive(Op.MOVE, Direction.FORWARD, distance_m=n / 4) for n in range(1, 19))
    long = with_opinion(Verdict(Decision.ALLOW, "screen.passed"), True, Plan(walks), language)
    assert long.reason == goal.reason, "what does not fit a reply is not offered"


@given(plans, LANGUAGES)
def test_what_is_offered_is_read_as_the_same_plan_and_needs_no_opinion(plan: Plan, language: str) -> None:
    offered = sentence(plan, language)
    assert parse(offered, ["quadruped"], [], frozenset(Op)).plan.steps == plan.steps
    assert is_own_words(f" {offered.upper()}. ", plan, language)


@pytest.mark.parametrize(
    "text", ["walk forward 1.5 m and wave at the boy", "quickly walk forward 1.5 m, then wave", "walk forward 1.5 m"]
)
def test_words_that_say_more_or_less_than_the_plan_are_judged(text: str) -> None:
    assert not is_own_words(text, PLAN, "en")
