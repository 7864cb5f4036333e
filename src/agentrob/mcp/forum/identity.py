"""The signed-in forum accounts of the MCP server: connection, rights, uploads and event streams."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from agentrob.errors import ForumDenied, ForumError
from agentrob.forums.protocol import Forum, SemanticSearcher
from agentrob.mcp.envelope import ToolError
from agentrob.mcp.forum.event_tail import EventTail
from agentrob.mcp.forum.media import MediaStore
from agentrob.model import Account

#: Opens the forum with a token.
OpenForum = Callable[[str], Forum]
#: Edits remembered by their key.
_MAX_KEYS = 256


@dataclass(frozen=True, slots=True)
class Rights:
    """The rights that the server's owner grants here. The forum enforces the account's own rights."""

    write: bool = False
    toolsets: frozenset[str] = frozenset({"core"})


@dataclass
class Identity:
    """A signed-in account. `name` is the configured name until the account was read from the forum."""

    name: str
    forum: Forum
    rights: Rights
    media: MediaStore = field(default_factory=MediaStore)
    _edits: dict[str, asyncio.Future[Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.event_tail = EventTail(self.forum)
        self._me: Account | None = None
        self._meaning: bool | None = None

    async def me(self) -> Account:
        """The account. It is read only once, since the forum itself checks rights at every write."""
        if self._me is None:
            self._me = await self.forum.me()
            self.name = self._me.name
        return self._me

    async def has_semantic_search(self) -> bool:
        """Whether this forum supports search by meaning; read once."""
        if self._meaning is None:
            forum = self.forum
            try:
                self._meaning = isinstance(forum, SemanticSearcher) and await forum.has_semantic_search()
            except ForumError:
                return False
        return self._meaning

    async def once(self, key: str | None, write: Callable[[], Awaitable[Any]]) -> tuple[Any, bool]:
        """Run a write once per key, even if two calls send it concurrently; return its result and whether it ran now.
        For writes that the forum itself does not make idempotent."""
        if key is None:
            return await write(), True
        if (running := self._edits.get(key)) is not None:
            return await asyncio.shield(running), False
        future: asyncio.Future[Any] = asyncio.get_running_loop().create_future()
        self._edits[key] = future
        try:
            future.set_result(await write())
        except BaseException as e:
            del self._edits[key]
            future.set_exception(e if isinstance(e, Exception) else ForumError("the write was cancelled"))
            future.exception()  # mark as retrieved: often no other call waits for it
            raise
        while len(self._edits) > _MAX_KEYS:
            del self._edits[next(iter(self._edits))]
        return future.result(), True

    async def close(self) -> None:
        with contextlib.suppress(Exception):
            await self.event_tail.close()
        with contextlib.suppress(Exception):
            await self.forum.close()


class Accounts:
    """The accounts that one stdio client may switch between: configured, registered, or given by token."""

    def __init__(self, first: Identity, open_forum: OpenForum, tokens: Mapping[str, str]) -> None:
        self.current = first
        self._open_forum = open_forum
        self._tokens = dict(tokens)
        self._first = first
        self._switched_to: dict[tuple[str, str], Identity] = {}  # by name and token

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(sorted(self._tokens))

    def remember(self, name: str, token: str) -> None:
        self._tokens[name] = token

    async def switch(self, name: str, token: str | None) -> Identity:
        """Sign in by a known or given token, which the forum must confirm to be this account's."""
        secret = token if token is not None else self._tokens.get(name)
        if secret is None:
            known = ", ".join(self.names) or "none"
            raise ToolError("not_found", f"no account {name!r} is known here", f"known: {known}; others need a token")
        before = self._switched_to.get((name, secret))
        identity = before or Identity(name, self._open_forum(secret), self.current.rights)
        try:
            me = await identity.forum.me()
            if me.name != name:
                raise ForumDenied(f"that token is not {name}'s")
        except BaseException:
            if before is None:
                await identity.close()
            raise
        self._tokens[name] = secret
        self._switched_to[name, secret] = identity
        self.current = identity
        return identity

    async def close(self) -> None:
        for identity in (self._first, *self._switched_to.values()):
            await identity.close()
