"""Measure the rules on sentence templates that they have not seen: cross-validation over templates.

    python benchmarks/left_out_templates.py FILE [FILE…] [--failures]

A FILE has rows `{"text": …, "plan": …}`, as for `agentrob eval plan`. Rows that differ only in numbers and sides have
one template. The rows of each template are read by rules without the words, phrases and idioms that occur in no other
template of the file, as if nobody had known it. This is a lower bound for words that stand in the tables for other
reasons, and an upper bound for the rules between the words, which cannot be forgotten. Fresh sentences by other people
are the better measure (`docs/safety/understanding.md`).
"""

from __future__ import annotations

import argparse
import json
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

from agentrob.evals.scoring import score
from agentrob.language import registry
from agentrob.language.locale import Locale
from agentrob.language.parser.grammar import parse
from agentrob.language.parser.lexicon import pieces_of
from agentrob.language.visible_text import visible_text
from agentrob.model import Op, Understanding

Row = Mapping[str, Any]
Phrase = tuple[str, ...]
OPS = frozenset(Op) - {Op.SHAKE}  # "shake hands" then becomes hello, as on a Go2
_SIDES = frozenset(("left", "right", "左", "右"))
_FILLERS = frozenset(("uh", "um", "okay", "ok", "please", "robot", "请", "吧"))


def understand(text: str) -> Understanding:
    return parse(visible_text(text), ["robot"], [], OPS)


def template_of(text: str, known: Locale) -> Phrase:
    """Return the words of a text with one sign for numbers and one for sides, and without fillers."""
    found: list[str] = []
    for piece in pieces_of(text.lower()):
        word = piece.text
        number = word in known.words.numerals or re.fullmatch(r"[\d.]+", word)
        sign = "#" if number else "side" if word in _SIDES else word
        if word not in _FILLERS and not (sign == "#" and found[-1:] == ["#"]):
            found.append(sign)
    return tuple(found)


def phrases_in(text: str, known: Locale) -> set[Phrase]:
    """Return the phrases of the table that a text holds, and those of them that are part of longer ones."""
    words = [piece.text for piece in pieces_of(text.lower())]
    longest = 8
    spans = (tuple(words[at : at + n]) for at in range(len(words)) for n in range(1, longest + 1))
    return {span for span in spans if span in known.words.phrases}


def idioms_in(text: str, known: Locale) -> set[int]:
    return {n for n, (said, _) in enumerate(known.idioms) if re.search(said, text, re.IGNORECASE)}


def exact(rows: Sequence[Row], shortest: int) -> tuple[int, list[str]]:
    """Return how many rows are read exactly without what only their template holds, and the texts of the others.

    Phrases of fewer than `shortest` words are kept.
    """
    templates: dict[tuple[str, Phrase], list[Row]] = defaultdict(list)
    for row in rows:
        language = registry.language_of(row["text"])
        templates[language, template_of(row["text"], registry.locale(language))].append(row)
    held = {
        key: tuple(_all(find(row["text"], registry.locale(key[0])) for row in same) for find in (phrases_in, idioms_in))
        for key, same in templates.items()
    }
    uses = Counter((key[0], one) for key, found in held.items() for one in found[0] | found[1])
    right, failed = 0, []
    for key, same in templates.items():
        full = registry.locale(key[0])
        own = [{one for one in found if uses[key[0], one] == 1} for found in held[key]]
        phrases = {p: m for p, m in full.words.phrases.items() if p not in own[0] or len(p) < shortest}
        idioms = [idiom for n, idiom in enumerate(full.idioms) if n not in own[1]]
        words = full.words if len(phrases) == len(full.words.phrases) else replace(full.words, phrases=phrases)
        others = {**registry.known(), key[0]: replace(full, words=words, idioms=idioms)}
        with patch.object(registry, "known", lambda others=others: others):
            result = score(same, understand)
        right += result.exact
        failed += [failure.text for failure in result.failures]
    return right, failed


def _all(sets: Iterable[set[Any]]) -> set[Any]:
    return set().union(*sets)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=Path)
    parser.add_argument("--failures", action="store_true", help="list what is read exactly only with its own words")
    arguments = parser.parse_args()
    for path in arguments.files:
        rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines() if line.strip()]
        seen = score(rows, understand)
        known_failures = {failure.text for failure in seen.failures}
        print(f"{path.name}: {len(rows)} rows, {seen.exact} exact ({seen.exact / len(rows):.1%}) as they are")
        for shortest, what in ((3, "phrases of three words and more"), (1, "words and phrases")):
            right, failed = exact(rows, shortest)
            print(f"  without the {what} and idioms of its own template: {right} ({right / len(rows):.1%})")
            if arguments.failures:
                print(*(f"    {text}" for text in failed if text not in known_failures), sep="\n")


if __name__ == "__main__":
    main()
