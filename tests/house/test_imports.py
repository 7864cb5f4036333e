"""Every imported library is a declared dependency, not only a dependency of another library."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from importlib.metadata import packages_distributions
from itertools import chain
from pathlib import Path

from tests.house.sources import nodes

ROOT = Path(__file__).parents[2]


def spelled(name: str) -> str:
    return name.lower().replace("_", "-")


def imported(file: Path) -> Iterator[str]:
    """Return the top-level modules that a file imports."""
    for node in nodes(file):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module.partition(".")[0]


def test_every_imported_library_is_listed_in_pyproject() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    wanted = [*project["dependencies"], *chain.from_iterable(project["optional-dependencies"].values())]
    named = {spelled(re.split(r"[^\w.-]", line)[0]) for line in wanted}
    known = packages_distributions()
    ours = sys.stdlib_module_names | {"agentrob"}
    missing = {
        f"{library} ({file.relative_to(ROOT)})"
        for file in (ROOT / "src/agentrob").rglob("*.py")
        for library in imported(file)
        if library not in ours and not {spelled(name) for name in known.get(library, [library])} & named
    }
    assert not missing
