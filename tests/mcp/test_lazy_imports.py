"""What is imported: the client needs the SDK and pydantic only, and a server leaves the SDK as it found it."""

from __future__ import annotations

import subprocess
import sys

import pytest


def imported(code: str) -> set[str]:
    """The libraries that are there after some code, in a process of its own."""
    said = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys; print(*{{m.partition('.')[0] for m in sys.modules}})"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert said.returncode == 0, said.stderr
    return set(said.stdout.split())


@pytest.mark.parametrize("module", ["agentrob.mcp.client", "agentrob.mcp.adapter", "agentrob.mcp.metadata"])
def test_the_client_is_usable_without_the_heavy_parts(module: str) -> None:
    heavy = {"numpy", "sqlalchemy", "fastapi", "matplotlib", "PIL", "mujoco", "cyclonedds", "dbos", "typer", "mcp"}
    assert not imported(f"import {module}") & heavy, "even the SDK is imported when it is first needed"


def test_after_a_quick_import_the_sdk_is_whole_again() -> None:
    code = """
from agentrob.mcp.sdk import sdk_imports
with sdk_imports(http=False):
    import agentrob.mcp.forum.stdio
import sys
later = {"mcp.client.client", "uvicorn", "greenlet", "mcp.server.auth.provider"}
assert not {*later, "mcp_types._v2025_11_25", "mcp_types._v2026_07_28"} & set(sys.modules)
import mcp_types
from pydantic import BaseModel, TypeAdapter
assert not mcp_types.ListRootsResult.__pydantic_complete__, "built when it is first used"
assert mcp_types.ListRootsResult(roots=[]).model_dump() == {"roots": [], "meta": None}
class Built(BaseModel):
    number: int
assert Built.__pydantic_complete__ and TypeAdapter(Built | None).pydantic_complete
import uvicorn, agentrob.mcp.forum.http
from mcp import Client, ClientSession
from mcp.server import MCPServer
import mcp.server.lowlevel, rich
assert mcp.server.lowlevel.Server is agentrob.mcp.forum.server.Server
import starlette.applications, starlette.routing
assert isinstance(mcp.server.lowlevel.server.Route("/", endpoint=print), starlette.routing.Route)
import gc
assert gc.isenabled()
"""
    assert "mcp" in imported(code)
