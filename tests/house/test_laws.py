"""Every law in docs/safety/laws.md has tests named after it, and what that page says about tests is correct."""

from __future__ import annotations

import re
from collections import defaultdict
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from tests.house.sources import functions

ROOT = Path(__file__).parents[2]
LAWS = range(1, 20)
#: `test_law_6_…`; also `test_law_12_and_14_…` and `test_laws_4_5_and_14_…`, which cover several laws.
_NAMED = re.compile(r"test_laws?_((?:\d+_|and_)+)")


@dataclass(frozen=True)
class Law:
    """An entry of docs/safety/laws.md: the properties that its tests show, its code, the tests named after it,
    others."""

    shown: list[str]
    code: list[str]
    named: set[str]
    besides: set[str]


def page() -> str:
    return (ROOT / "docs/safety/laws.md").read_text(encoding="utf-8")


def laws() -> dict[int, Law]:
    """Return the sections of the page by the number of their law."""
    found: dict[int, Law] = {}
    for number, text in re.findall(r"^### Law (\d+): .*?$(.*?)(?=^##|\Z)", page(), re.MULTILINE | re.DOTALL):
        assert int(number) not in found, f"law {number} has two sections"
        code, tests = (re.search(rf"^\*\*{title}:\*\* (.*)$", text, re.MULTILINE) for title in ("Code", "Tests"))
        assert code, f"law {number} names no code"
        assert tests, f"law {number} names no tests"
        named, _, besides = tests[1].partition(";")
        paths = [re.findall(r"`([^`]+)`", part) for part in (code[1], named, besides)]
        found[int(number)] = Law(re.findall(r"^- ", text, re.MULTILINE), paths[0], set(paths[1]), set(paths[2]))
    return found


def numbers(text: str) -> set[int]:
    """Return the numbers in "6", "3 and 7"."""
    return {int(number) for number in re.findall(r"\d+", text)}


def not_built() -> set[int]:
    """Return the laws that the section "Not built yet" mentions."""
    _, _, text = page().partition("## Not built yet")
    return {n for said in re.findall(r"\(laws? ([^)]*)\)", text) for n in numbers(said)}


def laws_shown(source: str) -> set[int]:
    """Return the laws that the test names of a file mention."""
    return {n for name in functions(source) if (named := _NAMED.match(name)) for n in numbers(named[1])}


@cache
def shown() -> dict[int, set[str]]:
    """Return for each law the files with tests named after it."""
    files: dict[int, set[str]] = defaultdict(set)
    for path in sorted((ROOT / "tests").glob("**/test_*.py")):
        for law in laws_shown(path.read_text(encoding="utf-8")):
            files[law].add(path.relative_to(ROOT).as_posix())
    return files


def test_every_law_has_a_named_test_or_is_listed_as_not_built() -> None:
    assert set(LAWS) - set(shown()) - not_built() == set()
    assert set(shown()) <= set(LAWS), "a test names a law that does not exist"


def test_every_law_has_a_section_in_order() -> None:
    assert list(laws()) == list(LAWS)
    assert not_built()
    assert not_built() <= set(LAWS)


def test_the_pages_statements_about_tests_are_correct() -> None:
    files = shown()
    for number, law in laws().items():
        assert law.shown
        assert law.named, f"law {number}"
        assert law.named <= files[number], f"law {number}: no test of that name in {law.named - files[number]}"
        assert [path for path in law.besides if not (ROOT / path).is_file()] == []


def test_the_code_that_the_page_refers_to_exists() -> None:
    for number, law in laws().items():
        assert law.code, f"law {number}"
        assert [path for path in law.code if not (ROOT / "src/agentrob" / path).is_file()] == []


def test_the_laws_in_a_test_name_are_parsed() -> None:
    source = "def test_law_12_and_14_x(): ...\nasync def test_laws_4_5_and_14_of_2_y(): ...\ndef test_law_x(): ...\n"
    assert laws_shown(source) == {4, 5, 12, 14}
