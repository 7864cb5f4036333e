"""The public names of the package: they import, are documented, and are all that the examples need."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import agentrob
from scripts.documentation import python_api

ROOT = Path(__file__).parents[2]
STUB = ROOT / "src/agentrob/__init__.pyi"
#: What the conversation of docs/agents/mcp.md shows needs more than the client.
NOT_ONLY_PUBLIC = {"mcp_photo.py"}


@pytest.mark.parametrize("name", agentrob.__all__)
def test_a_public_name_is_imported(name: str) -> None:
    assert getattr(agentrob, name) is not None


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="has no attribute 'drive_h1_robot'"):
        agentrob.drive_h1_robot  # noqa: B018


def test_type_checkers_find_the_same_names_in_the_same_modules() -> None:
    told: dict[str, set[str]] = {}
    for node in ast.parse(STUB.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom):
            module = (node.module or "").removeprefix("agentrob.")
            told.setdefault(module, set()).update(name.name for name in node.names)
    assert told == {module: set(names) for module, names in agentrob.PUBLIC.items()}


def test_nothing_is_imported_before_it_is_used() -> None:
    code = "import sys, agentrob; print([m for m in sys.modules if m.startswith('agentrob.')])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=100, check=True)
    assert done.stdout.strip() == "[]"


def test_the_reference_has_a_section_for_each_public_name() -> None:
    documented = [module for modules in python_api.SECTIONS.values() for module in modules]
    assert sorted(documented) == sorted(agentrob.PUBLIC)
    page = python_api.page()
    missing = [name for name in agentrob.__all__ if name != "__version__" and f"### {name} " not in page]
    assert missing == []


@pytest.mark.parametrize(
    "path",
    [p for p in sorted((ROOT / "examples").rglob("*.py")) if p.name not in NOT_ONLY_PUBLIC],
    ids=lambda p: p.name,
)
def test_an_example_imports_only_public_names(path: Path) -> None:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "agentrob":
            assert node.module == "agentrob", f"line {node.lineno}: import from agentrob itself"
            assert {name.name for name in node.names} <= set(agentrob.__all__)
