"""Every law in docs/safety/laws.md has tests named after it, and what that page says about tests is correct."""

from __future__ import annotations

import re
from collections import defaultdict
from functools import cache
from pathlib import Path

from tests.house.sources import functions

ROOT = Path(__file__).parents[2]
LAWS = range(1, 20)
#: `test_law_6_…`; also `test_law_12_and_14_…` and `test_laws_4_5_and_14_…`, which cover several laws.
_NAMED = re.compile(r"test_laws?_((?:\d+_|and_)+)")


def section(title: str) -> str:
    """Return the text of docs/safety/laws.md under a heading."""
    found = re.search(
        rf"^## {title}\n(.*?)(?=^## |\Z)", (ROOT / "docs/safety/laws.md").read_text(), re.MULTILINE | re.DOTALL
    )
    assert found, f"docs/safety/laws.md has no section {title!r}"
    return found[1]


def rows(title: str) -> list[list[str]]:
    """Return the cells of the table in a section, without its header."""
    lines = [line for line in section(title).splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def numbers(text: str) -> set[int]:
    """Return the numbers in "1–2", "7, 10", "laws 3 and 7"."""
    found = set()
    for first, last in re.findall(r"(\d+)(?:–(\d+))?", text):
        found.update(range(int(first), int(last or first) + 1))
    return found


def not_built() -> set[int]:
    """Return the laws that the section "Not built yet" mentions."""
    return {n for said in re.findall(r"\(laws? ([^)]*)\)", section("Not built yet")) for n in numbers(said)}


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


def test_every_law_is_in_both_tables_once() -> None:
    assert sorted(n for row in rows("What holds, and where") for n in numbers(row[0])) == list(LAWS)
    assert [int(row[0]) for row in rows("How each law is tested")] == list(LAWS)
    assert not_built() <= set(LAWS)


def test_the_pages_statements_about_tests_are_correct() -> None:
    files = shown()
    for law, asserted, named, besides in rows("How each law is tested"):
        listed = set(re.findall(r"`(tests/[^`]+)`", named))
        assert asserted
        assert listed or (int(law) in not_built() and "not built" in asserted.lower()), f"law {law}"
        assert listed <= files[int(law)], f"law {law}: no test of that name in {listed - files[int(law)]}"
        for path in re.findall(r"`([^`]+)`", besides):
            assert (ROOT / path).is_file(), path


def test_the_code_that_the_page_refers_to_exists() -> None:
    for _, _, where in rows("What holds, and where"):
        for path in re.findall(r"`([^`]+)`", where):
            assert (ROOT / "src/agentrob" / path).is_file(), path


def test_the_laws_in_a_test_name_are_parsed() -> None:
    source = "def test_law_12_and_14_x(): ...\nasync def test_laws_4_5_and_14_of_2_y(): ...\ndef test_law_x(): ...\n"
    assert laws_shown(source) == {4, 5, 12, 14}
