"""Serve the forum's tools over streamable HTTP to several users, each with their own forum account.

Every request needs a valid bearer token. Other hosts and origins are refused, so that web pages cannot reach a server
on loopback.
"""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from mcp.server.auth.settings import AuthSettings
from mcp.server.transport_security import TransportSecuritySettings
from mcp_types.version import HANDSHAKE_PROTOCOL_VERSIONS
from pydantic import AnyHttpUrl
from uvloop import new_event_loop

from agentrob.config.mcp import McpConfig
from agentrob.errors import McpError
from agentrob.mcp.auth import SCOPE, BearerTokenVerifier
from agentrob.mcp.forum.identity import Identity
from agentrob.mcp.forum.server import Context, ForumServer
from agentrob.mcp.forum.subscriptions import SESSION_HEADER
from agentrob.process.child import print_ready
from agentrob.process.http_server import HttpServer
from agentrob.process.listen import base_url, host_in_url, open_listener, parse_listen

if TYPE_CHECKING:
    from starlette.applications import Starlette
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

#: A picture of 8 MiB as base64 in JSON.
MAX_BODY = 12 * 1024 * 1024
PATH = "/mcp"
_VERSION = b"mcp-protocol-version"


def make_app(
    config: McpConfig, users: Mapping[str, tuple[Identity, str, str]], port: int
) -> tuple[ASGIApp, ForumServer]:
    """The ASGI app and its server. `port` is the port in use, even if the configured port is 0."""
    host = _address(config)[0]
    url = config.public_url or base_url(host, port) + PATH
    verifier = BearerTokenVerifier(users, url, config.issuer, config.jwks_url)

    def identify(ctx: Context) -> Identity:
        assert ctx.request is not None
        return verifier.identities[ctx.request.scope["user"].access_token.client_id]

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
            token_verifier=verifier,
        )

    app = _by_era(answering(json_response=True), answering(json_response=False))
    return strip_header_whitespace(_reporting_ended_sessions(app, server)), server


def _by_era(sessions: Starlette, exchanges: Starlette) -> ASGIApp:
    """Answer calls in sessions (before 2026) with JSON, since an event stream per call costs more than most calls and
    updates have a stream of their own. The newer protocol chooses JSON itself for short calls; for long ones it needs
    the stream to notice that a client disconnects, which cancels the call."""

    async def chosen(scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            async with exchanges.router.lifespan_context(exchanges):
                await sessions(scope, receive, send)
            return
        version = _values(scope, _VERSION)
        newer = version and version[0] not in HANDSHAKE_PROTOCOL_VERSIONS
        await (exchanges if newer else sessions)(scope, receive, send)

    return chosen


def _reporting_ended_sessions(app: ASGIApp, server: ForumServer) -> ASGIApp:
    """Notify the server of sessions that clients end, since the SDK does not."""

    async def passed_on(scope: Scope, receive: Receive, send: Send) -> None:
        async def watched(message: Message) -> None:
            if message["type"] == "http.response.start" and message["status"] < 300:
                for session_id in _values(scope, SESSION_HEADER.encode()):
                    server.end_session(session_id)
            await send(message)

        ends = scope["type"] == "http" and scope["method"] == "DELETE"
        await app(scope, receive, watched if ends else send)

    return passed_on


def _values(scope: Scope, header: bytes) -> list[str]:
    return [value.decode("latin-1") for name, value in scope["headers"] if name == header]


def strip_header_whitespace(app: ASGIApp) -> ASGIApp:
    """Remove white space around header values (RFC 9110, 5.5), which the HTTP parser keeps."""

    async def passed_on(scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
            scope = {**scope, "headers": [(name, value.strip(b" \t")) for name, value in scope["headers"]]}
        await app(scope, receive, send)

    return passed_on


def _security(url: str, host: str, port: int) -> TransportSecuritySettings:
    """Accept only requests whose Host is this server and whose Origin, if any, is its address."""
    public = urlsplit(url)
    hosts = {f"{host_in_url(h)}:{port}" for h in (host, "127.0.0.1", "localhost", "::1")} | {public.netloc}
    origins = {f"http://{h}" for h in hosts} | {f"{public.scheme}://{public.netloc}"}
    return TransportSecuritySettings(allowed_hosts=sorted(hosts), allowed_origins=sorted(origins))


def serve(config: McpConfig, users: Mapping[str, tuple[Identity, str, str]]) -> None:
    """Serve until SIGTERM or Ctrl-C; prints the ready line with the address."""
    host, wanted = _address(config)
    try:
        listener = open_listener(host, wanted)
    except OSError as e:
        raise McpError(f"the MCP server cannot listen on {config.listen}: {e.strerror}; set mcp.listen") from None
    port = listener.getsockname()[1]
    app, server = make_app(config, users, port)

    async def run() -> None:
        http = HttpServer(app, on_ready=lambda: print_ready(url=base_url(host, port) + PATH), on_shutdown=server.close)
        try:
            await http.serve(sockets=[listener])
        finally:
            for identity, _, _ in users.values():
                await identity.close()

    with listener, asyncio.Runner(loop_factory=new_event_loop) as runner:
        runner.run(run())


def _address(config: McpConfig) -> tuple[str, int]:
    try:
        return parse_listen(config.listen)
    except ValueError as e:
        raise McpError(f"mcp.listen: {e}") from None
