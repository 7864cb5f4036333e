"""What all HTTP adapters share: user agent, origin check, server clock, retry delays, error translation."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime

import httpx2

from agentrob.errors import AgentRobError, ForumError, ForumMalformed, ForumUnreachable

#: Names that NodeBB takes for spiders (`python-requests/…`, `…Bot/`) get no CSRF token.
USER_AGENT = "AgentRob/0.1"
#: Whatever wait is told, it is asked again after an hour at the latest: none lasts for ever by a slip of the forum.
LONGEST_RETRY_S = 3600.0


@contextmanager
def translate_errors(forum: str = "the forum") -> Iterator[None]:
    """Nothing of the transport gets out: no answer is `ForumUnreachable`, nonsense is `ForumError`."""
    try:
        yield
    except httpx2.TransportError as e:
        raise ForumUnreachable(f"{forum} does not answer: {type(e).__name__} {e}".rstrip()) from None
    except (httpx2.HTTPError, httpx2.InvalidURL, httpx2.SSEError, httpx2.StreamError) as e:
        raise ForumError(f"{forum} cannot be used: {e}") from None
    except AgentRobError:
        raise
    except Exception as e:  # whatever reading it raises, also OverflowError of an infinity and RecursionError of a nest
        raise ForumMalformed(f"{forum} answered what is not in its API: {e!r}"[:500]) from None


def text_of(value: object) -> str:
    """A text of an answer without lone surrogates: nothing that hashes, stores or sends text takes them."""
    return str(value).encode("utf-8", "replace").decode()


def same_origin(address: httpx2.URL, home: httpx2.URL) -> bool:
    """Whether an address is of the forum: what signs us in goes nowhere else."""
    return (address.scheme, address.host, address.port) == (home.scheme, home.host, home.port)


def told_time(response: httpx2.Response) -> datetime | None:
    """The forum's clock by an answer's header, to the second."""
    try:
        return parsedate_to_datetime(response.headers["date"]).astimezone(UTC)
    except (KeyError, ValueError, TypeError):
        return None


def asked_wait_s(response: httpx2.Response) -> float | None:
    """The wait that an answer's header asks for, as a number of seconds or as the date when it ends by the forum's own
    clock; None where it says nothing that makes sense."""
    told = response.headers.get("retry-after", "")
    try:
        return bounded_s(float(told))
    except ValueError:
        pass
    try:
        ends = parsedate_to_datetime(told)
        ends = ends.replace(tzinfo=UTC) if ends.tzinfo is None else ends
        return bounded_s((ends - (told_time(response) or datetime.now(UTC))).total_seconds())
    except (ValueError, TypeError, OverflowError):
        return None


def bounded_s(wait_s: float) -> float:
    """A wait that ends. Raises `ValueError` for what is no number."""
    if math.isnan(wait_s):
        raise ValueError("a wait that is no number")
    return min(max(0.1, wait_s), LONGEST_RETRY_S)


def retry_after_s(response: httpx2.Response) -> float:
    """The same, a second where nothing is said."""
    return asked_wait_s(response) or 1.0


def where(response: httpx2.Response) -> str:
    """What was asked and how it ended, as a refusal's sentence begins."""
    url = response.request.url
    return f"{response.request.method} {url.scheme}://{url.netloc.decode()}{url.path}: {response.status_code}"
