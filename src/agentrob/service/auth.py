"""Authenticates callers by bearer tokens with scopes; a token may act as a forum account. No anonymous access."""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from limits import RateLimitItemPerMinute
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter

from agentrob.agent.intake.triage import obeyed
from agentrob.config.service import Scope, ServiceConfig
from agentrob.errors import ConfigError, ForumDenied, ForumError, ServiceError
from agentrob.forums.protocol import Forum
from agentrob.model import Account, Decision
from agentrob.screening.rights import may

#: The maximum age of a cached account, which is used where a request to the forum would delay a stop.
REFRESH_S = 15.0
SHORTEST = 16


@dataclass(eq=False)
class Caller:
    """The owner of one token. `account` is its account on the forum, as of the last refresh."""

    name: str
    scopes: frozenset[Scope]
    forum: Forum | None = None
    account: Account | None = None
    denied: bool = False

    async def refresh(self) -> Account | None:
        """Read the account from the forum again. Raises `ForumError`."""
        if self.forum is None:
            return None
        try:
            self.account, self.denied = await self.forum.me(), False
        except ForumDenied:  # suspended, or its token is void
            self.denied = True
            raise
        return self.account

    def may_stop(self, robot: Account | None) -> bool:
        """Whether this caller may stop the robot. Makes no request: a stop never waits. A token without an account
        may stop by its scope alone (laws 2 and 15)."""
        if self.account is None or self.denied:
            return not self.denied
        mine = robot is None or obeyed(self.account, robot)
        return mine and may(self.account, "stop").decision is Decision.ALLOW


class TokenAuthenticator:
    """Finds callers by their tokens, which are stored as digests only, and limits their request rates."""

    def __init__(self, callers: Mapping[str, Caller], per_minute: int) -> None:
        self._by_digest = {_digest(token): caller for token, caller in callers.items()}
        if len(self._by_digest) != len(callers):
            raise ConfigError("two tokens of [service.tokens] are equal; each caller needs its own")
        self._limit = RateLimitItemPerMinute(per_minute)
        self._limiter = MovingWindowRateLimiter(MemoryStorage())

    @property
    def all(self) -> Sequence[Caller]:
        return tuple(self._by_digest.values())

    def authenticate(self, authorization: str | None, scope: Scope) -> Caller:
        """The caller of a token. `ServiceError` 401 for an unknown token, 403 without the scope, 429 over the rate
        limit, which does not count stops."""
        kind, _, token = (authorization or "").partition(" ")
        caller = self._by_digest.get(_digest(token.strip())) if kind.lower() == "bearer" else None
        if caller is None:
            raise ServiceError(401, "bad_token", "no valid token was sent", "Authorization: Bearer <token>")
        if scope not in caller.scopes:
            has = ", ".join(sorted(caller.scopes)) or "none"
            raise ServiceError(403, "no_scope", f"this needs the scope {scope}; the token has {has}")
        if scope != "stop" and not self._limiter.hit(self._limit, caller.name):
            reset_s = self._limiter.get_window_stats(self._limit, caller.name).reset_time - time.time()
            hint = f"at most {self._limit.amount} a minute"
            raise ServiceError(429, "too_many", "too many requests of this token", hint, max(1.0, math.ceil(reset_s)))
        return caller

    async def keep_fresh(self) -> None:
        """Refresh all accounts until cancelled, so that a suspended account cannot stop."""
        while True:
            for caller in self.all:
                with contextlib.suppress(ForumError):
                    await caller.refresh()
            await asyncio.sleep(REFRESH_S)

    async def close(self) -> None:
        for caller in self.all:
            if caller.forum is not None:
                await caller.forum.close()


def _digest(token: str) -> bytes:
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).digest()


def configured(
    config: ServiceConfig, secret: Callable[[str], str], open_forum: Callable[[str], Forum]
) -> TokenAuthenticator:
    """The callers of a configuration; `secret` reads a variable, `open_forum` signs in by a token."""
    callers: dict[str, Caller] = {}
    for name, settings in config.tokens.items():
        token = secret(settings.token_env)
        if len(token) < SHORTEST:
            raise ConfigError(f"the token in {settings.token_env} must have at least {SHORTEST} characters")
        if token in callers:
            raise ConfigError(f"{name} and {callers[token].name} have the same token; each caller needs its own")
        forum = open_forum(secret(settings.forum_token_env)) if settings.forum_token_env else None
        callers[token] = Caller(name, frozenset(settings.scopes), forum)
    return TokenAuthenticator(callers, config.requests_per_minute)
