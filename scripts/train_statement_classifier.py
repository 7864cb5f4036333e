"""Train the classifiers of statements and of what has nothing to do with a command (`agentrob.language.remarks`).

    .venv/bin/python scripts/train_statement_classifier.py          # writes the weights, prints checksum and figures
    .venv/bin/python scripts/train_statement_classifier.py --check  # only says whether training gives the same file

Logistic regression by gradient descent, without any library and rounded to bytes, so that the same sentences give the
same file everywhere. All of them are in this repository and were written for it. The thresholds and the figures come
from cross-validation: each clause is judged by weights that were trained without its file's block of ten lines.
"""

from __future__ import annotations

import argparse
import base64
import hashlib
import json
import math
import sys
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from agentrob.language.parser.remarks import Clauses, clauses_of
from agentrob.language.registry import language_of, locale
from agentrob.language.remarks.classifier import SHA256, SIZE, WEIGHTS, begins_as_order, buckets, score

TESTS = Path(__file__).parents[1] / "tests"
LINES = "language/statements.jsonl"
FIRST_SIGHT = "language/first_sight.jsonl"
BESIDE = "language/beside_commands.jsonl"
DANGEROUS = "screening/dangerous.jsonl"
ORDERS = (
    "semantic/harm_twins.jsonl",
    "semantic/household_twins.jsonl",
    "screening/walking_directions.jsonl",
    "screening/more_directions.jsonl",
    "language/asks_back.jsonl",
)
FOLDS = 4
ROUNDS = 12
RATE, PENALTY = 0.1, 3e-3
#: At most this share of a language's orders is above a threshold: of "statement" those of them count that no other rule
#: holds back (`Clause.may_be_statement`), of "sure" all.
ORDERS_ABOVE = {"statement": 0.01, "sure": 0.005}
#: At most this share of the clauses that bear on a command is above a threshold of "harmless".
BEARING_ABOVE = {"possible": 0.3, "likely": 0.2, "strong": 0.06, "certain": 0.02}
#: A weight of one is stored as this many.
SCALE = 24


class Row(NamedTuple):
    """A clause, its label, and the block of lines that it stands in; `plain` if it is only an order."""

    language: str
    text: str
    label: bool
    block: int
    plain: bool = False


def rows() -> list[Row]:
    """Return every clause once, labelled as a statement or not."""
    found: dict[str, Row] = {}

    def add(texts: Iterable[str], statement: bool, block: int) -> None:
        for text in texts:
            found.setdefault(text, Row(language_of(text), text, statement, block))

    for n, row in enumerate(_read(LINES)):
        add(_clauses(row["text"]), row["label"] == "remark", n // 10)
    for n, row in enumerate(_read(BESIDE)):
        if row["label"] == "harmless":
            add(_clauses(row["text"]), True, n // 10)
    for n, row in enumerate(_read(FIRST_SIGHT)):
        kind = row["set"].split("_")[0]
        said = _clauses(row["text"])
        if kind == "remark":
            add((clause for clause in said if _is_beside(clause)), True, n // 10)
        else:
            add(said, kind == "talk", n // 10)
    for name in ORDERS:
        for n, row in enumerate(_read(name)):
            add(_clauses(row["text"]), False, n // 10)
    return list(found.values())


def rows_beside() -> list[Row]:
    """Return every clause once, labelled as having nothing to do with a command or as bearing on it."""
    found: dict[str, Row] = {}

    def add(texts: Iterable[str], harmless: bool, block: int, *, plain: bool = False) -> None:
        for text in texts:
            found.setdefault(text, Row(language_of(text), text, harmless, block, plain))

    for n, row in enumerate(_read(BESIDE)):
        add([row["text"]], row["label"] == "harmless", n // 10)
    for n, row in enumerate(_read(FIRST_SIGHT)):
        kind = row["set"].rpartition("_")[0]
        if kind:
            add((said for said in _clauses(row["text"]) if _is_beside(said)), kind != "must_ask", n // 10)
    for n, row in enumerate(_read(DANGEROUS)):
        said = _clauses(row["text"]) if row["label"] == "dangerous" else []
        add((clause for clause in said if len(said) > 1 and _is_beside(clause)), False, n // 10)
    for n, row in enumerate(_read(LINES)):
        add(_clauses(row["text"]), row["label"] == "remark", n // 10, plain=True)
    return list(found.values())


def _clauses(text: str) -> list[str]:
    return [words.strip() for words in clauses_of(text, _clauses_read(text)) if words.strip()]


def _is_beside(clause: str) -> bool:
    """Return whether a clause belongs to the remark of a post and not to its command."""
    read = _clauses_read(clause)[clause]
    return not read.commands and not read.has_amount


def _clauses_read(text: str) -> Clauses:
    """Return the reader of a text's clauses, without the classifier that is trained."""
    return Clauses(replace(locale(language_of(text)), statements=None))


def trained(examples: Sequence[tuple[set[int], bool]]) -> bytes:
    """Return the weights, as signed bytes."""
    weights, squares = [0.0] * SIZE, [1.0] * SIZE
    statements = sum(statement for _, statement in examples)
    balance = {True: len(examples) / (2 * statements), False: len(examples) / (2 * (len(examples) - statements))}
    for _ in range(ROUNDS):
        for features, statement in examples:
            p = 1 / (1 + math.exp(-max(-30.0, min(30.0, sum(weights[at] for at in features)))))
            error = (statement - p) * balance[statement]
            for at in features:
                gradient = error - PENALTY * weights[at]
                squares[at] += gradient * gradient
                weights[at] += RATE * gradient / math.sqrt(squares[at])
    return bytes(max(-127, min(127, round(SCALE * weight))) & 0xFF for weight in weights)


def judged(examples: Sequence[Row]) -> list[tuple[Row, int]]:
    """Return each row with its score by weights that were trained without its fold."""
    read = [(row, buckets(row.text)) for row in examples]
    found = []
    for fold in range(FOLDS):
        weights = trained([(features, row.label) for row, features in read if row.block % FOLDS != fold])
        found += [(row, score(row.text, weights)) for row, _ in read if row.block % FOLDS == fold]
    return found


def threshold_of(found: Sequence[tuple[Row, int]], name: str) -> int:
    """Return the score that at most a certain share of the orders exceed."""
    orders = [(points, row.text) for row, points in found if not row.label]
    counted = sorted((points for points, text in orders if name == "sure" or _is_let_through(text)), reverse=True)
    return counted[int(ORDERS_ABOVE[name] * len(orders))]


def bearing_threshold_of(found: Sequence[tuple[Row, int]], name: str) -> int:
    """Return the score that at most a certain share of the clauses that bear on a command exceed."""
    bearing = sorted((points for row, points in found if not row.label and not row.plain), reverse=True)
    return bearing[int(BEARING_ABOVE[name] * len(bearing))]


def _is_let_through(clause: str) -> bool:
    """Return whether a clause is held back by no rule but the classifier, and by no list of verbs."""
    read = _clauses_read(clause)[clause]
    return read.may_be_statement and not begins_as_order(clause) and not read.known.has_form_of_remark(read.plain)


def content() -> tuple[bytes, list[str]]:
    """Return the file of weights, and a line of figures for each language and threshold."""
    languages: dict[str, dict[str, Any]] = {}
    figures = []
    heads = (("statement", rows(), ORDERS_ABOVE, threshold_of), ("harmless", rows_beside(), BEARING_ABOVE,
        bearing_threshold_of))  # fmt: skip
    for head, every, shares, threshold in heads:
        for language in sorted({row.language for row in every}):
            examples = [row for row in every if row.language == language]
            found = judged(examples)
            weights = trained([(buckets(row.text), row.label) for row in examples])
            thresholds = {name: threshold(found, name) for name in shares}
            languages.setdefault(language, {})[head] = {
                "thresholds": thresholds,
                "weights": base64.b64encode(weights).decode(),
            }
            for name, least in thresholds.items():
                right = [points > least for row, points in found if row.label and not row.plain]
                wrong = [points > least for row, points in found if not row.label and not row.plain]
                figures.append(
                    f"{language}, {head}, {name}: {sum(right)} of {len(right)} that are and {sum(wrong)} of"
                    f" {len(wrong)} that are not, judged without their own block of lines"
                )
    told = {
        "licence": "Apache-2.0",
        "trained_by": "scripts/train_statement_classifier.py",
        "trained_on": checksums(),
        "languages": languages,
    }
    return (json.dumps(told) + "\n").encode(), figures


def checksums() -> dict[str, str]:
    """Return the checksum of each file that the classifier is trained on."""
    return {
        name: hashlib.sha256((TESTS / name).read_bytes()).hexdigest()
        for name in (LINES, FIRST_SIGHT, BESIDE, DANGEROUS, *ORDERS)
    }


def _read(name: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (TESTS / name).read_text(encoding="utf-8").splitlines()]


def main() -> None:
    options = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    options.add_argument("--check", action="store_true", help="only say whether training gives the same file")
    checks = options.parse_args().check
    found, figures = content()
    sha256 = hashlib.sha256(found).hexdigest()
    print(*figures, sep="\n")
    if checks:
        same = sha256 == SHA256 and WEIGHTS.read_bytes() == found
        print("training gives the shipped file" if same else f"training gives another file: {sha256}")
        sys.exit(not same)
    WEIGHTS.write_bytes(found)
    print(f"{WEIGHTS}: {len(found)} bytes; SHA256 in remarks/classifier.py is {sha256}")


if __name__ == "__main__":
    main()
