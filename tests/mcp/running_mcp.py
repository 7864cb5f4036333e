"""A forum's MCP server for tests: real processes before a real board, over stdio or HTTP."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from agentrob.mcp.client import ForumClient
from tests.board.running_board import RunningBoard
from tests.forked_process import ForkedCommand, end_all

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

    def words(self, *more: str) -> list[str]:
        """What `agentrob` is given to serve."""
        return ["mcp", "forum", "--config", str(self.file()), *more]

    def command(self, *more: str) -> list[str]:
        return [sys.executable, "-m", "agentrob", *self.words(*more)]

    def environment(self, name: str) -> dict[str, str]:
        return {**os.environ, **self.env, "AGENTROB_TOKEN": self.board.tokens[name]}

    def client(self, name: str) -> ForumClient:
        """A client with a stdio server of its own, signed in as an account of the board."""
        command, *args = self.command()
        return ForumClient.spawn(command, *args, env=self.environment(name))

    def stdio(self, name: str, log: Path | None = None, **env: str) -> ForkedCommand:
        """A stdio server of an account, whose standard streams are pipes, but for standard error with a `log`."""
        given = {**self.env, "AGENTROB_TOKEN": self.board.tokens[name], **env}
        return ForkedCommand(self.folder, *self.words(), log=log, feed=True, **given)

    @contextmanager
    def http(self) -> Iterator[str]:
        """A served HTTP server; its address."""
        process = ForkedCommand(self.folder, *self.words("--http"), log=self.folder / "mcp-http.log", **self.env)
        try:
            yield process.ready["url"]
        finally:
            end_all([process])
