"""A model's safety review can only restrict a command, its reasons are our sentences, and odd output does not fool
it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agentrob.language.registry import known
from agentrob.minds.llm.prompt import system_prompt
from agentrob.minds.safety_review import Judgement, SafetyReview, apply_review, harms, refusal_of, review_command
from agentrob.model import Capabilities, Decision, Direction, Op, Plan, Primitive, Verdict
from tests.minds.scripted_model import ScriptedModel, running_scripted_model

pytestmark = pytest.mark.usefixtures("model_libraries")

GO2 = Capabilities("go2", frozenset(Op))
PLAN = Plan((Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0),))
ALLOWED = Verdict(Decision.ALLOW, "screen.passed")
#: Every output that the schema allows.
JUDGEMENTS = st.builds(
    Judgement,
    decision=st.sampled_from(["fine", "refuse"]),
    harm=st.none() | st.sampled_from(harms()),
    words=st.text(max_size=60),
    why=st.text(max_size=60),
)


@pytest.fixture
def scripted_model() -> Iterator[ScriptedModel]:
    with running_scripted_model() as made:
        yield made


@settings(max_examples=300)
@given(
    by_rules=st.builds(Verdict, st.sampled_from(Decision), st.sampled_from(["harm.collide", "limit.speed"]), st.text()),
    judgement=JUDGEMENTS,
    failed=st.sampled_from(["", "timeout", "malformed"]),
    required=st.booleans(),
    language=st.sampled_from(["en", "zh"]),
    asked=st.booleans(),
)
def test_law_7_no_model_overrides_a_refusal_by_the_rules(
    by_rules: Verdict, judgement: Judgement, failed: str, required: bool, language: str, asked: bool
) -> None:
    refusal = refusal_of(judgement, "walk forward 1 m", language)
    screened = SafetyReview("clever", None if failed else refusal, failed) if asked else None
    verdict = apply_review(by_rules, screened, language, required)
    if by_rules.decision not in (Decision.ALLOW, Decision.NEEDS_APPROVAL):
        assert verdict == by_rules
    if verdict.decision in (Decision.ALLOW, Decision.NEEDS_APPROVAL):
        assert verdict == by_rules
        assert refusal is None or failed or not asked
        assert not required or (asked and not failed)


@given(decision=st.sampled_from(Decision), rule=st.text(max_size=9))
def test_law_7_no_verdict_of_a_model_lifts_a_refusal(decision: Decision, rule: str) -> None:
    refused = Verdict(Decision.REFUSE, "harm.collide")
    assert apply_review(refused, SafetyReview("clever", Verdict(decision, rule)), "en") == refused
    assert apply_review(ALLOWED, SafetyReview("clever", Verdict(Decision.ALLOW, rule)), "en") == ALLOWED


@pytest.mark.parametrize("language", list(known()))
@pytest.mark.parametrize("harm", harms())
def test_each_kind_of_harm_has_a_rule_and_a_sentence(harm: Any, language: str) -> None:
    verdict = refusal_of(Judgement(decision="refuse", harm=harm), "", language)
    assert verdict is not None
    assert verdict.rule == f"model.{harm}"
    assert verdict.reason


def test_a_named_harm_refuses_and_a_refusal_without_one_does_too() -> None:
    assert refusal_of(Judgement(decision="fine"), "", "en") is None
    assert refusal_of(Judgement(decision="fine", harm="people"), "", "en") is not None
    other = refusal_of(Judgement(decision="refuse"), "", "en")
    assert other is not None
    assert other.rule == "model.other"


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        ("to  The BABY", "`to the baby`"),
        ("to the dragon", None),
        ("", None),
        ("`@bob` walk", None),
    ],
)
def test_law_3_only_words_of_the_post_are_shown(words: str, shown: str | None) -> None:
    judgement = Judgement(decision="refuse", harm="people", words=words, why="<b>@bob</b>")
    verdict = refusal_of(judgement, "walk 1 m to the baby", "en")
    assert verdict is not None
    assert "bob" not in verdict.reason
    if shown is None:
        assert "`" not in verdict.reason
    else:
        assert shown in verdict.reason


async def test_it_gets_the_post_as_data_and_what_is_around_and_no_tools_but_its_answer(
    scripted_model: ScriptedModel, tmp_path: Path
) -> None:
    model = scripted_model.model(tmp_path)
    before = [Plan((Primitive(Op.TURN, Direction.LEFT, degrees=90.0),))]
    screened = await review_command(
        model, "walk forward\u202e 1 m", PLAN, GO2, "en", before, scene="A sleeping cat, 0.5 m ahead."
    )
    assert screened == SafetyReview("clever", usage=screened.usage)
    (told,) = scripted_model.prompts("screen")
    facts, _, post = told.partition("\n")
    assert json.loads(facts) == {
        "robot": "go2",
        "it understood": "walk forward 1 m",
        "done before in this thread, oldest first": ["turn left 90 degrees"],
        "its speed is at most": "0.5 m/s",
        "around it": "A sleeping cat, 0.5 m ahead.",
    }
    mark = post.splitlines()[1].split()[-1]
    assert post.splitlines()[1:] == [f"<<<post {mark}", "walk forward 1 m", f"post {mark}>>>"]
    (body,) = scripted_model.server.requests
    assert [t["function"]["name"] for t in body["tools"]] == ["answer"]
    assert "walk forward" not in body["messages"][0]["content"]
    await model.close()


@pytest.mark.parametrize(
    "answer",
    [{"decision": "allow"}, {"decision": "perhaps", "override": True}, {"harm": None}, {}],
)
async def test_output_outside_the_schema_is_an_error(
    scripted_model: ScriptedModel, tmp_path: Path, answer: dict[str, Any]
) -> None:
    model = scripted_model.model(tmp_path)
    scripted_model.review = answer
    screened = await review_command(model, "walk forward 1 m", PLAN, GO2, "en")
    assert (screened.refusal, screened.failed) == (None, "malformed")
    assert len(screened.usage) == 2, "it is told once what is wrong"
    await model.close()


async def test_a_hanging_model_times_out(scripted_model: ScriptedModel, tmp_path: Path) -> None:
    model = scripted_model.model(tmp_path)
    scripted_model.review = lambda handler: handler.hang()
    screened = await review_command(model, "walk forward 1 m", PLAN, GO2, "en", limit_s=0.2)
    assert (screened.refusal, screened.failed) == (None, "timeout")
    await model.close()


async def test_earlier_usage_of_the_command_counts(scripted_model: ScriptedModel, tmp_path: Path) -> None:
    model = scripted_model.model(tmp_path, limits={"command_tokens": 5_000})
    first = await review_command(model, "walk forward 1 m", PLAN, GO2, "en")
    assert first.failed == ""
    again = await review_command(model, "walk forward 1 m", PLAN, GO2, "en", spent=first.usage * 30)
    assert again.failed == "budget"
    await model.close()


def test_prompts_of_screening_and_summaries_do_not_depend_on_the_robot() -> None:
    other = system_prompt(Capabilities("robot", frozenset(Op)))
    assert system_prompt(Capabilities("screen", frozenset(Op))) == other
    assert system_prompt(Capabilities("summary", frozenset(Op))) == other
