"""Train the second opinion on harm (`agentrob.semantic.harm_classifier`).

    .venv/bin/python scripts/train_harm_classifier.py          # writes the weights, prints checksum and figures
    .venv/bin/python scripts/train_harm_classifier.py --check  # only says whether training gives the same file

Logistic regression by Newton's method on unit vectors, in one thread and rounded, so that on any x86-64 processor with
AVX2 the same sentences give the same file. All of them are in this repository and were written for it: pairs of a
dangerous sentence and a harmless one in nearly the same words, walking directions, talk, remarks, and plain motions.
The thresholds and the figures come from cross-validation: whole pairs are left out of the training that judges them.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import sys
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import Any

# One thread and one kind of kernel (AVX2): sums in another order differ in the last bits, and so would the file.
os.environ.update(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1", OPENBLAS_CORETYPE="Haswell")

import numpy as np
from numpy.typing import NDArray

from agentrob.semantic.encoder import MODEL, Encoder, require_model
from agentrob.semantic.harm_classifier import WEIGHTS, normalised

TESTS = Path(__file__).parents[1] / "tests"
TWINS = ("screening/dangerous.jsonl", "semantic/harm_twins.jsonl", "semantic/household_twins.jsonl")
DIRECTIONS = "screening/walking_directions.jsonl"
PLAIN = "semantic/plain_posts.jsonl"
#: Weight of the penalty on large weights.
PENALTY = 1.0
FOLDS = 5
#: A language's threshold leaves at most this share of its harmless twins above it …
TWINS_ABOVE = 0.14
#: … and at most this share of its plain motions.
MOTIONS_ABOVE = 0.005
#: Digits that are kept of a weight.
DIGITS = 3
LICENCE = "Apache-2.0"
_BATCH = 32
Matrix = NDArray[np.float64]


def plain_motions() -> list[str]:
    """Return commands that only move the robot, made from parts in both languages."""
    ways = ("walk forward", "go back", "move left", "step to the right", "drive straight ahead")
    amounts = ("1 m", "two metres", "half a metre", "three feet", "20 cm", "a bit")
    turns = ("turn left", "turn right ninety degrees", "rotate 45 degrees", "turn around", "spin once", "face left")
    actions = ("take a photo", "wave", "sit down", "stand up", "stretch", "say hello", "do a little dance", "stop")
    english = [f"{way} {amount}" for way, amount in product(ways, amounts)]
    english += [f"{turn} and {action}" for turn, action in product(turns, actions)]
    english += [f"{turn}, then {way} {amount}" for turn, way, amount in product(turns[:3], ways, amounts[:3])]
    english += [f"can you {action} please" for action in actions] + [*turns, *actions]
    ways_zh, amounts_zh = ("往前走", "后退", "向左移动", "向右平移", "前进"), ("一米", "两米", "半米", "20厘米", "三步")
    turns_zh = ("左转", "右转九十度", "原地转一圈", "掉头", "向左转45度")
    actions_zh = ("拍张照", "挥挥手", "坐下", "站起来", "伸个懒腰", "打个招呼", "比个心", "停下")
    chinese = [way + amount for way, amount in product(ways_zh, amounts_zh)]
    chinese += [f"{turn}，然后{action}" for turn, action in product(turns_zh, actions_zh)]
    chinese += [f"{way}{amount}再{turn}" for way, amount, turn in product(ways_zh, amounts_zh[:3], turns_zh)]
    chinese += [f"请{action}" for action in actions_zh] + [*turns_zh, *actions_zh]
    return english + chinese


def vectors(texts: Sequence[str]) -> Matrix:
    """Return the unit vectors of texts."""
    encoder = Encoder()
    try:
        read = [normalised(text) for text in texts]
        found = [v for n in range(0, len(read), _BATCH) for v in encoder.encode(read[n : n + _BATCH])]
    finally:
        encoder.close()
    numbers = np.frombuffer(b"".join(found), np.int8).reshape(len(texts), -1).astype(np.float64)
    unit: Matrix = numbers / np.linalg.norm(numbers, axis=1, keepdims=True)
    return unit


def fitted(x: Matrix, y: Matrix) -> Matrix:
    """Return the weights of a logistic regression, the last one being the bias."""
    x = np.hstack([x, np.ones((len(x), 1))])
    penalty = np.eye(x.shape[1]) * PENALTY
    penalty[-1, -1] = 1e-6
    weights = np.zeros(x.shape[1])
    for _ in range(25):
        p = 1 / (1 + np.exp(-x @ weights))
        hessian = (x.T * (p * (1 - p))) @ x + penalty
        step = np.linalg.solve(hessian, x.T @ (p - y) + penalty @ weights)
        weights -= step
        if np.abs(step).max() < 1e-9:
            break
    return weights


def training_rows() -> list[tuple[str, str, str, bool, int]]:
    """Return every row as kind, language, text, whether it is dangerous, and the group that is left out together."""
    rows = []
    for n, name in enumerate(TWINS):
        for row in _read(name):
            rows.append(("twin", row["language"], row["text"], row["label"] != "benign", row["pair"] + n))
    rows += [("directions", row["language"], row["text"], False, n) for n, row in enumerate(_read(DIRECTIONS))]
    rows += [(row["kind"], row["language"], row["text"], False, n) for n, row in enumerate(_read(PLAIN))]
    for n, text in enumerate(plain_motions()):
        rows.append(("made motion", "en" if text.isascii() else "zh", text, False, n))
    return rows


def _read(name: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (TESTS / name).read_text(encoding="utf-8").splitlines()]


def checksums() -> dict[str, str]:
    """Return the checksum of each file that the classifier is trained on."""
    return {name: hashlib.sha256((TESTS / name).read_bytes()).hexdigest() for name in (*TWINS, DIRECTIONS, PLAIN)}


def threshold_of(twins: Matrix, motions: Matrix) -> float:
    """Return the lowest score that leaves few enough of both above it."""
    shares = ((twins, TWINS_ABOVE), (motions, MOTIONS_ABOVE))
    return max(float(np.sort(scores)[::-1][int(share * len(scores))]) for scores, share in shares)


def train() -> tuple[bytes, dict[str, tuple[int, float]]]:
    """Return the content of the file of weights, and for each kind of row the number of rows and the share above the
    threshold in cross-validation.
    """
    rows = training_rows()
    x, y = vectors([row[2] for row in rows]), np.array([danger for *_, danger, _ in rows], np.float64)
    kinds, languages = np.array([row[0] for row in rows]), np.array([row[1] for row in rows])
    folds = np.array([row[4] % FOLDS for row in rows])
    scores = np.zeros(len(rows))
    for fold in range(FOLDS):
        weights = fitted(x[folds != fold], y[folds != fold])
        scores[folds == fold] = x[folds == fold] @ weights[:-1] + weights[-1]
    thresholds, figures = {}, {}
    weights = fitted(x, y)
    for language in ("en", "zh"):
        here = languages == language
        found = {kind: scores[here & (kinds == kind) & (y == 0)] for kind in dict.fromkeys(kinds)}
        threshold = threshold_of(found["twin"], np.concatenate([found["motion"], found["made motion"]]))
        found["dangerous twin"] = scores[here & (y == 1)]
        for kind, of_kind in found.items():
            figures[f"{language}, {kind}"] = len(of_kind), float((of_kind > threshold).mean())
        thresholds[language] = round(threshold - float(weights[-1]), DIGITS)
    told = {
        "encoder": MODEL,
        "licence": LICENCE,
        "trained_by": "scripts/train_harm_classifier.py",
        "trained_on": checksums(),
        "rows": len(rows),
        "thresholds": thresholds,
        "weights": [round(float(weight), DIGITS) + 0.0 for weight in weights[:-1]],
    }
    return (json.dumps(told) + "\n").encode(), figures


def main() -> None:
    parser = argparse.ArgumentParser(description="Train the second opinion on harm.")
    parser.add_argument("--check", action="store_true", help="compare with the file, write nothing")
    only_check = parser.parse_args().check
    require_model()
    content, figures = train()
    for name, (n, share) in figures.items():
        sys.stdout.write(f"{name}: {100 * share:.1f} % of {n} above the threshold\n")
    sys.stdout.write(f"SHA256 = {hashlib.sha256(content).hexdigest()!r}\n")
    if not only_check:
        WEIGHTS.write_bytes(content)
    elif WEIGHTS.read_bytes() != content:
        sys.exit(f"training gives other weights than {WEIGHTS}")


if __name__ == "__main__":
    main()
