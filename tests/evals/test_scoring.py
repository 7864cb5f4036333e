"""The score of understanding is computed correctly, and every row that must be asked back is."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from agentrob.evals.scoring import matches, score
from agentrob.language.parser.grammar import parse
from agentrob.language.parser.repetition import ParseContext
from agentrob.model import Intent
from tests.language.saying import OPS, read

ASKS_BACK = Path(__file__).parents[1] / "language/asks_back.jsonl"
ROWS = [json.loads(line) for line in ASKS_BACK.read_text(encoding="utf-8").splitlines()]


def test_every_row_that_must_be_asked_back_is() -> None:
    found = score(ROWS, read)
    assert [failure.text for failure in found.failures] == []
    assert (found.n, found.exact, found.moved) == (len(ROWS), len(ROWS), 0)


def test_there_are_a_hundred_rows_in_both_languages() -> None:
    chinese = [row for row in ROWS if re.search("[\u4e00-\u9fff]", row["text"])]
    assert len(ROWS) >= 100
    assert 50 <= len(chinese) <= len(ROWS) - 50
    assert all(row["plan"] is None for row in ROWS)
    assert len({row["text"] for row in ROWS}) == len(ROWS)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row["text"])
def test_each_question_names_one_or_two_sentences_that_would_work(row: dict[str, Any]) -> None:
    understood = read(row["text"])
    question = understood.question
    begin = {"en": "For example:", "zh": "可以这样说："}[understood.language]
    examples = re.findall("`([^`]*)`", question.rpartition(begin)[2])
    assert 1 <= len(examples) <= 2, question
    for example in examples:
        assert parse(example, ["quadruped"], [], OPS, ParseContext()).intent is Intent.COMMAND, example


MOVE = {"op": "move", "direction": "forward", "distance_m": 2.0}
TURN = {"op": "turn", "direction": "any", "degrees": 180}


@pytest.mark.parametrize(
    ("text", "plan", "fits"),
    [
        ("walk forward 2 m", [MOVE], True),
        ("walk forward 2.03 m", [MOVE], True),
        ("walk forward 2.05 m", [MOVE], False),
        ("walk back 2 m", [MOVE], False),
        ("turn around", [TURN], True),
        ("turn right 181 degrees", [TURN], True),
        ("turn right 182 degrees", [TURN], False),
        ("wave", [{"op": "hello"}], True),
        ("wave twice", [{"op": "hello"}], False),
        ("walk forward 2 m", [], False),
        ("walk forward 2 m", None, False),
        ("walk", None, True),
        ("walk", [], False),
        ("stop", [], True),
        ("hello", [], True),
        ("hello", None, False),
    ],
)
def test_a_match_is_exact(text: str, plan: list[dict[str, Any]] | None, fits: bool) -> None:
    assert matches(read(text), plan) is fits


def test_another_accepted_plan_counts() -> None:
    rows = [
        {"text": "walk forward 2 m", "plan": [TURN], "accept": [None, [MOVE]]},
        {"text": "walk forward 2 m", "plan": [TURN], "accept": [None, []]},
    ]
    assert score(rows, read).exact == 1


def test_failures_show_the_actual_result() -> None:
    rows = [
        {"text": "walk forward 1 m", "plan": []},
        {"text": "take a photo", "plan": None},
        {"text": "hi", "plan": []},
    ]
    found = score(rows, read).as_json()
    assert (found["n"], found["exact"], found["moved"]) == (3, 1, 1)
    assert json.loads(json.dumps(found)) == found
    assert found["failures"][0] == {
        "text": "walk forward 1 m",
        "wanted": [],
        "intent": "command",
        "plan": [{"op": "move", "direction": "forward", "distance_m": 1.0}],
        "question": "",
    }


@pytest.mark.parametrize("row", [{}, {"text": "walk"}, {"plan": []}, {"text": 3, "plan": []}])
def test_an_invalid_row_is_an_error(row: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="a row needs"):
        score([row], read)
