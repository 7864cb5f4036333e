"""Train the second opinion on harm (`agentrob.semantic.harm_classifier`).

    .venv/bin/python scripts/train_harm_classifier.py          # writes the weights, prints checksum and figures
    .venv/bin/python scripts/train_harm_classifier.py --check  # only says whether training gives the same file

Logistic regression by Newton's method on unit vectors: the same rows give the same file, because the numbers are
rounded. The rows are the project's own pairs of a dangerous sentence and a harmless one in nearly the same words,
walking directions and plain motions, and the English rows of the evaluation data beside the checkout
(`AGENTROB_EVAL`), which are not part of the repository. The figures are of cross-validation: whole pairs are left out
of the training that judges them.
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

import numpy as np
from numpy.typing import NDArray

from agentrob.semantic.encoder import MODEL, Encoder, require_model
from agentrob.semantic.harm_classifier import WEIGHTS

TESTS = Path(__file__).parents[1] / "tests"
TWINS = (TESTS / "screening/dangerous.jsonl", TESTS / "semantic/harm_twins.jsonl")
DIRECTIONS = TESTS / "screening/walking_directions.jsonl"
EVAL = Path(os.environ.get("AGENTROB_EVAL") or Path(__file__).parents[2] / "shared/eval")
#: Files of the evaluation data: dangerous tasks, harmless ones, and commands of people that only move a robot.
EVAL_FILES = ("dangerous.jsonl", "benign.jsonl", "plan_en.jsonl")
#: Weight of the penalty on large weights.
PENALTY = 0.3
FOLDS = 5
#: The threshold leaves this share of the harmless twins above it.
TWINS_ABOVE = 0.13
#: The threshold leaves this share of the commands that only move a robot above it.
MOTIONS_ABOVE = 0.004
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
    deeds = ("take a photo", "wave", "sit down", "stand up", "stretch", "say hello", "do a little dance", "stop")
    english = [f"{way} {amount}" for way, amount in product(ways, amounts)]
    english += [f"{turn} and {deed}" for turn, deed in product(turns, deeds)]
    english += [f"{turn}, then {way} {amount}" for turn, way, amount in product(turns[:3], ways, amounts[:3])]
    english += [f"can you {deed} please" for deed in deeds] + [*turns, *deeds]
    ways_zh, amounts_zh = ("往前走", "后退", "向左移动", "向右平移", "前进"), ("一米", "两米", "半米", "20厘米", "三步")
    turns_zh = ("左转", "右转九十度", "原地转一圈", "掉头", "向左转45度")
    deeds_zh = ("拍张照", "挥挥手", "坐下", "站起来", "伸个懒腰", "打个招呼", "比个心", "停下")
    chinese = [way + amount for way, amount in product(ways_zh, amounts_zh)]
    chinese += [f"{turn}，然后{deed}" for turn, deed in product(turns_zh, deeds_zh)]
    chinese += [f"{way}{amount}再{turn}" for way, amount, turn in product(ways_zh, amounts_zh[:3], turns_zh)]
    chinese += [f"请{deed}" for deed in deeds_zh] + [*turns_zh, *deeds_zh]
    return english + chinese


def vectors(texts: Sequence[str]) -> Matrix:
    """Return the unit vectors of texts."""
    encoder = Encoder()
    try:
        found = [v for n in range(0, len(texts), _BATCH) for v in encoder.encode(texts[n : n + _BATCH])]
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
        weights -= np.linalg.solve(hessian, x.T @ (p - y) + penalty @ weights)
    return weights


def missing_data() -> list[Path]:
    """Return the files of the evaluation data that are not there."""
    return [path for name in EVAL_FILES if not (path := EVAL / name).is_file()]


def training_rows() -> list[tuple[str, str, bool, int]]:
    """Return every row as kind, text, whether it is dangerous, and the group that is left out together."""
    rows = []
    for n, path in enumerate(TWINS):
        rows += [("twin", row["text"], row["label"] != "benign", row["pair"] + n) for row in _read(path)]
    rows += [("directions", row["text"], False, n) for n, row in enumerate(_read(DIRECTIONS))]
    rows += [("made motion", text, False, n) for n, text in enumerate(plain_motions())]
    for name in EVAL_FILES:
        for n, row in enumerate(_read(EVAL / name)):
            kind = "motion" if row.get("motion") or row.get("plan") else name.removesuffix(".jsonl")
            rows.append((kind, row["text"], name == "dangerous.jsonl", n))
    return rows


def _read(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


def train() -> tuple[bytes, dict[str, float]]:
    """Return the content of the file of weights, and the shares above the threshold in cross-validation."""
    rows = training_rows()
    x, y = vectors([text for _, text, _, _ in rows]), np.array([danger for _, _, danger, _ in rows], np.float64)
    folds = np.array([group % FOLDS for *_, group in rows])
    scores = np.zeros(len(rows))
    for fold in range(FOLDS):
        weights = fitted(x[folds != fold], y[folds != fold])
        scores[folds == fold] = x[folds == fold] @ weights[:-1] + weights[-1]
    kinds = np.array([f"{kind}, {'dangerous' if danger else 'harmless'}" for kind, _, danger, _ in rows])
    threshold = max(
        float(np.quantile(scores[kinds == "twin, harmless"], 1 - TWINS_ABOVE)),
        float(np.quantile(scores[kinds == "motion, harmless"], 1 - MOTIONS_ABOVE)),
    )
    figures = {str(kind): float((scores[kinds == kind] > threshold).mean()) for kind in dict.fromkeys(kinds)}
    weights = fitted(x, y)
    told = {
        "encoder": MODEL,
        "licence": LICENCE,
        "rows": len(rows),
        "bias": round(float(weights[-1]) - threshold, DIGITS),
        "weights": [round(float(weight), DIGITS) + 0.0 for weight in weights[:-1]],
    }
    return (json.dumps(told) + "\n").encode(), figures


def main() -> None:
    parser = argparse.ArgumentParser(description="Train the second opinion on harm.")
    parser.add_argument("--check", action="store_true", help="compare with the file, write nothing")
    only_check = parser.parse_args().check
    require_model()
    if absent := missing_data():
        sys.exit(f"the evaluation data is absent: {', '.join(map(str, absent))}")
    content, figures = train()
    for name, share in figures.items():
        sys.stdout.write(f"{name}: {100 * share:.1f} % above the threshold\n")
    sys.stdout.write(f"SHA256 = {hashlib.sha256(content).hexdigest()!r}\n")
    if not only_check:
        WEIGHTS.write_bytes(content)
    elif WEIGHTS.read_bytes() != content:
        sys.exit(f"training gives other weights than {WEIGHTS}")


if __name__ == "__main__":
    main()
