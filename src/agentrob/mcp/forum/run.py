"""Runs the MCP servers as a configuration says: whose tokens they hold, and what they allow."""

from __future__ import annotations

import importlib
import os
from collections.abc import Mapping

from agentrob.config.load import Config
from agentrob.config.mcp import McpUserConfig
from agentrob.errors import ConfigError
from agentrob.mcp.forum.identity import Accounts, Identity, OpenForum, Rights


def prepare(http: bool) -> None:
    """Import what a server needs."""
    importlib.import_module(f"agentrob.mcp.forum.{'http' if http else 'stdio'}")


def run_stdio(config: Config, open_forum: OpenForum, token: str, write: bool) -> None:
    """Serve one client until it closes its end. `token` signs in the account of `[forum]`."""
    from agentrob.mcp.forum.stdio import run

    rights = Rights(write, frozenset(config.mcp.toolsets))
    tokens = {name: found for name, user in config.mcp.users.items() if (found := _secret(user.forum_token_env))}

    def make() -> Accounts:
        return Accounts(Identity("(the account of [forum])", open_forum(token), rights), open_forum, tokens)

    run(make)


def run_http(config: Config, open_forum: OpenForum) -> None:
    """Serve the configured users over streamable HTTP until SIGTERM or Ctrl-C."""
    from agentrob.mcp.forum.http import serve

    serve(config.mcp, http_users(config.mcp.users, open_forum))


def http_users(users: Mapping[str, McpUserConfig], open_forum: OpenForum) -> dict[str, tuple[Identity, str, str]]:
    """For each user its identity, its static token (or "") and its OAuth subject (or "")."""
    found: dict[str, tuple[Identity, str, str]] = {}
    for name, user in users.items():
        forum_token = _secret(user.forum_token_env)
        if not forum_token:
            raise ConfigError(f"the environment variable {user.forum_token_env} must hold {name}'s forum token")
        token = _secret(user.token_env) if user.token_env else ""
        if user.token_env and len(token) < 16:
            raise ConfigError(f"the environment variable {user.token_env} must hold a token of at least 16 characters")
        if not token and not user.subject:
            continue  # only for stdio
        identity = Identity(name, open_forum(forum_token), Rights(user.write, frozenset(user.toolsets)))
        found[name] = (identity, token, user.subject)
    tokens = [token for _, token, _ in found.values() if token]
    if len(set(tokens)) != len(tokens):
        raise ConfigError("two users of [mcp.users] have the same token; nobody could tell them apart")
    if not found:
        raise ConfigError("nobody may connect: [mcp.users.NAME] needs token_env or subject, and forum_token_env")
    return found


def _secret(variable: str) -> str:
    return os.environ.get(variable, "")
