"""Assembles the embedded forum as an ASGI app and serves it."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import AsyncIterator, Callable, Coroutine, Sequence
from contextlib import asynccontextmanager, nullcontext
from dataclasses import replace
from functools import partial
from typing import Any

import structlog
from fastapi import Depends, FastAPI
from fastapi.openapi.utils import get_openapi
from starlette.requests import Request
from starlette.responses import Response

from agentrob import __version__
from agentrob.board.admin import retention
from agentrob.board.admin.local_admin import bootstrap
from agentrob.board.admin.serving_lock import serve_database
from agentrob.board.api import admin, commands, forum, health, live, moderation, robots
from agentrob.board.api.event_stream import encode
from agentrob.board.command_reading import CommandReader, ReadingQueue
from agentrob.board.content import unread, uploads
from agentrob.board.content.store import Store
from agentrob.board.events import webhooks
from agentrob.board.events.cluster import Cluster
from agentrob.board.events.hub import Hub
from agentrob.board.events.presence import PresenceTracker
from agentrob.board.metrics import BoardMetrics
from agentrob.board.middleware import SecurityMiddleware
from agentrob.board.response_cache import ResponseCache
from agentrob.board.services import Services
from agentrob.board.settings import BoardSettings
from agentrob.board.web import routes
from agentrob.board.web.templating import error_page
from agentrob.errors import BoardError
from agentrob.process.http_server import HttpServer
from agentrob.process.interpreter import prefer_event_loop
from agentrob.process.listen import base_url, open_listener
from agentrob.process.metrics import RequestMetrics, serving_metrics
from agentrob.process.problem import (
    Problem,
    add_error_handlers,
    http_error,
    problem_response,
    refuse_repeated_parameters,
)
from agentrob.process.webhooks import Receiver
from agentrob.semantic.encoder import Encoder, require_model

log = structlog.get_logger(__name__)
#: Tags of the API document, in the order in which the API page shows them.
API_TAGS = {
    "accounts": "Accounts and notifications.",
    "boards": "Boards.",
    "topics": "Topics and their tags.",
    "posts": "Posts and their pictures.",
    "unread": "What an account has not read.",
    "search": "Search for posts, by words or by meaning.",
    "events": "Everything that happens, as a stream or page by page.",
    "robots": "Robots: cards, rights, cameras, and the buttons of a robot's page.",
    "commands": "Records of commands, and approvals.",
    "moderation": "Hide, show, lock and move; for moderators.",
    "administration": "Accounts, tokens, invites, boards and robots; for admins and robots' owners.",
}


def create_app(
    settings: BoardSettings, metrics: BoardMetrics | None = None, reader: Callable[[], CommandReader] | None = None
) -> FastAPI:
    """The forum as an ASGI app. Its database is migrated and opened when the app starts, closed when it ends.

    `reader` makes what reads commands while they are written; without it the forum does not do that.
    """
    receivers = webhooks.receivers(settings)
    if settings.encoder is Encoder:
        require_model()

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        await asyncio.to_thread(bootstrap, settings)
        hub, presence, me = Hub(partial(encode, settings.base_url)), PresenceTracker(), secrets.token_hex(8)
        if metrics is not None:
            metrics.watch(hub)
        store = Store(settings, metrics.counted(hub.published) if metrics is not None else hub.published, me)
        try:
            hub.start(store.everything)
            reading = ReadingQueue(reader) if reader is not None else None
            app.state.services = parts = Services(settings, store, hub, presence, reading=reading)
            background = asyncio.create_task(await _background(parts, me, receivers))
            try:
                yield
            finally:
                end_streams(app)
                background.cancel()
                await asyncio.gather(background, return_exceptions=True)
                if reading is not None:
                    await asyncio.to_thread(reading.close)
                await parts.marks.write(store)
        finally:
            await asyncio.to_thread(store.close)

    app = FastAPI(
        title=settings.title,
        version=__version__,
        lifespan=lifespan,
        generate_unique_id_function=lambda route: route.name,
        openapi_tags=[{"name": name, "description": text} for name, text in API_TAGS.items()],
        openapi_url="/api/v1/openapi.json",
        docs_url=None,
        redoc_url=None,
    )
    app.add_middleware(ResponseCache)
    app.add_middleware(SecurityMiddleware, settings=settings)
    if metrics is not None:
        app.add_middleware(RequestMetrics, registry=metrics.registry)
    for module in (forum, robots, live, commands, moderation, admin, health):
        app.include_router(module.router, dependencies=[Depends(refuse_repeated_parameters)])
    app.include_router(robots.files)
    app.include_router(routes.router)
    _add_errors(app)
    _describe(app, settings)
    return app


async def _background(parts: Services, me: str, receivers: Sequence[Receiver]) -> Coroutine[Any, Any, None]:
    """The background tasks, which run until cancelled. Only one of several processes runs the duties."""

    async def duties(taken_over: bool) -> None:
        pruning = retention.keep_expiring_pictures(parts), retention.keep_pruning(parts)
        await asyncio.gather(*pruning, webhooks.run(parts.hub, receivers, taken_over))

    if parts.settings.shared:
        peers = Cluster(parts.settings, me, parts.hub, parts.presence, duties)
        parts.store.reader.gone = parts.store.everything.gone = lambda: peers.cut_off
        await peers.begin()
        uploads.check_folder(parts.store)
        following = peers.run()
    else:
        following = _follow_alone(parts.hub, duties)

    async def work() -> None:  # every process keeps its own embeddings and read positions
        marking = unread.run_flush_loop(parts.marks, parts.store, parts.settings.shared)
        proving = parts.hub.prove_writing(parts.store.writer.prove)
        await asyncio.gather(following, parts.store.run_embedding_worker(), marking, proving)

    return work()


async def _follow_alone(hub: Hub, duties: Callable[[bool], Coroutine[Any, Any, None]]) -> None:
    await asyncio.gather(hub.follow(), duties(False))


def end_streams(app: FastAPI) -> None:
    """End event and camera streams, which would otherwise keep the server from shutting down."""
    services: Services = app.state.services
    services.hub.close()
    services.presence.close()


def _add_errors(app: FastAPI) -> None:
    async def respond(request: Request, error: Exception) -> Response:
        found = http_error(error)
        if found is not error and found.status == 500:
            log.exception("board.unexpected", path=_logged(request), exc_info=error)
        elif found.status >= 500:
            log.error("board.request_failed", path=_logged(request), code=found.code, error=str(found))
        if request.url.path.startswith("/api/"):
            return problem_response(found)
        return await error_page(request, found)

    add_error_handlers(app, BoardError, respond)


def _logged(request: Request) -> str:
    """The path for the log, without the secret of a one-time link."""
    path = request.url.path
    secret = path.split("/")[1] if path.count("/") > 1 else ""
    return f"/{secret}/…" if secret in ("enter", "invite", "password") else path


def _describe(app: FastAPI, settings: BoardSettings) -> None:
    """Add what the framework does not know to the OpenAPI document: problem details, both ways to sign in, titles."""

    def openapi() -> dict[str, Any]:
        if app.openapi_schema is None:
            document = get_openapi(title=app.title, version=app.version, routes=app.routes, tags=app.openapi_tags)
            document["paths"] = {k: v for k, v in document["paths"].items() if k.startswith("/api/")}
            components = document.setdefault("components", {})
            components.setdefault("schemas", {})["Problem"] = Problem.model_json_schema()
            cookie = {"type": "apiKey", "in": "cookie", "name": settings.cookie}
            cookie["description"] = "a browser's session; writes also need the header X-CSRF-Token"
            components["securitySchemes"] = {"bearer": {"type": "http", "scheme": "bearer"}, "cookie": cookie}
            document["security"] = [{"bearer": []}, {"cookie": []}]
            for operation in (one for methods in document["paths"].values() for one in methods.values()):
                operation["summary"] = operation["operationId"].replace("_", " ").capitalize()
            app.openapi_schema = document
        return app.openapi_schema

    app.openapi = openapi  # type: ignore[method-assign]


# -------------------------------------------------------------------- the process
def make_server(
    app: FastAPI, settings: BoardSettings, ready: Callable[[BoardSettings], None] | None = None
) -> HttpServer:
    """The HTTP server of the app, which ends its streams first when it is shut down."""

    def on_ready() -> None:
        log.info("board.serving", url=settings.base_url, database=settings.database_shown)
        if ready is not None:
            ready(settings)

    async def on_shutdown() -> None:
        end_streams(app)

    return HttpServer(
        app,
        on_ready=on_ready,
        on_shutdown=on_shutdown,
        proxy_headers=bool(settings.trusted_proxies),
        forwarded_allow_ips=list(settings.trusted_proxies),
    )


def serve(
    settings: BoardSettings,
    ready: Callable[[BoardSettings], None] | None = None,
    reader: Callable[[], CommandReader] | None = None,
) -> None:
    """Serve until SIGINT or SIGTERM. Calls `ready` with the settings, real port included, when requests are accepted.
    `reader` is that of `create_app`.

    Raises `BoardError` if the address is taken, another process serves the database, or the database cannot be used.
    """
    try:
        listener = open_listener(settings.host, settings.port)
    except OSError as e:
        where = f"{settings.host}:{settings.port}"
        hint = "set board.listen to another port, or end what listens there"
        raise BoardError(503, "address_taken", f"the forum cannot listen on {where}: {e.strerror}", hint) from None
    with listener:
        if settings.port == 0:
            host, port = listener.getsockname()[:2]
            settings = replace(settings, port=port, base_url=base_url(host, port))
        prefer_event_loop()
        with serve_database(settings):
            metrics = BoardMetrics() if settings.metrics else None
            with serving_metrics(metrics.registry, settings.metrics) if metrics else nullcontext():
                make_server(create_app(settings, metrics, reader), settings, ready).run(sockets=[listener])
            log.info("board.ended")
