"""The forum adapter over MCP: an agent uses the tools of an MCP server instead of a forum's own API.

    [forum]
    kind = "mcp"
    url = "http://127.0.0.1:8090/mcp"            # the token in token_env is that of [mcp.users.NAME]

or, for a server that is started as a child process (the token is then the forum's, and is passed on):

    url = "stdio:agentrob mcp forum --config forum.toml"
"""

from __future__ import annotations

import os
import shlex
from collections.abc import AsyncIterator, Awaitable, Sequence
from datetime import UTC, datetime
from typing import TypeVar

from agentrob.config.forum import ForumConfig
from agentrob.errors import (
    ConfigError,
    ForumDenied,
    ForumError,
    ForumLimited,
    ForumMalformed,
    ForumNotFound,
    ForumUnoffered,
    ForumUnreachable,
    McpError,
)
from agentrob.forums.cards import facts_of
from agentrob.forums.protocol import Board, Event, Notification, Topic, Written
from agentrob.mcp import mapping, results
from agentrob.mcp.client import ForumClient, ServerUnavailable, ToolFailed
from agentrob.mcp.forum.resources import address
from agentrob.model import Account, EventKind, Page, Post, Role, StatusCard

T = TypeVar("T")
_STDIO = "stdio:"
#: Requests whole bodies: the longest that our forums accept.
_MAX_CHARS = 70_000


class McpForum:
    """A forum behind an MCP server, used as the account that the server signs in; implements `Forum`.

    `live` and `max_edits` are known after `connect()` or the first call.
    """

    max_edits: int | None = None
    live = True
    fastest_poll_s = 0.0

    def __init__(self, settings: ForumConfig, token: str) -> None:
        if settings.url.startswith(_STDIO):
            command = shlex.split(settings.url.removeprefix(_STDIO))
            if not command:
                raise ConfigError('forum.url must name a command, for example "stdio:agentrob mcp forum"')
            env = {**os.environ, settings.token_env: token}
            self._client = ForumClient.spawn(command[0], *command[1:], env=env)
        else:
            self._client = ForumClient.connect(settings.url, token)

    @classmethod
    def from_client(cls, client: ForumClient) -> McpForum:
        """The forum behind an existing client."""
        forum = cls.__new__(cls)
        forum._client = client
        return forum

    async def connect(self) -> None:
        """Read what the forum supports."""
        await self._facts()

    async def close(self) -> None:
        await self._client.close()

    async def _facts(self) -> results.ForumFacts:
        facts = await _answer(self._client.read(address("me"), results.ForumFacts))
        self.live, self.max_edits, self.fastest_poll_s = facts.live, facts.max_edits, facts.fastest_poll_s
        return facts

    # ---------------------------------------------------------------- Reader
    async def boards(self) -> Sequence[Board]:
        found, cursor = list[Board](), None
        while True:
            page = await _answer(self._client.list_boards(cursor, 100))
            found += [Board(b.id, b.name, b.description) for b in page.boards]
            if (cursor := page.next) is None:
                return tuple(found)

    async def topic(self, topic_id: str) -> Topic:
        return mapping.topic((await _answer(self._client.get_topic(topic_id, limit=1, max_chars=100))).topic)

    async def topics(self, board_id: str, cursor: str | None = None, limit: int = 20) -> Page[Topic]:
        page = await _answer(self._client.list_posts(board_id, cursor, limit))
        return Page(tuple(map(mapping.topic, page.topics)), page.next)

    async def posts(self, topic_id: str, cursor: str | None = None, limit: int = 50) -> Page[Post]:
        page = await _answer(self._client.get_topic(topic_id, cursor, limit, _MAX_CHARS))
        return Page(tuple(map(mapping.post, page.posts)), page.next)

    async def post(self, post_id: str) -> Post:
        found = await _answer(self._client.read(address("post", post_id), results.Found))
        if not found.posts:
            raise ForumNotFound(f"there is no post {post_id}")
        return mapping.post(found.posts[0])

    async def download(self, url: str) -> bytes:
        return await _answer(self._client.read_bytes(address("media", url)))

    # ---------------------------------------------------------------- Writer
    async def create_topic(
        self, board_id: str, title: str, body: str, *, key: str, images: Sequence[bytes] = ()
    ) -> Written:
        ids = await self._upload(images)
        wrote = await _answer(self._client.create_topic(board_id, title, body, images=ids, key=key))
        return Written(await self.post(wrote.post.id), wrote.created)

    async def reply(
        self,
        topic_id: str,
        body: str,
        *,
        key: str,
        reply_to: str | None = None,
        images: Sequence[bytes] = (),
        card: StatusCard | None = None,
    ) -> Written:
        ids = await self._upload(images)
        wrote = await _answer(
            self._client.reply_to_topic(
                topic_id, body, reply_to=reply_to, status=_status(card), images=ids, card=_card(card), key=key
            )
        )
        return Written(await self.post(wrote.post.id), wrote.created)

    async def edit(
        self, post_id: str, body: str, *, images: Sequence[bytes] = (), card: StatusCard | None = None
    ) -> Post:
        return await self._edit(post_id, body, images, card)

    async def edit_once(
        self, post_id: str, body: str, *, key: str, images: Sequence[bytes] = (), card: StatusCard | None = None
    ) -> Post:
        return await self._edit(post_id, body, images, card, key)

    async def _edit(
        self, post_id: str, body: str, images: Sequence[bytes], card: StatusCard | None, key: str | None = None
    ) -> Post:
        ids = await self._upload(images)
        asked = self._client.edit_post(post_id, body, status=_status(card), images=ids, card=_card(card), key=key)
        return await self.post((await _answer(asked)).post.id)

    async def find(self, key: str) -> Post | None:
        found = await _answer(self._client.read(address("key", key), results.Found))
        return mapping.post(found.posts[0]) if found.posts else None

    async def _upload(self, images: Sequence[bytes]) -> list[str]:
        return [(await _answer(self._client.upload_media(image))).media_id for image in images]

    # ---------------------------------------------------------------- Accounts
    async def me(self) -> Account:
        return mapping.account((await self._facts()).account)

    async def account(self, name: str) -> Account | None:
        try:
            found = await _answer(self._client.read(address("account", name), results.SignedIn))
        except ForumNotFound:
            return None
        return mapping.account(found.account)

    # ---------------------------------------------------------------- Events
    async def now(self) -> tuple[str, datetime]:
        facts = await self._facts()
        return facts.event, facts.at

    async def changes(self, after: str, limit: int = 100) -> tuple[Event, ...]:
        uri = address("changes", after, str(limit))
        return _events(await _answer(self._client.read(uri, results.Changes)))

    async def stream(self, after: str, heartbeat_s: float = 0.5) -> AsyncIterator[Event]:
        """Stream events and heartbeats of the forum behind the server; a heartbeat shows that both connections work."""
        if not self.live:
            raise ForumUnreachable("this forum has no event stream; poll changes()")
        beat_s = max(0.25, heartbeat_s)
        while True:
            uri = address("wait", after, f"{beat_s:g}")
            changes = await _answer(self._client.read(uri, results.Changes, limit_s=max(2.0, 4 * beat_s)))
            for event in _events(changes):
                after = event.id
                yield event
            if not changes.events:
                yield Event("", EventKind.HEARTBEAT, changes.at or datetime.now(UTC))

    # ---------------------------------------------------------------- optional features
    async def search(
        self, query: str, *, board_id: str | None = None, cursor: str | None = None, limit: int = 10
    ) -> Page[Post]:
        page = await _answer(self._client.search_posts(query, board_id, cursor, limit))
        return Page(tuple([await self.post(p.id) if p.more else mapping.post(p) for p in page.posts]), page.next)

    async def set_rights(self, name: str, *, role: Role | None = None, suspended: bool | None = None) -> Account:
        asked = self._client.manage_permissions(name, str(role) if role else None, suspended)
        return mapping.account((await _answer(asked)).account)

    async def notifications(self, cursor: str | None = None, limit: int = 20) -> Page[Notification]:
        page = await _answer(self._client.list_notifications(cursor, limit))
        found = (Notification(n.id, n.kind, mapping.post(n.post), n.read) for n in page.notifications)
        return Page(tuple(found), page.next)


async def _answer(asked: Awaitable[T]) -> T:
    """Await an answer; raise errors of the tool or the connection as forum errors."""
    try:
        return await asked
    except ToolFailed as e:
        match e.code:
            case "not_found":
                raise ForumNotFound(str(e)) from None
            case "denied" | "not_allowed" | "unknown_tool":
                raise ForumDenied(str(e)) from None
            case "rate_limited":
                raise ForumLimited(str(e), e.retry_after_s) from None
            case "unreachable":
                raise ForumUnreachable(str(e)) from None
            case "not_offered":
                raise ForumUnoffered(str(e)) from None
        raise ForumError(str(e)) from None
    except ServerUnavailable as e:
        raise ForumUnreachable(str(e)) from None
    except McpError as e:
        raise ForumMalformed(str(e)) from None


def _events(changes: results.Changes) -> tuple[Event, ...]:
    """The events; kinds that only a newer server knows are skipped."""
    return tuple(mapping.event(e) for e in changes.events if e.kind in frozenset(EventKind))


def _card(card: StatusCard | None) -> dict[str, object] | None:
    return facts_of(card) if card else None


def _status(card: StatusCard | None) -> str | None:
    return card.state if card else None
