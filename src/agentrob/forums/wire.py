"""What HTTP to every forum has in common: our name, the forum's home, clock and waits, errors of the transport."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime

import httpx2

from agentrob.errors import ForumError, ForumUnreachable

#: Names that NodeBB takes for spiders (`python-requests/…`, `…Bot/`) get no CSRF token.
USER_AGENT = "AgentRob/0.1"


@contextmanager
def translated(forum: str = "the forum") -> Iterator[None]:
    """Nothing of the transport gets out: no answer is `ForumUnreachable`, nonsense is `ForumError`."""
    try:
        yield
    except httpx2.TransportError as e:
        raise ForumUnreachable(f"{forum} does not answer: {type(e).__name__} {e}".rstrip()) from None
    except (httpx2.HTTPError, httpx2.InvalidURL, httpx2.SSEError, httpx2.StreamError) as e:
        raise ForumError(f"{forum} cannot be used: {e}") from None
    except (ValueError, KeyError, TypeError, AttributeError, IndexError) as e:
        raise ForumError(f"{forum} answered what is not in its API: {e!r}") from None


def same_origin(address: httpx2.URL, home: httpx2.URL) -> bool:
    """Whether an address is of the forum: what signs us in goes nowhere else."""
    return (address.scheme, address.host, address.port) == (home.scheme, home.host, home.port)


def told_time(response: httpx2.Response) -> datetime | None:
    """The forum's clock by an answer's header, to the second."""
    try:
        return parsedate_to_datetime(response.headers["date"]).astimezone(UTC)
    except (KeyError, ValueError, TypeError):
        return None


def retry_after_s(response: httpx2.Response) -> float:
    """The wait that an answer's header asks for."""
    try:
        return max(0.1, float(response.headers.get("retry-after", "1")))
    except ValueError:
        return 1.0


def where(response: httpx2.Response) -> str:
    """What was asked and how it ended, as a refusal's sentence begins."""
    return f"{response.request.method} {response.request.url.path}: {response.status_code}"
