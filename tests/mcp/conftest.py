"""A board for the MCP tests, one per module; each test uses unique names for its content."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.board.running_board import RunningBoard, running_board
from tests.mcp.running_mcp import McpSetup


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningBoard]:
    with running_board(tmp_path_factory.mktemp("board")) as running:
        yield running


@pytest.fixture
def setup(board: RunningBoard, tmp_path: Path) -> McpSetup:
    everything = {"write": True, "toolsets": ["core", "social", "admin"], "listen": "127.0.0.1:0"}
    return McpSetup(board, tmp_path, everything)
