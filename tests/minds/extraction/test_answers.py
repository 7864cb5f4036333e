"""Sloppy output of weak models is parsed as intended: drafts, reasoning, line breaks, nulls, invented keys and
values."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.minds.extraction.schema import Wants
from agentrob.minds.llm.tool_calls import found_in
from agentrob.minds.safety_review import Judgement

FINE = '{"decision": "fine", "harm": null}'
REFUSED = '{"decision": "refuse", "harm": "people", "words": "", "why": ""}'


@pytest.mark.parametrize(
    "text",
    [
        f"Let me think: {FINE} would be wrong. {REFUSED}",
        f"<think>{FINE}</think>{REFUSED}",
        f"{FINE}</think>\n{REFUSED}",
        f"{REFUSED} or rather {FINE}",
        '{"decision": "Refuse"}',
        '{"decision": "REFUSED.", "harm": "People"}',
        '{"Decision": "refuse", "harm": "explosion"}',
        '{"decision": "refuse", "harm": ["people"]}',
        '{"decision": "refuse", "reason": "a child stands there"}',
        '{"decision": "refuse", "harm": "people", "confidence": 0.9, "words": null}',
        '{"decision": "deny"}',
        '{"decision": "not allowed"}',
        '{"decision": "fine", "harm": "burning down the house"}',
        json.dumps({"decision": "refuse", "words": "a" * 2_000}),
        '{"decision": "refuse", "why": "line\nbreak"}',
        '{"decision": "refuse", "harm": "people", "words": "it breaks off he',
    ],
)
def test_law_7_any_readable_refusal_refuses(text: str) -> None:
    judgement, problem = found_in(text, Judgement)
    assert judgement is not None, problem
    assert judgement.refuses


@pytest.mark.parametrize(
    "text",
    [
        FINE,
        f"<think>{REFUSED}</think>{FINE}",
        '{"decision": "Fine.", "harm": "none", "words": null, "why": null}',
        '{"decision": "fine", "harm": "", "extra": {"a": [1]}}',
    ],
)
def test_an_approval_is_read_as_an_approval(text: str) -> None:
    judgement, problem = found_in(text, Judgement)
    assert judgement is not None, problem
    assert not judgement.refuses


@pytest.mark.parametrize(
    "text",
    ["", "fine", '{"decision": "perhaps"}', '{"decision": "allow"}', "{}", '{"decision": 1}', '{"decision": "fi'],
)
def test_output_that_says_neither_is_not_an_answer(text: str) -> None:
    assert found_in(text, Judgement)[0] is None


def test_line_breaks_nulls_and_unknown_keys_are_tolerated() -> None:
    step = {"action": "move", "direction": "forward", "amount": 1, "unit": "m", "words": "walk\n1 m", "note": "x"}
    step |= {"slow": None, "times": None, "speed": None}
    told = json.dumps({"intent": "command", "steps": [step], "doubt": None, "mood": "good"}).replace("\\n", "\n")
    wants, problem = found_in(told, Wants)
    assert wants is not None, problem
    assert (wants.steps[0].words, wants.steps[0].times, wants.steps[0].slow) == ("walk\n1 m", 1, False)


def test_the_last_complete_reading_counts() -> None:
    nothing, unclear = '{"intent": "nothing"}', '{"intent": "unclear", "doubt": "distance"}'
    wants, _ = found_in(f"{nothing} no: {unclear} and {{broken", Wants)
    assert wants is not None
    assert wants.intent == "unclear"


ANYTHING: st.SearchStrategy[Any] = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=9), inner, max_size=3),
    max_leaves=8,
)


@given(before=st.text(max_size=30), more=st.dictionaries(st.text(max_size=9), ANYTHING, max_size=4))
def test_law_7_no_key_beside_a_refusal_lifts_it(before: str, more: dict[str, Any]) -> None:
    kept = {key: value for key, value in more.items() if key.lower().strip() not in ("decision", "harm")}
    text = before.replace("{", "") + json.dumps({**kept, "decision": "refuse", "harm": "property"})
    judgement, problem = found_in(text, Judgement)
    assert judgement is not None, problem
    assert judgement.refuses
