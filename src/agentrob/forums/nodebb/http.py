"""HTTP client for NodeBB: signed in with a session and its CSRF token, or with an API token."""

from __future__ import annotations

import asyncio
import re
import time
from collections.abc import Mapping
from contextlib import suppress
from datetime import UTC, datetime
from http.cookiejar import CookieJar, DefaultCookiePolicy
from http.cookies import SimpleCookie
from typing import Any

import httpx2

from agentrob.errors import ForumDenied, ForumError, ForumLimited, ForumNotFound, ForumUnreachable
from agentrob.forums.http import (
    USER_AGENT,
    bounded_s,
    http_client,
    request_line,
    retry_after_s,
    same_origin,
    server_time,
    translate_errors,
)
from agentrob.forums.nodebb.clock import HeaderClock
from agentrob.forums.nodebb.settings import Credentials

#: Pause after a refused sign-in, since NodeBB locks accounts after a few.
DENIED_S = 60.0
#: Wanted precision of the forum's clock.
CLOCK_S, CLOCK_TRIES = 0.15, 16
_WAIT = re.compile(r"(?:only post once every|wait) (\d+) (second|minute)")
#: An untranslated message: `[[error:invalid-login-credentials]]`.
_KEYWORDS = re.compile(r"\[\[\w+:([^\]]+)\]\]")
_MUTED = re.compile(r"You have been muted")
_GONE = ("Category does not exist", "Topic does not exist", "Post does not exist", "User does not exist")


class NodeBBClient:
    """Requests of one identity. Makes none before the first call.

    Cookies are kept by hand, or not at all: answers to a bearer token bring a session cookie, and a request that
    returns it fails without a CSRF token.
    """

    def __init__(self, url: str, credentials: Credentials) -> None:
        self.credentials = credentials
        cookies = CookieJar(policy=DefaultCookiePolicy(allowed_domains=[]))
        self._http = http_client(url, 10.0, headers={"Accept": "application/json"}, cookies=cookies)
        self._signing = asyncio.Lock()
        self.clock = HeaderClock()
        self._forget()

    def _forget(self) -> None:
        self.cookie = self.csrf = ""
        self._signed = 0
        self._denied: ForumDenied | None = None
        self._denied_s = 0.0

    @property
    def url(self) -> str:
        return str(self._http.base_url).rstrip("/")

    async def close(self) -> None:
        await self._http.aclose()

    def become(self, credentials: Credentials) -> None:
        """Act as another identity from the next request on."""
        self.credentials = credentials
        self._forget()

    # ---------------------------------------------------------------- requests
    async def get(self, path: str, **params: Any) -> Any:
        return (await self.ask("GET", path, params=params)).json()

    async def get_v3(self, path: str, **params: Any) -> dict[str, Any]:
        found: dict[str, Any] = (await self.get("/api/v3" + path, **params))["response"]
        return found

    async def send(self, method: str, path: str, body: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """Call the write API and return its answer."""
        answer = await self.ask(method, "/api/v3" + path, json=dict(body or {}))
        found: dict[str, Any] = answer.json()["response"] if answer.content else {}
        return found

    async def ask(self, method: str, path: str, **more: Any) -> httpx2.Response:
        """Send a request. If the session has expired, sign in again and repeat it, since it was not carried out."""
        for attempt in range(2):
            signed = await self._ready()
            response = await self._request(method, path, **more)
            if attempt == 0 and self.credentials.by_session and _says_session_is_over(response):
                await self._sign_in(signed)
                continue
            break
        raise_for(response)
        return response

    async def check(self) -> None:
        """Sign in again if the session is over; raise `ForumDenied` if the token is invalid. Otherwise NodeBB would
        answer as to a guest, without an error."""
        await self.ask("GET", "/api/self")

    async def _request(self, method: str, path: str, **more: Any) -> httpx2.Response:
        headers = dict(more.pop("headers", {}))
        # Refusals are recognised by their English words.
        params = {"lang": "en-GB", **more.pop("params", {})}
        if self.credentials.by_session:
            headers |= {"Cookie": self.cookie, "x-csrf-token": self.csrf}
        else:
            headers["Authorization"] = f"Bearer {self.credentials.token}"
            if self.credentials.uid:
                params["_uid"] = self.credentials.uid
        asked = datetime.now(UTC)
        with translate_errors():
            response = await self._http.request(method, path, headers=headers, params=params, **more)
        if (date := server_time(response)) is not None:
            self.clock.add(date, asked, datetime.now(UTC))
        return response

    async def set_clock(self) -> None:
        """Measure the forum's clock better than in whole seconds: poll until the second changes."""
        for _ in range(CLOCK_TRIES):
            if self.clock.uncertainty_s < CLOCK_S:
                return
            await self.get("/api/v3/ping")
            await asyncio.sleep(CLOCK_S / 2)

    async def fetch(self, url: str) -> bytes:
        """Download a file of this forum only: the credentials go nowhere else."""
        try:
            address = httpx2.URL(self.url + "/").join(url)
        except httpx2.InvalidURL:
            raise ForumError(f"{url!r} is not an address") from None
        if not same_origin(address, self._http.base_url):
            raise ForumError(f"{url} is not a picture of this forum")
        return (await self.ask("GET", str(address))).content

    # ---------------------------------------------------------------- signing in
    async def _ready(self) -> int:
        if self.credentials.by_session and not self.cookie:
            await self._sign_in(self._signed)
        return self._signed

    async def _sign_in(self, signed: int) -> None:
        """Sign in once, even if several requests need it; `signed` is the sign-in that no longer works."""
        async with self._signing:
            if self._signed != signed and self.cookie:
                return
            if self._denied is not None and time.monotonic() - self._denied_s < DENIED_S:
                raise ForumDenied(str(self._denied))
            try:  # with the previous cookie: pages that need a recent password check this very session
                await self._log_in()
            except ForumDenied as e:
                self._denied, self._denied_s = e, time.monotonic()
                raise
            self._signed, self._denied = self._signed + 1, None

    async def _log_in(self) -> None:
        await self._new_csrf()
        login = {"username": self.credentials.name, "password": self.credentials.password}
        response = await self._request("POST", "/login", json=login)
        if response.status_code != 200:
            raise_for(response, "signing in was refused: ")
        self._keep_cookie(response)
        if not (await self._new_csrf()).get("loggedIn", True):
            raise ForumError(f"{self.url} did not keep the session")

    async def _new_csrf(self) -> dict[str, Any]:
        response = await self._request("GET", "/api/config")
        raise_for(response)
        with translate_errors():
            config: dict[str, Any] = response.json()
            if not config["csrf_token"]:
                raise ForumError(f"{self.url} treats {USER_AGENT} as a spider and gives it no CSRF token")
            self.csrf = str(config["csrf_token"])
        self._keep_cookie(response)
        return config

    def _keep_cookie(self, response: httpx2.Response) -> None:
        kept = SimpleCookie(self.cookie)
        for line in response.headers.get_list("set-cookie"):
            kept.load(line)
        self.cookie = "; ".join(f"{name}={morsel.value}" for name, morsel in kept.items())


class GuestClient(NodeBBClient):
    """A visitor before signing up, with its own cookie and CSRF token."""

    def __init__(self, url: str) -> None:
        super().__init__(url, Credentials(name="guest", password="none"))

    async def _log_in(self) -> None:
        await self._new_csrf()

    async def sign_up(self, name: str, password: str, email: str) -> None:
        """Create an account by the public form. Raises `ForumDenied` if the forum does not allow it."""
        form = {"username": name, "password": password, "password-confirm": password, "email": email}
        answer = (await self._posted("/register", {**form, "gdpr_consent": "true", "userLang": "en-GB"})).json()
        if str(answer.get("next", "")).endswith("/register/complete"):
            consent = {"email": email, "gdpr_agree_data": "on", "gdpr_agree_email": "on"}
            await self._posted("/register/complete", consent)
        elif answer.get("message"):
            raise ForumDenied(f"the account {name} must be approved first: {answer['message']}")
        with translate_errors():
            await self._check_name(name, password)

    async def _check_name(self, name: str, password: str) -> None:
        """Check the name of the new account. If the name is taken, NodeBB silently creates one with another name: sign
        out of it."""
        await self._new_csrf()
        me = await self.get("/api/self")
        if me.get("username") != name:
            with suppress(ForumError):
                await self.send("DELETE", f"/users/{me['uid']}/account", {"password": password})
            raise ForumDenied(f"signing up was refused: the name {name} is taken")

    async def _posted(self, path: str, form: Mapping[str, str]) -> httpx2.Response:
        await self._ready()
        response = await self._request("POST", path, data=dict(form))
        if response.status_code >= 400:
            raise_for(response, "signing up was refused: ")
        self._keep_cookie(response)
        return response


# ---------------------------------------------------------------- what answers mean
def _says_session_is_over(response: httpx2.Response) -> bool:
    """Return whether the session is over: 401, or a plain `Forbidden` for a wrong CSRF token. Missing rights are
    refused in JSON."""
    plain = not response.headers.get("content-type", "").startswith("application/json")
    return response.status_code == 401 or (response.status_code == 403 and plain)


def raise_for(response: httpx2.Response, before: str = "") -> None:
    """Raise our error for a failed answer. NodeBB sends its rate limits as 400 with a sentence, rarely as 429."""
    status = response.status_code
    if status < 400:
        return
    message = f"{before}{request_line(response)} {sentence(response)}".rstrip()
    if status == 429 or (wait := _wait_s(sentence(response))) is not None:
        raise ForumLimited(message, retry_after_s(response) if status == 429 else wait or 1.0)
    if _MUTED.search(message) or status in (401, 403):
        raise ForumDenied(message)
    if status in (404, 410) or any(gone in message for gone in _GONE):
        raise ForumNotFound(message)
    if "master token" in message or "master-token" in message:
        raise ForumDenied(f"{message}; write a master token as TOKEN@UID")
    if status >= 500 and "corrupt" not in message:
        raise ForumUnreachable(message)
    raise ForumError(message)


def sentence(response: httpx2.Response) -> str:
    """Return the error message of an answer in one sentence, from JSON of any shape or text."""
    return _KEYWORDS.sub(lambda m: m[1].replace("-", " "), _error_message(response))[:300].strip()


def _error_message(response: httpx2.Response) -> str:
    try:
        answer = response.json()
    except ValueError:
        return response.text[:200]
    if isinstance(answer, Mapping):
        status = answer.get("status")
        answer = (status or {}).get("message") if isinstance(status, Mapping) else answer
    if isinstance(answer, Mapping):
        if "banned_until" in answer:
            return f"the account is banned: {answer.get('reason') or 'no reason given'}"
        answer = answer.get("message") or answer.get("error") or answer.get("title") or ""
    return str(answer)


def _wait_s(message: str) -> float | None:
    """Return the wait that a refusal requests, in seconds."""
    if "already posting" in message:
        return 0.3
    if "too many files" in message:
        return 60.0
    if (found := _WAIT.search(message)) is None:
        return None
    return bounded_s(float(found[1]) * (60.0 if found[2] == "minute" else 1.0))
