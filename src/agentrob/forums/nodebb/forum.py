"""The adapter for NodeBB: its write API and JSON pages, with keys, cards and push (`docs/forum/nodebb.md`)."""

from __future__ import annotations

import asyncio
import hashlib
import secrets
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine, Sequence
from contextlib import AsyncExitStack
from datetime import datetime
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from agentrob.config.forum import ForumConfig
from agentrob.errors import ForumDenied, ForumError, ForumLimited, ForumNotFound
from agentrob.forums.bounded import MOST_KNOWN, BoundedDict
from agentrob.forums.http import image_file, translate_errors
from agentrob.forums.nodebb.accounts import AccountAdmin
from agentrob.forums.nodebb.events import ChangeTracker, Source
from agentrob.forums.nodebb.http import GuestClient, NodeBBClient
from agentrob.forums.nodebb.markers import MarkedText, mark, unmark
from agentrob.forums.nodebb.notifications import notifications_of
from agentrob.forums.nodebb.posts import PostReader, own_place
from agentrob.forums.nodebb.settings import Credentials, NodeBBOptions
from agentrob.forums.nodebb.socket import Push
from agentrob.forums.protocol import Board, Event, Notification, Registered, Topic, Written
from agentrob.model import Account, AccountKind, EventKind, Page, Post, Role, StatusCard

P = ParamSpec("P")
T = TypeVar("T")
_JSON = dict[str, Any]
#: How often to ask whether a moderator has approved a post.
QUEUE_S = 30.0
#: Pages of own posts, or of a topic, that are searched for a key.
KEY_PAGES = 5
#: How often a stream checks that its session is alive.
CHECK_S = 5.0


def _translated(call: Callable[P, Awaitable[T]]) -> Callable[P, Coroutine[Any, Any, T]]:
    """Turn unexpected answers of the forum into `ForumError`."""

    @wraps(call)
    async def made(*args: P.args, **more: P.kwargs) -> T:
        with translate_errors():
            return await call(*args, **more)

    return made


class NodeBBForum:
    """A NodeBB, signed in as one account; fulfils `Forum`. Makes no request before the first call.

    A key is stored in a marker at the end of a post (`markers`), so every client that signs in as this account knows
    it.
    """

    max_edits: int | None = None
    live = True
    fastest_poll_s = 0.0

    def __init__(self, settings: ForumConfig, token: str) -> None:
        self._options = NodeBBOptions.of(settings.options)
        self._settings = settings
        self._client = NodeBBClient(settings.url, Credentials.of(token))
        self._begin()

    def _begin(self) -> None:
        self._admin = AccountAdmin(self._client, self._options)
        self._reader = PostReader(self._client, self._admin)
        source = Source(self._reader.recent, self._reader.post, self._reader.stored, self._client.clock.now)
        self._tracker = ChangeTracker(source)
        self._writing = asyncio.Lock()
        #: Posts by key, pictures by digest; dropped ones are searched on the forum, or uploaded again.
        self._own = BoundedDict[str, str](MOST_KNOWN)
        self._uploaded = BoundedDict[str, str](MOST_KNOWN)
        self._checked_s = -CHECK_S

    async def close(self) -> None:
        await self._client.close()

    # ---------------------------------------------------------------- identity
    @_translated
    async def switch(self, token: str) -> Account:
        """Act as another account from now on; forget everything about the one before."""
        async with self._writing:
            self._client.become(Credentials.of(token))
            self._begin()
        return await self.me()

    async def sign_in(self, name: str, password: str) -> Account:
        """Act as this account, by its password."""
        return await self.switch(f"login:{name}:{password}")

    @_translated
    async def add_account(
        self, name: str, *, kind: AccountKind = AccountKind.HUMAN, email: str = "", display_name: str = ""
    ) -> tuple[Account, str]:
        """Create an account, as an admin; return it with the secret that signs it in."""
        password = secrets.token_urlsafe(24)
        slug = await self._admin.add(name, password, kind, email, display_name)
        return await self._admin.by_slug(slug), f"login:{name}:{password}"

    async def register(self, name: str, *, kind: AccountKind = AccountKind.HUMAN, display_name: str = "") -> Registered:
        return Registered(*await self.add_account(name, kind=kind, display_name=display_name))

    @_translated
    async def set_rights(self, name: str, *, role: Role | None = None, suspended: bool | None = None) -> Account:
        return await self._admin.set_rights(name, role, suspended)

    @classmethod
    async def sign_up(cls, settings: ForumConfig, name: str, password: str, email: str) -> NodeBBForum:
        """Create an account by the forum's public form and sign in as it. Raises `ForumDenied` if the forum refuses."""
        guest = GuestClient(settings.url)
        try:
            await guest.sign_up(name, password, email)
        finally:
            await guest.close()
        return cls(settings, f"login:{name}:{password}")

    # ---------------------------------------------------------------- Reader
    @_translated
    async def boards(self) -> Sequence[Board]:
        return await self._reader.boards()

    @_translated
    async def topic(self, topic_id: str) -> Topic:
        return await self._reader.topic(topic_id)

    @_translated
    async def topics(self, board_id: str, cursor: str | None = None, limit: int = 20) -> Page[Topic]:
        return await self._reader.topics(board_id, cursor, limit)

    @_translated
    async def posts(self, topic_id: str, cursor: str | None = None, limit: int = 50) -> Page[Post]:
        return await self._reader.posts(topic_id, cursor, limit)

    @_translated
    async def post(self, post_id: str) -> Post:
        return await self._reader.post(post_id)

    @_translated
    async def download(self, url: str) -> bytes:
        return await self._client.fetch(url)

    @_translated
    async def search(
        self, query: str, *, board_id: str | None = None, cursor: str | None = None, limit: int = 10
    ) -> Page[Post]:
        """Return posts with the words, newest first; needs the forum's search plugin."""
        return await self._reader.search(query, board_id, cursor, limit)

    @_translated
    async def mentions(self) -> tuple[Post, ...]:
        """Return posts that mention us, newest first, as long as the forum lists their notifications."""
        found = await self._client.get("/api/notifications", filter="mention")
        pids = [str(n["pid"]) for n in found["notifications"] if n.get("pid")]
        return tuple([await self.post(pid) for pid in dict.fromkeys(pids)])

    @_translated
    async def notifications(self, cursor: str | None = None, limit: int = 20) -> Page[Notification]:
        me = await self._admin.me()
        return await notifications_of(self._client, self._reader.post, me.name, cursor, limit)

    # ---------------------------------------------------------------- Writer
    @_translated
    async def create_topic(
        self, board_id: str, title: str, body: str, *, key: str, images: Sequence[bytes] = ()
    ) -> Written:
        cid = await self._reader.cid(board_id)
        async with self._writing:
            if old := await self._with_key(key):
                return Written(old, created=False)
            raw = mark(MarkedText(body, key, None, await self._upload(images)))
            answer = await self._client.send("POST", "/topics", {"cid": cid, "title": title, "content": raw})
            return await self._written(answer, key, "mainPid")

    @_translated
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
        async with self._writing:
            if old := await self._with_key(key, topic_id, reply_to):
                return Written(old, created=False)
            content: _JSON = {"content": mark(MarkedText(body, key, card, await self._upload(images)))}
            if reply_to is not None:
                content["toPid"] = int(reply_to) if reply_to.isdigit() else reply_to
            answer = await self._client.send("POST", f"/topics/{own_place(topic_id)}", content)
            written = await self._written(answer, key, "pid")
            return await self._only_one(written, key, topic_id, reply_to)

    @_translated
    async def edit(
        self, post_id: str, body: str, *, images: Sequence[bytes] = (), card: StatusCard | None = None
    ) -> Post:
        async with self._writing:
            stored = await self._reader.stored(post_id)
            if str(stored.get("uid")) != (await self._admin.me()).id:
                raise ForumDenied(f"post {post_id} belongs to another account")
            old = unmark(str(stored["content"]))
            pictures = (*old.pictures, *await self._upload(images))
            raw = mark(MarkedText(body, old.key, card or old.card, pictures))
            await self._client.send("PUT", f"/posts/{own_place(post_id)}", {"content": raw})
            return await self.post(post_id)

    @_translated
    async def find(self, key: str) -> Post | None:
        return await self._with_key(key)

    async def _written(self, answer: _JSON, key: str, field: str) -> Written:
        if answer.get("queued"):
            raise _queued(str(answer.get("id", "")))
        self._own[key] = str(answer[field])
        return Written(await self.post(self._own[key]))

    async def _with_key(self, key: str, topic_id: str | None = None, reply_to: str | None = None) -> Post | None:
        """Return our post with that key, if any. Raises `ForumLimited` while it waits for a moderator."""
        if key not in self._own and (pid := await self._search(key, topic_id, reply_to)) is not None:
            self._own[key] = pid
        if key in self._own:
            return await self.post(self._own[key])
        me = await self._admin.me()
        if (waiting := await self._reader.waiting(me.id, key)) is not None:
            raise _queued(waiting)
        return None

    async def _search(self, key: str, topic_id: str | None, reply_to: str | None) -> str | None:
        me = await self._admin.me()
        if topic_id is None:
            return await self._reader.own_with_key(me, key, KEY_PAGES)
        since_ms = int((await self._reader.stored(reply_to))["timestamp"]) if reply_to else 0
        return await self._reader.own_in_topic(me, key, topic_id, since_ms, KEY_PAGES)

    async def _only_one(self, written: Written, key: str, topic_id: str, reply_to: str | None) -> Written:
        """If another client of this account wrote with this key at the same time, keep the earlier post."""
        first = await self._search(key, topic_id, reply_to)
        if first is None or int(first) >= int(written.post.id):
            return written
        await self._client.send("DELETE", f"/posts/{own_place(written.post.id)}/state")
        self._own[key] = first
        return Written(await self.post(first), created=False)

    async def _upload(self, images: Sequence[bytes]) -> tuple[str, ...]:
        """Upload pictures first; the text then names them. A picture is uploaded once."""
        if images and not self._client.credentials.by_session:
            raise ForumError(
                "this forum takes pictures only from password sessions: set the token to login:name:password"
            )
        places = []
        for number, image in enumerate(images, 1):
            digest = hashlib.sha256(image).hexdigest()
            if (place := self._uploaded.get(digest)) is None:
                files = {"files[]": image_file(number, image)}
                answer = await self._client.ask("POST", "/api/post/upload", files=files)
                place = self._uploaded[digest] = str(answer.json()["response"]["images"][0]["url"])
            places.append(place)
        return tuple(places)

    # ---------------------------------------------------------------- Accounts
    @_translated
    async def me(self) -> Account:
        return await self._admin.me(fresh=True)

    @_translated
    async def account(self, name: str) -> Account | None:
        try:
            return await self._admin.by_slug(name)
        except ForumNotFound:
            return None

    # ---------------------------------------------------------------- Events
    @_translated
    async def now(self) -> tuple[str, datetime]:
        newest = await self._tracker.newest()
        await self._client.set_clock()
        return newest, self._client.clock.now()

    @_translated
    async def changes(self, after: str, limit: int = 100) -> tuple[Event, ...]:
        return await self._tracker.after(after, limit)

    async def stream(self, after: str, heartbeat_s: float = 0.5) -> AsyncIterator[Event]:
        """Yield events, triggered by the socket if available, and by polling each `heartbeat_s`: a heartbeat means that
        the latest posts were just read, which a quiet socket does not prove."""
        async with AsyncExitStack() as stack:
            await self._check_session()
            events, push = await self.changes(after), None
            if self._options.push and self._client.credentials.by_session:
                push = await stack.enter_async_context(Push(self._client))
            while True:
                for event in events:
                    after = event.id
                    yield event
                if not events:
                    yield Event("", EventKind.HEARTBEAT, self._client.clock.now())
                    await (push.wait(heartbeat_s) if push else asyncio.sleep(heartbeat_s))
                await self._check_session()
                events = await self.changes(after)

    async def _check_session(self) -> None:
        """Check now and then that the session is alive: without one NodeBB silently answers as to a guest."""
        if time.monotonic() - self._checked_s > CHECK_S:
            await self._client.check()
            self._checked_s = time.monotonic()


def _queued(name: str) -> ForumLimited:
    what = f"the forum keeps our post {name} until a moderator accepts it"
    return ForumLimited(f"{what}; put the robot's group into the groups exempt from the post queue", QUEUE_S)
