"""One version everywhere, and upgrade notes for it."""

from __future__ import annotations

import re
import tomllib
from itertools import pairwise
from pathlib import Path

import agentrob

ROOT = Path(__file__).parents[2]
CHANGELOG = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
VERSIONS = re.findall(r"^## (\d+\.\d+\.\d+) – \d{4}-\d\d-\d\d$", CHANGELOG, re.MULTILINE)


def test_the_package_its_plugins_and_the_citation_have_one_version() -> None:
    projects = [ROOT / "pyproject.toml", *ROOT.glob("plugins/*/pyproject.toml")]
    versions = {tomllib.loads(file.read_text(encoding="utf-8"))["project"]["version"] for file in projects}
    citation = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.MULTILINE)
    assert citation is not None
    assert versions | {citation[1]} == {agentrob.__version__}


def test_the_changelog_has_each_version_newest_first_and_a_place_for_what_comes() -> None:
    assert VERSIONS[0] == agentrob.__version__
    assert sorted(VERSIONS, key=lambda version: tuple(map(int, version.split("."))), reverse=True) == VERSIONS
    assert CHANGELOG.index("## Unreleased") < CHANGELOG.index(f"## {VERSIONS[0]}")


def test_there_are_upgrade_notes_from_each_version_to_the_next() -> None:
    notes = (ROOT / "docs/forum/upgrade.md").read_text(encoding="utf-8")
    for newer, older in pairwise(VERSIONS):
        assert f"## From {older} to {newer}" in notes
