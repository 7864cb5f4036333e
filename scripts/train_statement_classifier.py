"""Train the classifier of statements and orders (`agentrob.language.remarks.classifier`).

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
from typing import Any

from agentrob.language.parser.remarks import Clauses, clauses_of
from agentrob.language.registry import language_of, locale
from agentrob.language.remarks.classifier import SHA256, SIZE, WEIGHTS, begins_as_order, buckets, score

TESTS = Path(__file__).parents[1] / "tests"
LINES = "language/statements.jsonl"
FIRST_SIGHT = "language/first_sight.jsonl"
ORDERS = (
    "semantic/harm_twins.jsonl",
    "semantic/household_twins.jsonl",
    "screening/walking_directions.jsonl",
    "screening/more_directions.jsonl",
    "language/asks_back.jsonl",
)
FOLDS = 8
ROUNDS = 12
RATE, PENALTY = 0.1, 3e-3
#: At most this share of a language's orders is above a threshold: of "statement" those of them count that no other rule
#: holds back (`Clause.may_be_statement`), of "sure" all.
ORDERS_ABOVE = {"statement": 0.01, "sure": 0.005}
#: A weight of one is stored as this many.
SCALE = 24
Row = tuple[str, str, bool, int]


def rows() -> list[Row]:
    """Return every clause once, as language, text, whether it is a statement, and its block."""
    found: dict[str, Row] = {}

    def add(texts: Iterable[str], statement: bool, block: int) -> None:
        for text in texts:
            found.setdefault(text, (language_of(text), text, statement, block))

    for n, row in enumerate(_read(LINES)):
        add(_clauses(row["text"]), row["label"] == "remark", n // 10)
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
    read = [(row, buckets(row[1])) for row in examples]
    found = []
    for fold in range(FOLDS):
        weights = trained([(features, row[2]) for row, features in read if row[3] % FOLDS != fold])
        found += [(row, score(row[1], weights)) for row, _ in read if row[3] % FOLDS == fold]
    return found


def threshold_of(found: Sequence[tuple[Row, int]], name: str) -> int:
    """Return the score that at most a certain share of the orders exceed."""
    orders = [(points, row[1]) for row, points in found if not row[2]]
    counted = sorted((points for points, text in orders if name == "sure" or _is_let_through(text)), reverse=True)
    return counted[int(ORDERS_ABOVE[name] * len(orders))]


def _is_let_through(clause: str) -> bool:
    """Return whether a clause is held back by no rule but the classifier, and by no list of verbs."""
    read = _clauses_read(clause)[clause]
    return read.may_be_statement and not begins_as_order(clause) and not read.known.has_form_of_remark(read.plain)


def content() -> tuple[bytes, list[str]]:
    """Return the file of weights, and a line of figures for each language."""
    languages, figures = {}, []
    every = rows()
    for language in sorted({row[0] for row in every}):
        examples = [row for row in every if row[0] == language]
        found = judged(examples)
        weights = trained([(buckets(row[1]), row[2]) for row in examples])
        thresholds = {name: threshold_of(found, name) for name in ORDERS_ABOVE}
        languages[language] = {**thresholds, "weights": base64.b64encode(weights).decode()}
        for name, threshold in thresholds.items():
            statements = [points > threshold for row, points in found if row[2]]
            orders = [points > threshold for row, points in found if not row[2]]
            figures.append(
                f"{language}, {name}: {sum(statements)} of {len(statements)} statements and {sum(orders)} of"
                f" {len(orders)} orders, judged without their own block of lines"
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
    return {name: hashlib.sha256((TESTS / name).read_bytes()).hexdigest() for name in (LINES, FIRST_SIGHT, *ORDERS)}


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
