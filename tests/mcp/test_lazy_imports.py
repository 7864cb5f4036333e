"""Imports: the client needs the SDK and pydantic only, and heavy libraries are imported when they are needed."""

from __future__ import annotations

import subprocess
import sys

import pytest


def imported(code: str) -> set[str]:
    """Run code in a new process; return the libraries that it imported."""
    said = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys; print(*{{m.partition('.')[0] for m in sys.modules}})"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert said.returncode == 0, said.stderr
    return set(said.stdout.split())


@pytest.mark.parametrize("module", ["agentrob.mcp.client", "agentrob.mcp.adapter", "agentrob.mcp.metadata"])
def test_the_client_is_usable_without_the_heavy_parts(module: str) -> None:
    heavy = {"numpy", "sqlalchemy", "fastapi", "matplotlib", "PIL", "mujoco", "cyclonedds", "typer", "mcp"}
    assert not imported(f"import {module}") & heavy, "even the SDK is imported when it is first needed"


def test_a_server_imports_no_part_of_the_product_that_it_does_not_need() -> None:
    heavy = {"numpy", "sqlalchemy", "fastapi", "matplotlib", "PIL", "mujoco", "cyclonedds"}
    assert "mcp" in (libraries := imported("import agentrob.mcp.forum.run"))
    assert not libraries & heavy


def test_the_command_line_imports_no_library_before_a_command_needs_it() -> None:
    heavy = {"numpy", "sqlalchemy", "fastapi", "matplotlib", "PIL", "mujoco", "cyclonedds", "mcp", "uvicorn"}
    assert not imported("import agentrob.cli.main") & heavy


def test_garbage_is_collected_again_after_the_imports() -> None:
    use = "with importing():\n    import json\nassert gc.isenabled()"
    imported(f"import gc\nfrom agentrob.process.interpreter import importing\n{use}")
