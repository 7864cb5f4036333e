"""docs/inside/architecture.md matches the code: a line for each package, and the layers that import-linter enforces."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "src/agentrob"
PAGE = (ROOT / "docs/inside/architecture.md").read_text(encoding="utf-8")
#: The maximum number of Python files in a folder.
MOST_FILES = 14


def rooms() -> set[str]:
    """Return all packages below `agentrob`, as paths that end in a slash, without the database migrations."""
    found = {path.parent.relative_to(PACKAGE).as_posix() + "/" for path in PACKAGE.rglob("__init__.py")}
    return {room for room in found if room != "./" and "migrations" not in room}


def test_each_room_has_a_line() -> None:
    assert set(re.findall(r"^\| `([a-z_/]+/)` \|", PAGE, re.MULTILINE)) == rooms()


def test_the_layers_are_those_of_import_linter() -> None:
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    layers = next(c["layers"] for c in contracts if c["containers"] == ["agentrob"])
    drawn = re.search(r"^```text\n(cli\n.*?)\n```", PAGE, re.MULTILINE | re.DOTALL)
    assert drawn is not None
    assert drawn[1].split("\n") == [layer for layer in layers if layer != "__main__"]


def test_each_stage_names_an_existing_file() -> None:
    named = re.findall(r"`((?:[a-z_]+/)+(?:[a-z_]+\.py)?)` ?[|,]", PAGE)
    assert len(named) > 10
    assert [path for path in named if not (PACKAGE / path).exists()] == []


def test_folders_are_small_and_nothing_is_loose_at_the_top() -> None:
    for folder in [PACKAGE, *(PACKAGE / room for room in rooms())]:
        files = sorted(path.name for path in folder.glob("*.py"))
        assert len(files) <= MOST_FILES, f"{folder.relative_to(ROOT)}: {len(files)} files"
    assert {path.name for path in PACKAGE.glob("*.py")} == {"__init__.py", "__main__.py", "errors.py", "plugins.py"}
