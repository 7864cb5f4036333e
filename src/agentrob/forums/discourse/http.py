"""HTTP client for Discourse, with an API key or a session; answers are JSON or one of our errors."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager, suppress
from datetime import UTC, datetime
from http.cookiejar import DefaultCookiePolicy
from typing import Any

import httpx2

from agentrob.errors import ForumDenied, ForumError, ForumLimited, ForumNotFound, ForumUnreachable
from agentrob.forums.discourse.settings import Credentials
from agentrob.forums.http import (
    bounded_s,
    http_client,
    request_line,
    requested_wait_s,
    same_origin,
    server_time,
    translate_errors,
)
from agentrob.process.tls import tls

#: Longer limits (edits per day, posts on the first day) are not waited for.
LONGEST_WAIT_S = 600.0
Json = Any


class Refused(ForumError):
    """Discourse understood and refused what was written (422): too short, too similar, closed."""


class DiscourseClient:
    """One signed-in client. After a 429 it holds back requests that would be refused again, reading and writing
    separately."""

    def __init__(self, url: str, credentials: Credentials) -> None:
        self.credentials = credentials
        #: The forum's clock in its last answer, and our own then.
        self.clock_at: tuple[datetime, float] | None = None
        self._held: dict[str, float] = {}
        self._csrf = ""
        self._signing_in = asyncio.Lock()
        self._http = http_client(url, 15.0, headers={"Accept": "application/json"})
        if not credentials.by_session:
            # A cookie would sign us in beside the key, and as another account after a switch.
            self._http.cookies.jar.set_policy(DefaultCookiePolicy(allowed_domains=[]))

    @property
    def base(self) -> httpx2.URL:
        return self._http.base_url

    async def close(self) -> None:
        await self._http.aclose()

    async def get(self, path: str, **query: Any) -> Json:
        return await self.ask("GET", path, params=query)

    async def ask(self, method: str, path: str, **more: Any) -> Json:
        """Return the JSON of the answer, None if it is empty."""
        with translate_errors():
            response = await self.send(method, path, **more)
            return response.json() if response.content.strip() else None

    async def location(self, path: str) -> str:
        """Return the target of a redirect."""
        with translate_errors():
            return str((await self.send("GET", path)).headers.get("location", ""))

    async def bytes(self, url: str) -> bytes:
        """Download a file of this forum: the key goes nowhere else."""
        with translate_errors():
            address = self.base.join(url)
            if not same_origin(address, self.base):
                raise ForumError(f"{url} is not a picture of this forum")
            response = await self.send("GET", str(address))
            if response.has_redirect_location:  # to its file storage, without the key
                async with httpx2.AsyncClient(trust_env=False, timeout=15.0, verify=tls()) as elsewhere:
                    response = await elsewhere.get(address.join(response.headers["location"]))
                await _raise_for(response)
            return response.content

    @asynccontextmanager
    async def stream(self, path: str, body: Mapping[str, Any]) -> AsyncIterator[AsyncIterator[str]]:
        """Yield an answer in pieces as they arrive."""
        timeout = httpx2.Timeout(10.0, read=40.0)
        with translate_errors():
            headers = {**self.credentials.headers, "Accept": "*/*"}
            async with self._http.stream("POST", path, json=body, headers=headers, timeout=timeout) as response:
                await _raise_for(response)
                yield response.aiter_text()

    # ---------------------------------------------------------------- inside
    async def send(self, method: str, path: str, **more: Any) -> httpx2.Response:
        """Send one request; if the session has ended, sign in once more."""
        kind = _kind(method, path)
        self._hold_back(kind)
        for attempt in (1, 2):
            stale = self._csrf
            headers = dict(self.credentials.headers)
            if self.credentials.by_session:
                headers |= {"X-CSRF-Token": await self._signed_in(), "X-Requested-With": "XMLHttpRequest"}
                stale = self._csrf
            response = await self._http.request(method, path, headers=headers, **more)
            self._note_clock(response)
            if attempt == 1 and response.status_code == 403 and self.credentials.by_session:
                self._csrf = "" if self._csrf == stale else self._csrf
                continue
            try:
                await _raise_for(response)
            except ForumLimited as e:
                self._note_limit(kind, response, e.retry_after_s)
                raise
            return response
        raise AssertionError("unreachable")

    async def _signed_in(self) -> str:
        """Return the CSRF token of a signed-in session; sign in if there is none."""
        async with self._signing_in:
            if self._csrf:
                return self._csrf
            self._http.cookies.clear()
            csrf = await self._fresh_csrf()
            response = await self._http.post(
                "/session.json",
                json={"login": self.credentials.name, "password": self.credentials.password},
                headers={"X-CSRF-Token": csrf, "X-Requested-With": "XMLHttpRequest"},
            )
            await _raise_for(response)
            if error := response.json().get("error"):  # a wrong password is answered with 200
                raise ForumDenied(f"{self.credentials.name} is not signed in: {error}")
            self._csrf = await self._fresh_csrf()
            return self._csrf

    async def _fresh_csrf(self) -> str:
        response = await self._http.get("/session/csrf.json", headers={"X-Requested-With": "XMLHttpRequest"})
        await _raise_for(response)
        return str(response.json()["csrf"])

    def _hold_back(self, kind: str) -> None:
        for held in ("all", kind):
            if (left_s := self._held.get(held, 0.0) - time.monotonic()) > 0:
                raise ForumLimited(f"Discourse's rate limit lasts for another {left_s:.1f} s", left_s)

    def _note_limit(self, kind: str, response: httpx2.Response, wait_s: float) -> None:
        """Remember a rate limit. A limit on reading, or one in plain text, is that of the address or key and holds for
        everything; a limit on posting must not stop reading."""
        plain = "json" not in response.headers.get("content-type", "")
        whole = kind == "read" or (plain and kind != "bus")
        if wait_s <= LONGEST_WAIT_S:
            self._held["all" if whole else kind] = time.monotonic() + wait_s

    def _note_clock(self, response: httpx2.Response) -> None:
        self.clock_at = (server_time(response) or datetime.now(UTC), time.monotonic())


def _kind(method: str, path: str) -> str:
    if path.startswith("/message-bus/"):
        return "bus"
    return {"GET": "read", "POST": "post"}.get(method, "change")


async def _raise_for(response: httpx2.Response) -> None:
    if response.status_code < 400:
        return
    await response.aread()
    message = _error_message(response)
    match response.status_code:
        case 401 | 403:
            raise ForumDenied(message)
        case 404 | 410:
            raise ForumNotFound(message)
        case 422 | 409:
            raise Refused(message)
        case 429:
            wait_s = _wait_s(response)
            if wait_s > LONGEST_WAIT_S and response.request.method == "PUT":
                raise ForumDenied(f"{message} (no more edits for {wait_s:.0f} s)")
            raise ForumLimited(message, wait_s)
        case code if code >= 500:
            raise ForumUnreachable(message)
    raise ForumError(message)


def _error_message(response: httpx2.Response) -> str:
    """Return one sentence from Discourse's `errors`, or from the plain text of its rate limits."""
    try:
        message = " ".join(map(str, response.json()["errors"]))
    except (ValueError, KeyError, TypeError):
        message = " ".join(response.text[:200].split())
    return f"{request_line(response)} {message}".rstrip()


def _wait_s(response: httpx2.Response) -> float:
    """Return the longer of `Retry-After` and `extras.wait_seconds` of the body; at least one second if neither is
    given."""
    waits = [requested_wait_s(response) or 0.0]
    with suppress(ValueError, KeyError, TypeError, OverflowError):
        waits.append(bounded_s(float(response.json()["extras"]["wait_seconds"])))
    return max(waits) or 1.0
