"""Shared by all HTTP adapters: user agent, origin check, server clock, retry delays, error translation."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager
from contextvars import ContextVar
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime
from typing import Any

import httpx2

from agentrob.errors import AgentRobError, ForumError, ForumMalformed, ForumUnreachable
from agentrob.process.tls import tls

#: NodeBB gives no CSRF token to names that look like spiders (`python-requests/…`, `…Bot/`).
USER_AGENT = "AgentRob/0.1"
#: Longer waits are cut to an hour, in case the forum is wrong.
LONGEST_RETRY_S = 3600.0
#: Idle connections that the robots of a worker keep open. Each request checks all of them.
MAX_IDLE = 6
_shared: ContextVar[httpx2.AsyncHTTPTransport | None] = ContextVar("shared connections", default=None)


def http_client(url: str, timeout_s: float, **options: Any) -> httpx2.AsyncClient:
    """A client of the forum at `url`. `options` are those of `httpx2.AsyncClient`.

    Within `shared_connections` it takes its connections from there.
    """
    pool = _shared.get()
    options["headers"] = {"User-Agent": USER_AGENT, **options.get("headers", {})}
    return httpx2.AsyncClient(
        base_url=url.rstrip("/"),
        timeout=httpx2.Timeout(timeout_s, connect=5.0),
        trust_env=False,
        verify=tls(),
        transport=None if pool is None else _SharedTransport(pool),
        **options,
    )


@asynccontextmanager
async def shared_connections() -> AsyncIterator[None]:
    """Clients that are made in this block share connections, which are closed with it. Their number is not limited: a
    stop never waits for a free one."""
    async with httpx2.AsyncHTTPTransport(
        verify=tls(), trust_env=False, limits=httpx2.Limits(max_connections=None, max_keepalive_connections=MAX_IDLE)
    ) as pool:
        token = _shared.set(pool)
        try:
            yield
        finally:
            _shared.reset(token)


class _SharedTransport(httpx2.AsyncBaseTransport):
    """Connections of a pool that stay open when one of its clients is closed."""

    def __init__(self, pool: httpx2.AsyncHTTPTransport) -> None:
        self._pool = pool

    async def handle_async_request(self, request: httpx2.Request) -> httpx2.Response:
        return await self._pool.handle_async_request(request)


@contextmanager
def translate_errors(forum: str = "the forum") -> Iterator[None]:
    """Turn errors of the transport into `ForumUnreachable`, and answers outside of the API into `ForumError`."""
    try:
        yield
    except httpx2.TransportError as e:
        raise ForumUnreachable(f"{forum} does not answer: {type(e).__name__} {e}".rstrip()) from None
    except (httpx2.HTTPError, httpx2.InvalidURL, httpx2.SSEError, httpx2.StreamError) as e:
        raise ForumError(f"{forum} cannot be used: {e}") from None
    except AgentRobError:
        raise
    except Exception as e:  # parsing may raise anything, even OverflowError or RecursionError
        raise ForumMalformed(f"{forum} sent an answer that is not in its API: {e!r}"[:500]) from None


def text_of(value: object) -> str:
    """Return a text without lone surrogates, which cannot be hashed, stored or sent."""
    return str(value).encode("utf-8", "replace").decode()


def same_origin(address: httpx2.URL, home: httpx2.URL) -> bool:
    """Return whether an address belongs to the forum: credentials are sent nowhere else."""
    return (address.scheme, address.host, address.port) == (home.scheme, home.host, home.port)


def server_time(response: httpx2.Response) -> datetime | None:
    """Return the forum's clock from the `Date` header, to the second."""
    try:
        return parsedate_to_datetime(response.headers["date"]).astimezone(UTC)
    except (KeyError, ValueError, TypeError):
        return None


def requested_wait_s(response: httpx2.Response) -> float | None:
    """Return the wait that `Retry-After` requests, in seconds or until a date by the forum's clock; None if there is no
    valid one."""
    header = response.headers.get("retry-after", "")
    try:
        return bounded_s(float(header))
    except ValueError:
        pass
    try:
        ends = parsedate_to_datetime(header)
        ends = ends.replace(tzinfo=UTC) if ends.tzinfo is None else ends
        return bounded_s((ends - (server_time(response) or datetime.now(UTC))).total_seconds())
    except (ValueError, TypeError, OverflowError):
        return None


def bounded_s(wait_s: float) -> float:
    """Limit a wait to 0.1 s up to an hour. Raises `ValueError` for NaN."""
    if math.isnan(wait_s):
        raise ValueError("the wait is not a number")
    return min(max(0.1, wait_s), LONGEST_RETRY_S)


def retry_after_s(response: httpx2.Response) -> float:
    """Return the requested wait, or one second."""
    return requested_wait_s(response) or 1.0


def image_file(number: int, image: bytes) -> tuple[str, bytes, str]:
    """Return name, content and type of an image for a multipart upload."""
    kind = {b"\x89P": "png", b"RI": "webp", b"GI": "gif"}.get(image[:2], "jpeg")
    return f"{number}.{kind}", image, f"image/{kind}"


def request_line(response: httpx2.Response) -> str:
    """Return the request and its status, to begin an error message with."""
    url = response.request.url
    return f"{response.request.method} {url.scheme}://{url.netloc.decode()}{url.path}: {response.status_code}"
