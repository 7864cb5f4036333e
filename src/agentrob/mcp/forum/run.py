"""Run the forum's MCP server over stdio or HTTP."""

from __future__ import annotations

import asyncio
import contextlib
import os
from collections.abc import Callable, Mapping

import structlog

from agentrob.config.load import Config
from agentrob.config.mcp import McpUserConfig
from agentrob.errors import ConfigError, ForumDenied, ForumError
from agentrob.mcp.forum.identity import Accounts, Identity, OpenForum, Rights
from agentrob.mcp.forum.server import ForumServer
from agentrob.mcp.stdio import serve_stdio

_log = structlog.get_logger()


def run_stdio(config: Config, open_forum: OpenForum, token: str, write: bool) -> None:
    """Serve one client until it closes standard input. `token` signs in the account of `[forum]`."""
    rights = Rights(write, frozenset(config.mcp.toolsets))
    tokens = {name: found for name, user in config.mcp.users.items() if (found := _secret(user.forum_token_env))}

    def make() -> Accounts:
        return Accounts(Identity("(the account of [forum])", open_forum(token), rights), open_forum, tokens)

    serve_accounts(make)


def serve_accounts(make: Callable[[], Accounts]) -> None:
    """Serve the accounts of one client over stdio; `make` is called in the event loop."""
    from uvloop import new_event_loop

    async def main() -> None:
        await _serve(make())

    with asyncio.Runner(loop_factory=new_event_loop) as runner:
        runner.run(main())


async def _serve(accounts: Accounts) -> None:
    server = ForumServer(lambda _: accounts.current, accounts)
    checking = asyncio.create_task(_check(accounts.current))
    try:
        await serve_stdio(server.engine, server.options())
    finally:
        checking.cancel()
        await server.close()
        await accounts.close()


async def _check(identity: Identity) -> None:
    """Log an error if the forum rejects the token. If the forum is unreachable, the first tool call tries again."""
    with contextlib.suppress(ForumError):
        try:
            await identity.me()
        except ForumDenied as e:
            _log.error("the forum refuses the token, so every tool will", error=str(e))


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
        raise ConfigError("two users of [mcp.users] have the same token; each needs its own")
    if not found:
        raise ConfigError("nobody may connect: [mcp.users.NAME] needs token_env or subject, and forum_token_env")
    return found


def _secret(variable: str) -> str:
    return os.environ.get(variable, "")
