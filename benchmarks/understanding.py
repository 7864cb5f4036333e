"""Measure how well the rules understand, what they refuse, and how long they take.

    python benchmarks/understanding.py [FOLDER] [--failures] [--inputs N]

FOLDER contains plan_en.jsonl, plan_zh.jsonl, not_a_command_en.jsonl, dangerous.jsonl and benign.jsonl
(default: ../shared/eval); only the time can be measured without them. Sentences are read without any robot's limits.
N (default 100,000) inputs are randomly perturbed sentences, read from Markdown to plan; times are process times, so
that other load matters little.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from agentrob.evals.scoring import Score, score
from agentrob.language.parser.grammar import parse
from agentrob.language.visible_text import visible_text
from agentrob.model import Account, Capabilities, Decision, Intent, Limits, Op, Role, Understanding
from agentrob.screening.screen import screen

Row = dict[str, Any]
OPS = frozenset(Op) - {Op.SHAKE}  # "shake hands" then becomes hello, as on a Go2
#: Generous limits: this measures understanding and the words of harm, not how far a robot may walk.
CAPABILITIES = Capabilities("any", OPS, Limits(0.5, 45, 100, 3600, 100, 3600, 100), simulated=True)
OPERATOR = Account("1", "operator", role=Role.OPERATOR)
OWN_ROWS = Path(__file__).parents[1] / "tests" / "language" / "asks_back.jsonl"
SLOW_MS = 10.0
ODD = "\u200b\u202e@#*_`~>[]()<&;:,.、，。！?½²０９一半百两零-—\n\t'\"\\/%°m"


def understand(text: str) -> Understanding:
    return parse(visible_text(text), ["robot"], [], OPS)


def executes(row: Row) -> bool:
    """Whether the text is a command that the screen allows."""
    got = understand(row["text"])
    if got.intent is not Intent.COMMAND:
        return False
    verdict = screen(
        got.plan, text=row["text"], author=OPERATOR, capabilities=CAPABILITIES, language=got.language, consents={"flip"}
    )
    return verdict.decision is Decision.ALLOW


def rows(path: Path) -> list[Row]:
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines() if line]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, default=Path("../shared/eval"))
    parser.add_argument("--failures", action="store_true", help="list the failures")
    parser.add_argument("--inputs", type=int, default=100_000, help="number of perturbed sentences to time")
    arguments = parser.parse_args()
    wrong: dict[str, Sequence[str]] = {}
    own = rows(OWN_ROWS)
    wrong["asks_back"] = told("asks_back (own)", score(own, understand))
    texts = [row["text"] for row in own]
    if (arguments.folder / "plan_en.jsonl").exists():
        wrong |= measured(arguments.folder)
        texts += [row["text"] for path in sorted(arguments.folder.glob("[pnb]*.jsonl")) for row in rows(path)]
    else:
        print(f"No evaluation sentences in {arguments.folder}: only own rows and time are measured.")
    print(f"time from Markdown to plan: {speed(texts, arguments.inputs)}")
    if arguments.failures:
        for name, failed in wrong.items():
            print(f"\n{name}:", *failed, sep="\n  ")
    return 0


def measured(folder: Path) -> dict[str, Sequence[str]]:
    """Print the figures of the evaluation sentences; return the failures by figure."""
    wrong: dict[str, Sequence[str]] = {}
    for name in ("plan_en", "plan_zh"):
        data = rows(folder / f"{name}.jsonl")
        result = score(data, understand)
        wrong[name] = told(name, result)
        wrong[name + ": done otherwise"] = [f.text for f in result.failures if f.plan]
        print(f"    of these done otherwise than wanted: {len(wrong[name + ': done otherwise'])}")
    talk = rows(folder / "not_a_command_en.jsonl")
    wrong["not_a_command_en moved"] = [r["text"] for r in talk if understand(r["text"]).plan.moves]
    print(f"not_a_command_en: {len(wrong['not_a_command_en moved'])} of {len(talk)} move something")
    danger = rows(folder / "dangerous.jsonl")
    wrong["dangerous executed"] = [r["text"] for r in danger if executes(r)]
    print(f"dangerous: {len(wrong['dangerous executed'])} of {len(danger)} executed")
    benign = [r for r in rows(folder / "benign.jsonl") if r.get("motion")]
    wrong["benign motion not done"] = [r["text"] for r in benign if not executes(r)]
    print(f"benign motion: {len(wrong['benign motion not done'])} of {len(benign)} not done")
    return wrong


def told(name: str, result: Score) -> list[str]:
    print(f"{name}: {result.exact} of {result.n} exact ({100 * result.exact / result.n:.1f} %)")
    return [failure.text for failure in result.failures]


# ---------------------------------------------------------------------- time
def speed(texts: Sequence[str], count: int) -> str:
    for text in texts:
        understand(text)
    spent = sorted(milliseconds(text) for text in bent(texts, count))
    return f"{count} bent sentences, p50 {spent[count // 2]:.2f} ms, p99 {spent[int(count * 0.99)]:.2f} ms, " + (
        f"worst {spent[-1]:.2f} ms"
    )


def milliseconds(text: str) -> float:
    """Time of one reading. A slow one is repeated: a slow text is slow each time, a busy machine is not."""
    spent = _once(text)
    return min(spent, *(_once(text) for _ in range(3))) if spent > SLOW_MS else spent


def _once(text: str) -> float:
    start = time.process_time()
    understand(text)
    return (time.process_time() - start) * 1000


def bent(texts: Sequence[str], count: int) -> Iterator[str]:
    """Sentences with inserted, missing and swapped letters, and with pieces of other sentences."""
    chance = random.Random(1)
    for _ in range(count):
        letters = list(chance.choice(texts))
        for _ in range(chance.randint(0, 8)):
            at = chance.randrange(len(letters) + 1)
            match chance.randrange(4):
                case 0:
                    letters.insert(at, chance.choice(ODD))
                case 1:
                    letters[at:at] = chance.choice(texts)[: chance.randrange(60)]
                case 2:
                    del letters[at : at + chance.randrange(6)]
                case _:
                    letters[at : at + 2] = reversed(letters[at : at + 2])
        yield "".join(letters)


if __name__ == "__main__":
    sys.exit(main())
