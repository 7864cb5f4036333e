"""A product HTTP server in a thread, before a memory forum, whose door signs requests in: for suites that cannot."""

from __future__ import annotations

import importlib.util
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
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
from tests.mcp.forum.inside import ALL, a_world

TOKEN = "mcp-token-for-conformance"


@contextmanager
def serving(app: Any, listener: socket.socket) -> Iterator[None]:
    """An ASGI app on a socket, until the end."""
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
    """The SDK's own server of fixtures for the conformance suite, on the engine and HTTP parts that ours stands on."""
    spec = importlib.util.spec_from_file_location("everything_server", Path(__file__).parent / "everything/server.py")
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
    """The forum server, as it is served, with everything allowed; its address."""
    listener = socket.create_server(("127.0.0.1", 0))
    port = listener.getsockname()[1]
    world = a_world()
    users = {"admin": (Identity("admin", world.sign_in("admin"), Rights(True, ALL)), TOKEN, "")}
    app, _ = make_app(McpConfig(listen=f"127.0.0.1:{port}"), users, port)

    with serving(_door(app), listener):
        yield f"http://localhost:{port}/mcp"


@contextmanager
def robot_server() -> Iterator[str]:
    """The robots' server, as it is served, with everything allowed, before a service that is not there."""
    listener = socket.create_server(("127.0.0.1", 0))
    port = listener.getsockname()[1]
    robots = Robots({"quadruped": Service("quadruped", "http://127.0.0.1:9", "token-of-nobody")}, 20)
    server = RobotServer(robots, allowed(McpRobotConfig(preview=True, submit=True)))
    with serving(_door(over_http.make_app(server, TOKEN, "127.0.0.1", port)), listener):
        yield f"http://localhost:{port}/mcp"


def _door(app: Any) -> Any:
    """Signs every request in."""

    async def door(scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] == "http":
            kept = [h for h in scope["headers"] if h[0] != b"authorization"]
            scope = {**scope, "headers": [*kept, (b"authorization", f"Bearer {TOKEN}".encode())]}
        await app(scope, receive, send)

    return door
