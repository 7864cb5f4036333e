"""Serves the robots' tools over streamable HTTP; every request needs the server's bearer token."""

from __future__ import annotations

import asyncio
import hmac
import os
from typing import TYPE_CHECKING

from mcp.server.auth.provider import AccessToken
from mcp.server.auth.settings import AuthSettings
from mcp.server.transport_security import TransportSecuritySettings
from pydantic import AnyHttpUrl

from agentrob.config.service import McpRobotConfig
from agentrob.errors import ConfigError
from agentrob.mcp.forum.http import PATH, strip_header_whitespace
from agentrob.mcp.robots.server import RobotServer, configured
from agentrob.mcp.robots.tools import allowed
from agentrob.process.child import print_ready
from agentrob.process.http_server import HttpServer
from agentrob.process.listen import base_url, host_in_url, open_listener

if TYPE_CHECKING:
    from starlette.types import ASGIApp

SCOPE = "robots"
SHORTEST = 16


class StaticTokenVerifier:
    """Verifies the one bearer token."""

    def __init__(self, token: str) -> None:
        self._token = token.encode()

    async def verify_token(self, token: str) -> AccessToken | None:
        if not hmac.compare_digest(self._token, token.encode("utf-8", "surrogatepass")):
            return None
        return AccessToken(token="", client_id="robots", scopes=[SCOPE])


def make_app(server: RobotServer, token: str, host: str, port: int) -> ASGIApp:
    """The ASGI app. It accepts only requests whose Host is this address and whose Origin, if any, is it too."""
    hosts = sorted({f"{name}:{port}" for name in (host_in_url(host), "127.0.0.1", "localhost", "[::1]")})
    app = server.engine.streamable_http_app(
        streamable_http_path=PATH,
        max_request_body_size=256 * 1024,
        transport_security=TransportSecuritySettings(
            allowed_hosts=hosts, allowed_origins=[f"http://{name}" for name in hosts]
        ),
        auth=AuthSettings(
            issuer_url=AnyHttpUrl(base_url(host, port) + PATH),
            resource_server_url=None,
            required_scopes=[SCOPE],
        ),
        token_verifier=StaticTokenVerifier(token),
    )
    return strip_header_whitespace(app)


def run(config: McpRobotConfig) -> None:
    """Serve until SIGTERM or Ctrl-C; prints the ready line with the address. Raises `ConfigError`."""
    token = os.environ.get(config.token_env, "") if config.token_env else ""
    if len(token) < SHORTEST:
        raise ConfigError(f"mcp_robot.token_env must name a variable with a token of at least {SHORTEST} characters")
    host, wanted = config.address
    try:
        listener = open_listener(host, wanted)
    except OSError as e:
        raise ConfigError(f"cannot listen on {config.listen}: {e.strerror}; set mcp_robot.listen") from None

    async def serve() -> None:
        robots = configured(config)
        port = listener.getsockname()[1]
        app = make_app(RobotServer(robots, allowed(config)), token, host, port)
        url = base_url(host, port) + PATH
        try:
            await HttpServer(app, on_ready=lambda: print_ready(url=url)).serve(sockets=[listener])
        finally:
            await robots.close()

    with listener:
        asyncio.run(serve())
