"""What is imported: the client needs the SDK and pydantic only, and a server leaves the SDK as it found it."""

from __future__ import annotations

import subprocess
import sys

import pytest


def imported(code: str) -> set[str]:
    """The libraries that are there after some code, in a process of its own."""
    said = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys; print(*{{m.partition('.')[0] for m in sys.modules}})"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return set(said.stdout.split())


@pytest.mark.parametrize("module", ["agentrob.mcp.client", "agentrob.mcp.forum", "agentrob.mcp.metadata"])
def test_the_client_is_usable_without_the_heavy_parts(module: str) -> None:
    heavy = {"numpy", "sqlalchemy", "fastapi", "matplotlib", "PIL", "mujoco", "cyclonedds", "dbos", "typer", "mcp"}
    assert not imported(f"import {module}") & heavy, "even the SDK is imported when it is first needed"


def test_after_a_quick_import_the_sdk_is_whole_again() -> None:
    code = """
from agentrob.quick import quick_imports
with quick_imports(folders=("mcp", "mcp.server"), without=("rich", "uvicorn")):
    import agentrob.mcp.stdio
import sys
assert not {"mcp.client.client", "uvicorn"} & set(sys.modules)
import uvicorn, agentrob.mcp.streamable
from mcp import Client, ClientSession
from mcp.server import MCPServer
import mcp.server.lowlevel, rich
assert mcp.server.lowlevel.Server is agentrob.mcp.server.Server
import gc
assert gc.isenabled()
"""
    assert "mcp" in imported(code)
