"""Assembles the HTTP service of one robot's agent and runs it beside the agent in one event loop."""

from __future__ import annotations

import asyncio
import signal
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import structlog
from fastapi import Depends, FastAPI
from fastapi.openapi.utils import get_openapi

from agentrob import __version__
from agentrob.config.service import ServiceConfig
from agentrob.errors import ConfigError
from agentrob.forums.protocol import Forum
from agentrob.model import Report
from agentrob.process.http_server import HttpServer
from agentrob.process.listen import base_url, open_listener
from agentrob.process.problem import Problem, refuse_repeated_parameters
from agentrob.process.webhooks import Outbox, Receiver, read_secret
from agentrob.service import api, auth
from agentrob.service.admission import Admission
from agentrob.service.commands import CommandService
from agentrob.service.dependencies import Parts
from agentrob.service.metrics import ServiceMetrics
from agentrob.service.problem import add_errors

if TYPE_CHECKING:
    from agentrob.agent.agent import RobotAgent

_log = structlog.get_logger()
#: Makes the agent; it calls the given function with each final report.
MakeAgent = Callable[[Callable[[Report], None]], "RobotAgent"]


def create_app(parts: Parts) -> FastAPI:
    """The service as an ASGI app."""
    app = FastAPI(
        title=f"Agent of {parts.commands.agent.name}",
        version=__version__,
        openapi_url="/api/v1/openapi.json",
        docs_url=None,
        redoc_url=None,
    )
    app.state.parts = parts
    app.add_middleware(Admission, hosts=parts.hosts, metrics=parts.metrics)
    app.include_router(api.router, dependencies=[Depends(refuse_repeated_parameters)])
    app.include_router(api.public)
    add_errors(app)

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            document = get_openapi(title=app.title, version=app.version, routes=app.routes)
            components = document.setdefault("components", {})
            components.setdefault("schemas", {})["Problem"] = Problem.model_json_schema()
            components["securitySchemes"] = {"bearer": {"type": "http", "scheme": "bearer"}}
            document["security"] = [{"bearer": []}]
            for path in ("/healthz", "/readyz"):
                document["paths"][path]["get"]["security"] = []
            app.openapi_schema = document
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]
    return app


def assemble(config: ServiceConfig, name: str, make_agent: MakeAgent, open_forum: Callable[[str], Forum]) -> Parts:
    """Make the parts of one robot's service. Raises `ConfigError` for missing secrets."""
    if not config.tokens:
        raise ConfigError("the service has no clients: add a table [service.tokens.NAME] with token_env and scopes")
    receivers = [Receiver(hook, h.url, read_secret(h.secret_env)) for hook, h in config.hooks_out.items()]
    hooks_in = {hook: (h.kind, read_secret(h.secret_env)) for hook, h in config.hooks_in.items()}
    who = auth.configured(config, read_secret, open_forum)
    metrics = ServiceMetrics(name)
    outbox = Outbox(receivers, metrics.webhook_delivered)
    made: list[CommandService] = []

    def ended(report: Report) -> None:
        made[0].ended(report)

    agent = make_agent(ended)
    made.append(CommandService(agent, metrics, outbox))
    return Parts(made[0], who, metrics, outbox, hooks_in, (config.address[0], *config.hosts))


def listen(config: ServiceConfig) -> socket.socket:
    """Open the socket of the address; port 0 takes a free one. Raises `ConfigError`."""
    try:
        return open_listener(*config.address)
    except OSError as e:
        raise ConfigError(f"the service cannot listen on {config.listen}: {e.strerror}; set service.listen") from None


@asynccontextmanager
async def serving(parts: Parts, listener: socket.socket) -> AsyncIterator[asyncio.Task[None]]:
    """Serve until the block ends; yields the task that serves."""
    started = asyncio.Event()
    server = HttpServer(
        create_app(parts), on_ready=started.set, handle_signals=False, lifespan="off", timeout_graceful_shutdown=2
    )
    helpers = [asyncio.create_task(parts.auth.keep_fresh()), asyncio.create_task(parts.outbox.run())]
    running = asyncio.create_task(server.serve(sockets=[listener]))
    try:
        starting = asyncio.create_task(started.wait())
        await asyncio.wait((starting, running), return_when=asyncio.FIRST_COMPLETED)
        starting.cancel()
        yield running
    finally:
        server.should_exit = True
        for helper in helpers:
            helper.cancel()
        await asyncio.gather(running, *helpers, return_exceptions=True)
        await parts.auth.close()


async def serve(parts: Parts, listener: socket.socket, ready: Callable[[str], None]) -> None:
    """Run agent and HTTP server until SIGTERM, Ctrl-C, or the end of either. HTTP starts first, so that a stop does not
    wait for the forum. `ready` is called with the address when the agent receives commands."""
    agent = parts.commands.agent
    url = base_url(*listener.getsockname()[:2])
    ended = asyncio.Event()
    for sign in (signal.SIGTERM, signal.SIGINT):
        asyncio.get_running_loop().add_signal_handler(sign, ended.set)
    await agent.prepare()
    async with serving(parts, listener) as http:
        _log.info("service.serving", robot=agent.name, url=url)
        living = asyncio.create_task(agent.run(lambda: ready(url)))
        ending = asyncio.create_task(ended.wait())
        try:
            await asyncio.wait((http, living, ending), return_when=asyncio.FIRST_COMPLETED)
            if living.done():
                living.result()
        finally:
            ending.cancel()
            living.cancel()
            await asyncio.gather(living, return_exceptions=True)
            await agent.close()
