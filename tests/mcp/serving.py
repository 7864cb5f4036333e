"""Serve the product's MCP servers in a thread, and add the bearer token for test suites that cannot send one."""

from __future__ import annotations

import importlib.util
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

import uvicorn

from agentrob.config.mcp import McpConfig
from agentrob.config.service import McpRobotConfig
from agentrob.mcp.forum.http import make_app, strip_header_whitespace
from agentrob.mcp.forum.identity import Identity, Rights
from agentrob.mcp.robots import http as over_http
from agentrob.mcp.robots.server import RobotServer
from agentrob.mcp.robots.service_client import Robots, Service
from agentrob.mcp.robots.tools import allowed
from tests.mcp.forum.inside import ALL, memory_world

TOKEN = "mcp-token-for-conformance"


@contextmanager
def serving(app: Any, listener: socket.socket) -> Iterator[None]:
    """Serve an ASGI app on a socket until the block ends."""
    server = uvicorn.Server(uvicorn.Config(app, log_config=None, access_log=False, lifespan="on",
                                           timeout_graceful_shutdown=1))  # fmt: skip
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
    thread.start()
    try:
        yield
    finally:
        server.should_exit = True
        thread.join(60)
        listener.close()


@contextmanager
def fixture_server() -> Iterator[str]:
    """Serve the SDK's conformance server, which has all fixtures, with our servers' SDK version and HTTP middleware."""
    path = Path(__file__).parent / f"node/node_modules/everything-server-{version('mcp')}.py"
    assert path.is_file(), "the SDK's conformance server is not installed: run scripts/mcp-peers"
    spec = importlib.util.spec_from_file_location("everything_server", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    listener = socket.create_server(("127.0.0.1", 0))
    app = module.mcp.streamable_http_app(event_store=module.event_store, retry_interval=100)
    with serving(strip_header_whitespace(app), listener):
        yield f"http://localhost:{listener.getsockname()[1]}/mcp"


@contextmanager
def forum_server() -> Iterator[str]:
    """Serve the forum's MCP server over HTTP with all rights; yield its URL."""
    listener = socket.create_server(("127.0.0.1", 0))
    port = listener.getsockname()[1]
    world = memory_world()
    users = {"admin": (Identity("admin", world.sign_in("admin"), Rights(True, ALL)), TOKEN, "")}
    app, _ = make_app(McpConfig(listen=f"127.0.0.1:{port}"), users, port)

    with serving(_signed_in(app), listener):
        yield f"http://localhost:{port}/mcp"


@contextmanager
def robot_server() -> Iterator[str]:
    """Serve the robots' MCP server over HTTP with all rights; the service of its robot does not exist."""
    listener = socket.create_server(("127.0.0.1", 0))
    port = listener.getsockname()[1]
    robots = Robots({"quadruped": Service("quadruped", "http://127.0.0.1:9", "token-of-nobody")}, 20)
    server = RobotServer(robots, allowed(McpRobotConfig(preview=True, submit=True)))
    with serving(_signed_in(over_http.make_app(server, TOKEN, "127.0.0.1", port)), listener):
        yield f"http://localhost:{port}/mcp"


def _signed_in(app: Any) -> Any:
    """Add the token to every request."""

    async def signed_in(scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] == "http":
            kept = [h for h in scope["headers"] if h[0] != b"authorization"]
            scope = {**scope, "headers": [*kept, (b"authorization", f"Bearer {TOKEN}".encode())]}
        await app(scope, receive, send)

    return signed_in
