"""A forum's MCP server for tests: real processes before a real board, over stdio or HTTP."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from threading import Timer
from typing import Any

from agentrob.mcp.client import ForumClient
from tests.board.running_board import RunningBoard

#: A server must have started within this.
LIMIT_S = 60.0


@dataclass
class McpSetup:
    """A configuration before a board, for servers of either kind."""

    board: RunningBoard
    folder: Path
    mcp: dict[str, Any] = field(default_factory=dict)
    env: dict[str, str] = field(default_factory=dict)

    def user(self, name: str, **settings: Any) -> None:
        """Let an account of the board in, with the token `mcp-token-for-user-<name>`."""
        forum, token = f"FORUM_OF_{name.upper()}", f"MCP_OF_{name.upper()}"
        self.env |= {forum: self.board.tokens[name], token: f"mcp-token-for-user-{name}"}
        users = self.mcp.setdefault("users", {})
        users[name] = {"forum_token_env": forum, "token_env": token, **settings}

    def file(self) -> Path:
        import tomli_w

        path = self.folder / "agentrob.toml"
        path.write_text(tomli_w.dumps({"forum": {"url": self.board.url}, "mcp": self.mcp}))
        return path

    def command(self, *more: str) -> list[str]:
        return [sys.executable, "-m", "agentrob", "mcp", "forum", "--config", str(self.file()), *more]

    def environment(self, name: str) -> dict[str, str]:
        return {**os.environ, **self.env, "AGENTROB_TOKEN": self.board.tokens[name]}

    def client(self, name: str) -> ForumClient:
        """A client with a stdio server of its own, signed in as an account of the board."""
        command, *args = self.command()
        return ForumClient.spawn(command, *args, env=self.environment(name))

    @contextmanager
    def http(self) -> Iterator[str]:
        """A served HTTP server; its address."""
        process = subprocess.Popen(
            self.command("--http"), env={**os.environ, **self.env}, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL
        )
        watch = Timer(LIMIT_S, process.kill)
        watch.start()
        try:
            assert process.stdout is not None
            url = json.loads(process.stdout.readline())["url"]
            watch.cancel()
            yield url
        finally:
            watch.cancel()
            process.terminate()
            try:
                process.wait(60)
            finally:
                process.kill()
                if process.stdout:
                    process.stdout.close()
