"""The classifier of statements and orders: its file, what it is trained on, and what it never takes for a statement."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from types import ModuleType

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.errors import ConfigError
from agentrob.language.remarks.classifier import SIZE, WEIGHTS, Confidence, StatementClassifier, buckets, load_weights
from agentrob.language.remarks.verbs import BEFORE_VERB, VERBS

ROOT = Path(__file__).parents[2]
SCRIPT = ROOT / "scripts" / "train_statement_classifier.py"


def training() -> ModuleType:
    spec = importlib.util.spec_from_file_location("train_statement_classifier", SCRIPT)
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_training_gives_the_shipped_weights() -> None:
    script, shipped = training(), load_weights()
    for head, rows in (("statement", script.rows()), ("harmless", script.rows_beside())):
        for language in ("en", "zh"):
            examples = [(buckets(row.text), row.label) for row in rows if row.language == language]
            assert script.trained(examples) == getattr(shipped[language], head).weights, f"run {SCRIPT.name} again"


def test_the_file_names_what_it_was_trained_on() -> None:
    told = json.loads(WEIGHTS.read_text())
    assert told["trained_on"] == training().checksums()
    assert {len(head.weights) for known in load_weights().values() for head in known} == {SIZE}


@pytest.mark.parametrize("content", [None, b"{}"])
def test_a_file_that_is_missing_or_changed_is_an_error(content: bytes | None, tmp_path: Path) -> None:
    path = tmp_path / "weights.json"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ConfigError, match="install agentrob again"):
        load_weights(path)


@given(
    st.sampled_from(sorted(VERBS - BEFORE_VERB)),
    st.sampled_from(["", "please ", "and then ", "could you "]),
    st.text(max_size=60),
)
def test_law_18_what_begins_with_the_verb_of_an_order_is_no_statement(verb: str, before: str, after: str) -> None:
    assert not StatementClassifier("en").is_statement(f"{before}{verb} {after}")


@pytest.mark.parametrize("verb", sorted(VERBS & BEFORE_VERB))
@pytest.mark.parametrize("after", ["it down", "the room", "the engine before you walk"])
def test_law_18_a_verb_that_also_stands_before_an_order_is_judged_by_what_follows(verb: str, after: str) -> None:
    """In "cool, walk forward" it is an exclamation, in "cool the room" the verb of an order."""
    assert not StatementClassifier("en").is_statement(f"{verb} {after}")


@given(st.text(max_size=300), st.sampled_from(["en", "zh"]))
def test_any_text_is_judged_and_what_is_sure_is_also_likely(text: str, language: str) -> None:
    classifier = StatementClassifier(language)
    assert classifier.is_statement(text) >= classifier.is_statement(text, sure=True)
    assert classifier.harmless(text) < Confidence.NEVER
