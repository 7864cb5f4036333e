"""Prometheus metrics of a process: the address that offers them, and the counting of HTTP requests."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from prometheus_client import CollectorRegistry, Counter, Histogram, start_http_server
from prometheus_client.process_collector import ProcessCollector

from agentrob.errors import ConfigError
from agentrob.process.listen import base_url, parse_listen

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

#: Buckets of what takes milliseconds when all is well: stops, first answers, requests.
FAST_S = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5)
_METHODS = frozenset({"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"})


def new_registry() -> CollectorRegistry:
    """A registry with the memory and processor time of this process."""
    registry = CollectorRegistry()
    ProcessCollector(registry=registry)
    return registry


@contextmanager
def serving_metrics(registry: CollectorRegistry, listen: str) -> Iterator[str]:
    """Offer the metrics at `http://LISTEN/metrics` while the block runs, on a thread of its own: a scrape never delays
    a stop. Yields the address. Raises `ConfigError` if it is taken."""
    host, port = parse_listen(listen)
    try:
        server, thread = start_http_server(port, host, registry)
    except OSError as e:
        raise ConfigError(f"the metrics cannot be offered at {listen}: {e.strerror or e}") from None
    try:
        yield base_url(host, server.server_port)
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


class RequestMetrics:
    """ASGI middleware that counts requests and measures the time until their response starts."""

    def __init__(self, app: ASGIApp, registry: CollectorRegistry) -> None:
        self.app = app
        self._requests = Counter(
            "agentrob_http_requests", "Requests answered.", ["method", "status"], registry=registry
        )
        self._took = Histogram(
            "agentrob_http_request_seconds",
            "From the request to the start of its response.",
            ["method"],
            buckets=FAST_S,
            registry=registry,
        )

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return await self.app(scope, receive, send)
        begun_s = time.monotonic()
        method = scope["method"] if scope["method"] in _METHODS else "other"

        async def counted(message: Message) -> None:
            if message["type"] == "http.response.start":
                self._requests.labels(method, str(message["status"])).inc()
                self._took.labels(method).observe(time.monotonic() - begun_s)
            await send(message)

        await self.app(scope, receive, counted)
