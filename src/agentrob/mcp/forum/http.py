"""Serves the forum's tools over streamable HTTP: several users, each with an account of the forum of its own.

Nobody is anonymous: without a valid bearer token nothing is answered but where to get one. Foreign hosts and origins
are refused, so that no web page reaches a server on loopback.
"""

from __future__ import annotations

import signal
import socket
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

import uvicorn
from mcp.server.auth.settings import AuthSettings
from mcp.server.transport_security import TransportSecuritySettings
from mcp_types.version import HANDSHAKE_PROTOCOL_VERSIONS
from pydantic import AnyHttpUrl

from agentrob.config.mcp import McpConfig
from agentrob.errors import McpError
from agentrob.mcp.auth import SCOPE, Bearers
from agentrob.mcp.forum.identity import Identity
from agentrob.mcp.forum.server import Context, ForumServer
from agentrob.process.child import say_ready

if TYPE_CHECKING:
    from starlette.applications import Starlette
    from starlette.types import ASGIApp, Receive, Scope, Send

#: A picture of 8 MiB as base64 in JSON.
MAX_BODY = 12 * 1024 * 1024
PATH = "/mcp"
_VERSION = b"mcp-protocol-version"


def make_app(
    config: McpConfig, users: Mapping[str, tuple[Identity, str, str]], port: int
) -> tuple[ASGIApp, ForumServer]:
    """The ASGI app and its server. `port` is the real one, where any free one was asked for."""
    host = _host_port(config.listen)[0]
    url = config.public_url or f"http://{_bracketed(host)}:{port}{PATH}"
    bearers = Bearers(users, url, config.issuer, config.jwks_url)

    def identify(ctx: Context) -> Identity:
        assert ctx.request is not None
        return bearers.identities[ctx.request.scope["user"].access_token.client_id]

    server = ForumServer(identify)
    auth = AuthSettings(
        issuer_url=AnyHttpUrl(config.issuer or url),
        resource_server_url=AnyHttpUrl(url) if config.issuer else None,
        required_scopes=[SCOPE],
        validate_token_resource=bool(config.issuer),
    )

    def answering(json_response: bool) -> Starlette:
        return server.engine.streamable_http_app(
            streamable_http_path=PATH,
            json_response=json_response,
            max_request_body_size=MAX_BODY,
            transport_security=_security(url, host, port),
            auth=auth,
            token_verifier=bearers,
        )

    return trimmed(_by_era(answering(json_response=True), answering(json_response=False))), server


def _by_era(sessions: Starlette, exchanges: Starlette) -> ASGIApp:
    """Calls in sessions (before 2026) are answered with JSON: a stream for each costs more than most calls, and what is
    pushed has a stream of its own. The newer protocol answers so by itself, unless it takes long; and there a client
    that leaves takes its call back, which JSON alone would not notice."""

    async def chosen(scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            async with exchanges.router.lifespan_context(exchanges):
                await sessions(scope, receive, send)
            return
        told = [value.decode("latin-1") for name, value in scope["headers"] if name == _VERSION]
        newer = told and told[0] not in HANDSHAKE_PROTOCOL_VERSIONS
        await (exchanges if newer else sessions)(scope, receive, send)

    return chosen


def trimmed(app: ASGIApp) -> ASGIApp:
    """White space around a header's value is none of it (RFC 9110, 5.5); the HTTP parser leaves it there."""

    async def passed_on(scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
            scope = {**scope, "headers": [(name, value.strip(b" \t")) for name, value in scope["headers"]]}
        await app(scope, receive, send)

    return passed_on


def _security(url: str, host: str, port: int) -> TransportSecuritySettings:
    """Requests must be meant for this server, and pages only of its own address may send them."""
    public = urlsplit(url)
    hosts = {f"{_bracketed(h)}:{port}" for h in (host, "127.0.0.1", "localhost", "::1")} | {public.netloc}
    origins = {f"http://{h}" for h in hosts} | {f"{public.scheme}://{public.netloc}"}
    return TransportSecuritySettings(allowed_hosts=sorted(hosts), allowed_origins=sorted(origins))


def serve(config: McpConfig, users: Mapping[str, tuple[Identity, str, str]]) -> None:
    """Serve until SIGTERM or Ctrl-C; prints the ready line with the address."""
    host, wanted = _host_port(config.listen)
    try:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        listener = socket.create_server((host, wanted), family=family, backlog=512)
    except OSError as e:
        raise McpError(f"the MCP server cannot listen on {config.listen}: {e.strerror}; set mcp.listen") from None
    port = listener.getsockname()[1]
    app, server = make_app(config, users, port)
    settings = uvicorn.Config(
        app, log_config=None, access_log=False, server_header=False, timeout_graceful_shutdown=1, lifespan="on"
    )
    with listener:
        _Http(settings, f"http://{_bracketed(host)}:{port}{PATH}", server, users).run(sockets=[listener])


class _Http(uvicorn.Server):
    """uvicorn that says when it is ready, and ends its watches and forums in order."""

    def __init__(self, config: uvicorn.Config, url: str, server: ForumServer, users: Mapping[str, Any]) -> None:
        super().__init__(config)
        self._url, self._forum_server, self._users = url, server, users

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup(sockets)
        say_ready(url=self._url)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        await self._forum_server.close()
        await super().shutdown(sockets)
        for identity, _, _ in self._users.values():
            await identity.close()

    def handle_exit(self, sig: int, frame: Any) -> None:
        """The first signal ends in order; it is not sent to us again afterwards."""
        super().handle_exit(sig, frame)
        self._captured_signals.clear()
        signal.signal(sig, signal.SIG_DFL)


def _host_port(listen: str) -> tuple[str, int]:
    parts = urlsplit(f"//{listen}")
    try:
        if parts.hostname and parts.port is not None:
            return parts.hostname, parts.port
    except ValueError:
        pass
    raise McpError(f"mcp.listen must be host:port, for example 127.0.0.1:8090; found {listen!r}")


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host else host
