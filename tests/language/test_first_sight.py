"""Sentences that were written before anybody saw how the rules read them: none is done otherwise than it means."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from agentrob.evals.scoring import score
from agentrob.language.parser.grammar import parse
from agentrob.language.visible_text import visible_text
from agentrob.model import Op, Understanding

Row = dict[str, Any]
#: How many rows of each set are understood since the rules were corrected by them; the first run had fewer. The
#: classifiers of remarks are not trained on the later sets.
UNDERSTOOD = {
    "first_sight": {
        "en": 443, "zh": 413, "remark_en": 381, "remark_zh": 367, "talk_en": 305, "talk_zh": 285, "must_ask_en": 94,
        "must_ask_zh": 91,
    },
    "later_first_sight": {
        "en": 382, "zh": 146, "remark_en": 127, "remark_zh": 130, "talk_en": 130, "talk_zh": 130, "must_ask_en": 103,
        "must_ask_zh": 100,
    },
}  # fmt: skip
SETS = [(file, kind) for file, kinds in UNDERSTOOD.items() for kind in kinds]


def read(text: str) -> Understanding:
    return parse(visible_text(text), ["robot"], [], frozenset(Op) - {Op.SHAKE})


@cache
def rows_in(file: str) -> list[Row]:
    lines = (Path(__file__).parent / f"{file}.jsonl").read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines]


def rows_of(file: str, kind: str) -> list[Row]:
    return [row for row in rows_in(file) if row["set"] == kind]


@pytest.mark.parametrize(("file", "kind"), SETS)
def test_law_18_no_sentence_is_done_otherwise_than_it_means(file: str, kind: str) -> None:
    failed = score(rows_of(file, kind), read).failures
    done = [failure.text for failure in failed if read(failure.text).plan.steps]
    assert not done


@pytest.mark.parametrize(("file", "kind"), SETS)
def test_as_many_are_understood_as_documented(file: str, kind: str) -> None:
    assert score(rows_of(file, kind), read).exact >= UNDERSTOOD[file][kind]
