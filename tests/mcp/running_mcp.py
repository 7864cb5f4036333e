"""A forum's MCP server for tests: real processes in front of a real board, over stdio or HTTP."""

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

#: The time limit for a server to start.
LIMIT_S = 60.0


@dataclass
class McpSetup:
    """A configuration for stdio and HTTP servers in front of a board."""

    board: RunningBoard
    folder: Path
    mcp: dict[str, Any] = field(default_factory=dict)
    env: dict[str, str] = field(default_factory=dict)

    def user(self, name: str, **settings: Any) -> None:
        """Allow an account of the board to use the server, with the token `mcp-token-for-user-<name>`."""
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
        """The arguments of `agentrob` that start the server."""
        return ["mcp", "forum", "--config", str(self.file()), *more]

    def command(self, *more: str) -> list[str]:
        return [sys.executable, "-m", "agentrob", *self.words(*more)]

    def environment(self, name: str) -> dict[str, str]:
        return {**os.environ, **self.env, "AGENTROB_TOKEN": self.board.tokens[name]}

    def client(self, name: str) -> ForumClient:
        """Return a client with its own stdio server, signed in as an account of the board."""
        command, *args = self.command()
        return ForumClient.spawn(command, *args, env=self.environment(name))

    def stdio(self, name: str, log: Path | None = None, **env: str) -> ForkedCommand:
        """Start an account's stdio server with pipes as standard streams; standard error goes to `log` if given."""
        given = {**self.env, "AGENTROB_TOKEN": self.board.tokens[name], **env}
        return ForkedCommand(self.folder, *self.words(), log=log, feed=True, **given)

    @contextmanager
    def http(self) -> Iterator[str]:
        """Serve over HTTP; yield the URL."""
        process = ForkedCommand(self.folder, *self.words("--http"), log=self.folder / "mcp-http.log", **self.env)
        try:
            yield process.ready["url"]
        finally:
            end_all([process])
