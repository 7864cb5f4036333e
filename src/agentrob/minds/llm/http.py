"""The HTTP connection to a model: the key, bounded answers, no redirects, no proxies for loopback."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from urllib.parse import urlsplit

import httpx2

from agentrob.process.listen import is_loopback

#: Answers have some kilobytes; a larger one is broken or hostile.
MAX_ANSWER_BYTES = 2_000_000
#: Headers that libraries set from the environment for their own provider, not for the configured host.
_NOT_OURS = ("authorization", "x-api-key", "openai-organization", "openai-project")


class TooBig(httpx2.TransportError):
    """An answer beyond `MAX_ANSWER_BYTES`."""


class _Bounded(httpx2.AsyncByteStream):
    """Pass on at most `MAX_ANSWER_BYTES`, then fail."""

    def __init__(self, stream: httpx2.AsyncByteStream) -> None:
        self._stream = stream

    async def __aiter__(self) -> AsyncIterator[bytes]:
        size = 0
        async for chunk in self._stream:
            size += len(chunk)
            if size > MAX_ANSWER_BYTES:
                raise TooBig(f"an answer of more than {MAX_ANSWER_BYTES} bytes")
            yield chunk

    async def aclose(self) -> None:
        await self._stream.aclose()


class _Hooks:
    """Add the key to requests, so that no library holds it, and limit answers."""

    def __init__(self, credentials: Mapping[str, str]) -> None:
        self._credentials = credentials

    async def request(self, request: httpx2.Request) -> None:
        for name in _NOT_OURS:
            request.headers.pop(name, None)
        request.headers.update(self._credentials)
        request.headers["accept-encoding"] = "identity"  # a compressed answer could grow without bound

    async def response(self, response: httpx2.Response) -> None:
        if response.headers.get("content-encoding", "identity") != "identity":
            raise TooBig("a compressed answer, which was not asked for")
        assert isinstance(response.stream, httpx2.AsyncByteStream)
        response.stream = _Bounded(response.stream)


def client(base_url: str, credentials: Mapping[str, str], timeout_s: float) -> httpx2.AsyncClient:
    """Return a client for one model; `credentials` are headers. Key and post go only to the configured host."""
    hooks = _Hooks(credentials)
    return httpx2.AsyncClient(
        timeout=httpx2.Timeout(timeout_s, connect=min(timeout_s, 10.0)),
        event_hooks={"request": [hooks.request], "response": [hooks.response]},
        follow_redirects=False,
        trust_env=not is_loopback(urlsplit(base_url).hostname or ""),
    )
