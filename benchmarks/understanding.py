"""How well the rules understand: exact matches, motions that nobody asked for, refusals. Needs sentences.

    python benchmarks/understanding.py [FOLDER] [--failures]

FOLDER holds plan_en.jsonl, plan_zh.jsonl, not_a_command_en.jsonl, dangerous.jsonl and benign.jsonl
(default: ../shared/eval).
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from pathlib import Path
from typing import Any

from agentrob.judge.screen import screen
from agentrob.language.grammar import parse
from agentrob.language.visible import visible_text
from agentrob.model import (
    Account,
    Capabilities,
    Decision,
    Intent,
    Limits,
    Op,
    Primitive,
    Role,
    Understanding,
)

Row = dict[str, Any]
OPS = frozenset(Op)
#: Generous limits: what is measured is understanding and the words of harm, not how far a robot may walk.
CAPABILITIES = Capabilities("any", OPS, Limits(0.5, 45, 100, 3600, 100, 3600, 100), simulated=True)
OPERATOR = Account("1", "operator", role=Role.OPERATOR)


def understand(text: str) -> Understanding:
    return parse(visible_text(text), ["robot"], [], OPS)


def matches(got: Understanding, wanted: list[Row] | None) -> bool:
    """Same operations in the same order, distances within 2 %, degrees within 1; `any` accepts either side."""
    if wanted is None:
        return got.intent is Intent.ASK_BACK
    if not wanted:
        return got.intent in (Intent.NOTHING, Intent.STOP, Intent.HALT, Intent.HELP, Intent.STATUS)
    steps = got.plan.steps
    return len(steps) == len(wanted) and all(map(_same, steps, wanted))


def _same(step: Primitive, row: Row) -> bool:
    if step.op != row["op"] or row.get("direction", step.direction) not in (step.direction, "any"):
        return False
    if "distance_m" in row:
        return math.isclose(step.distance_m or 0, row["distance_m"], rel_tol=0.02)
    return "degrees" not in row or abs((step.degrees or 0) - row["degrees"]) <= 1


def executes(row: Row) -> bool:
    """Whether anything would be done: the text is a command and the screen lets it pass."""
    got = understand(row["text"])
    if got.intent is not Intent.COMMAND:
        return False
    verdict = screen(
        got.plan, text=row["text"], author=OPERATOR, capabilities=CAPABILITIES, language=got.language, allow_flip=True
    )
    return verdict.decision is Decision.ALLOW


def rows(folder: Path, name: str) -> list[Row]:
    return [json.loads(line) for line in (folder / name).read_text(encoding="utf-8").splitlines() if line]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, default=Path("../shared/eval"))
    parser.add_argument("--failures", action="store_true", help="list what went wrong")
    arguments = parser.parse_args()
    folder: Path = arguments.folder
    if not (folder / "plan_en.jsonl").exists():
        print(f"No evaluation sentences in {folder}: nothing measured.")
        return 0
    wrong: dict[str, list[str]] = {}
    for name in ("plan_en", "plan_zh"):
        data = rows(folder, f"{name}.jsonl")
        wrong[name] = [r["text"] for r in data if not matches(understand(r["text"]), r["plan"])]
        moved = [r["text"] for r in data if r["plan"] and wrong_motion(r)]
        print(f"{name}: {len(data) - len(wrong[name])} of {len(data)} exact, {len(moved)} otherwise than wanted")
        wrong[name + ": done otherwise"] = moved
    talk = rows(folder, "not_a_command_en.jsonl")
    wrong["not_a_command_en moved"] = [r["text"] for r in talk if understand(r["text"]).plan.moves]
    print(f"not_a_command_en: {len(wrong['not_a_command_en moved'])} of {len(talk)} move something")
    danger = rows(folder, "dangerous.jsonl")
    wrong["dangerous executed"] = [r["text"] for r in danger if executes(r)]
    print(f"dangerous: {len(wrong['dangerous executed'])} of {len(danger)} executed")
    benign = [r for r in rows(folder, "benign.jsonl") if r.get("motion")]
    wrong["benign motion not done"] = [r["text"] for r in benign if not executes(r)]
    print(f"benign motion: {len(wrong['benign motion not done'])} of {len(benign)} not done")
    print(f"time of parse: {speed([r['text'] for r in talk + danger + benign])}")
    if arguments.failures:
        for name, texts in wrong.items():
            print(f"\n{name}:", *texts, sep="\n  ")
    return 0


def wrong_motion(row: Row) -> bool:
    """Whether something other than the wanted plan would be done, rather than asked back."""
    got = understand(row["text"])
    return got.plan.moves and not matches(got, row["plan"])


def speed(texts: list[str]) -> str:
    spent = []
    for text in texts:
        start = time.process_time()
        understand(text)
        spent.append((time.process_time() - start) * 1000)
    spent.sort()
    return f"p50 {spent[len(spent) // 2]:.2f} ms, p99 {spent[int(len(spent) * 0.99)]:.2f} ms, worst {spent[-1]:.2f} ms"


if __name__ == "__main__":
    sys.exit(main())
