"""Measure how long the rules take for one post, in English and in Chinese.

    python benchmarks/understanding_time.py [FOLDER] [--runs N]

The posts are the rows of tests/language and, if it is there, of FOLDER (default: ../shared/eval) of at most 200
characters, and long posts of such rows joined, up to the most that is parsed. A post is read from its Markdown to a
plan, a question or nothing, in one process. The time of a post is the median of N runs (default 5) of processor time,
so that other load matters little, after one that is not counted. Wanted for all posts but the long ones: p50 at most
0.5 ms, p99 at most 2 ms.
"""

from __future__ import annotations

import argparse
import json
import random
import statistics
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from agentrob.language.parser.grammar import MAX_CHARS, parse
from agentrob.language.registry import language_of
from agentrob.language.visible_text import visible_text
from agentrob.model import Op

OWN = Path(__file__).parents[1] / "tests" / "language"
OPS = frozenset(Op)
LONGEST = 200
LONG_POSTS = 100
HEAD = "| posts | number | p50 | p90 | p99 | worst |\n|---|---|---|---|---|---|"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, default=Path("../shared/eval"))
    parser.add_argument("--runs", type=int, default=5)
    arguments = parser.parse_args()
    texts = texts_of([*sorted(OWN.rglob("*.jsonl")), *sorted(arguments.folder.glob("*.jsonl"))])
    posts = {
        "English": [text for text in texts if language_of(text) == "en"],
        "Chinese": [text for text in texts if language_of(text) == "zh"],
    }
    posts |= {f"{language}, long": long_posts(short) for language, short in posts.items()}
    print(HEAD)
    for name, each in posts.items():
        told(name, milliseconds(each, arguments.runs))
    return 0


def texts_of(files: Sequence[Path]) -> list[str]:
    """Return the texts of rows, without very long ones, each once."""
    rows = (json.loads(line) for file in files for line in file.read_text(encoding="utf-8").splitlines() if line)
    return list(dict.fromkeys(row["text"] for row in rows if len(row["text"]) <= LONGEST))


def long_posts(texts: Sequence[str]) -> list[str]:
    """Return posts of joined texts, half as long as the grammar parses at most, or longer."""
    chance = random.Random(1)
    posts = []
    for _ in range(LONG_POSTS):
        post, most = "", chance.randint(MAX_CHARS // 2, MAX_CHARS)
        while len(longer := f"{post}{chance.choice(texts)}. ") <= most:
            post = longer
        posts.append(post)
    return posts


def milliseconds(texts: Sequence[str], runs: int) -> list[float]:
    """Return the time of each text, in order of size."""
    spent: list[list[float]] = [[] for _ in texts]
    for _ in range(runs + 1):
        for text, times in zip(texts, spent, strict=True):
            begun = time.process_time_ns()
            parse(visible_text(text), ["robot"], [], OPS)
            times.append((time.process_time_ns() - begun) / 1e6)
    return sorted(statistics.median(times[1:]) for times in spent)


def told(name: str, spent: Sequence[float]) -> None:
    """Print the figures of some posts."""
    p50, p90, p99 = (spent[int(len(spent) * share)] for share in (0.5, 0.9, 0.99))
    print(f"| {name} | {len(spent)} | {p50:.2f} ms | {p90:.2f} ms | {p99:.2f} ms | {spent[-1]:.2f} ms |")


if __name__ == "__main__":
    sys.exit(main())
