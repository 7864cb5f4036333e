"""The adapter for Discourse: its JSON API by key or session, and its message bus for events.

The adapter adds what Discourse lacks: one post per key (`markers`), a list of changes (`events`), and kinds and roles
of accounts (groups, `settings`). `docs/forum/discourse.md` explains the setup for admins.
"""

from __future__ import annotations

import time
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime, timedelta
from typing import Any

from agentrob.config.forum import ForumConfig
from agentrob.errors import ForumDenied, ForumError, ForumMalformed, ForumNotFound, ForumUnreachable
from agentrob.forums.bounded import MOST_KNOWN, BoundedDict
from agentrob.forums.cards import card_by
from agentrob.forums.discourse import settings as settings_of
from agentrob.forums.discourse.admin import AccountAdmin, create_account, notifications_of
from agentrob.forums.discourse.events import ChangeTracker, removed
from agentrob.forums.discourse.http import DiscourseClient
from agentrob.forums.discourse.mapping import VersionTracker, boards_of, number_of, path_segment, stranger_of, time_of
from agentrob.forums.discourse.markers import mentions_and_images, unmark
from agentrob.forums.discourse.message_bus import listen
from agentrob.forums.discourse.settings import Credentials, DiscourseOptions
from agentrob.forums.discourse.writer import PostWriter
from agentrob.forums.http import text_of, translate_errors
from agentrob.forums.protocol import Board, Event, Notification, Registered, Topic, Written
from agentrob.language.rendered_text import rendering_differs
from agentrob.model import Account, AccountKind, Page, Post, Role, StatusCard

#: How long an account is remembered for lists and events; single posts and accounts are always requested.
REMEMBERED_S = 60.0
#: Posts per page of `/search.json`.
RESULTS_A_PAGE = 50
#: Topics per page of `/c/{slug}/{id}.json`.
TOPICS_A_PAGE = 30
_KEPT = 2_000
_JSON = Mapping[str, Any]


class DiscourseForum:
    """A Discourse, signed in as one account; fulfils `Forum`. Makes no request before the first call.

    `live` says whether posts are pushed, which depends on the request limit of the key. Otherwise `changes` may be
    called every `fastest_poll_s`.
    """

    max_edits: int | None = None

    def __init__(self, settings: ForumConfig, token: str) -> None:
        self.options = DiscourseOptions.of(settings.options)
        self._client = DiscourseClient(settings.url, Credentials.of(token))
        self._set_pace()
        self._remembered = BoundedDict[str, tuple[float, Account]](MOST_KNOWN)
        self._numbers = BoundedDict[tuple[int, int], str](_KEPT)
        self._places = BoundedDict[str, int](_KEPT)
        self._versions = VersionTracker()
        self._boards: dict[int, Board] = {}
        self._topic_boards = BoundedDict[int, int](_KEPT)
        self._me: Account | None = None
        self._tracker = ChangeTracker(self)
        self._writer = PostWriter(self, self._client, self.options)

    def _set_pace(self) -> None:
        user_key = "User-Api-Key" in self._client.credentials.headers
        usual = settings_of.USER_KEY_REQUESTS_PER_MINUTE if user_key else settings_of.DEFAULT_REQUESTS_PER_MINUTE
        may = self.options.requests_per_minute or usual
        self.live = self.options.push and may >= settings_of.LIVE_REQUESTS_PER_MINUTE
        # Half of the allowed requests are for events, the other half for reading and writing.
        self.fastest_poll_s = 120.0 / may

    async def close(self) -> None:
        await self._client.close()

    # ---------------------------------------------------------------- Reader
    async def boards(self) -> Sequence[Board]:
        found = await self._client.get("/categories.json", include_subcategories="true")
        with translate_errors():
            self._boards = dict(boards_of(found["category_list"]["categories"]))
            return tuple(self._boards.values())

    async def topic(self, topic_id: str) -> Topic:
        t = await self._client.get(f"/t/{number_of(topic_id, 'topic')}.json")
        with translate_errors():
            author = await self._known(t["details"]["created_by"]["username"])
            return self._as_topic(t, await self._board_id(int(t["category_id"])), author)

    async def topics(self, board_id: str, cursor: str | None = None, limit: int = 20) -> Page[Topic]:
        """List topics by latest activity. Authors have their remembered rights, or none."""
        number, path = await self.category(board_id)
        start = int(cursor) if cursor and cursor.isdigit() else 0
        page, skip = divmod(start, TOPICS_A_PAGE)
        found = await self._client.get(f"/c/{path}/{number}.json", page=page)
        with translate_errors():
            users = {u["id"]: u["username"] for u in found.get("users") or ()}
            topics = [t for t in found["topic_list"]["topics"] if int(t["category_id"]) == number]
            shown = topics[skip : skip + limit]
            more = len(topics) > skip + limit or len(found["topic_list"]["topics"]) >= TOPICS_A_PAGE
            items = tuple(self._as_topic(t, board_id, self._poster(t, users)) for t in shown)
            return Page(items, str(start + len(shown)) if more and shown else None)

    async def posts(self, topic_id: str, cursor: str | None = None, limit: int = 50) -> Page[Post]:
        number = number_of(topic_id, "topic")
        stream = [int(n) for n in (await self.topic_json(number))["post_stream"]["stream"]]
        after = int(cursor) if cursor and cursor.isdigit() else 0
        wanted = [n for n in stream if n > after]
        raws = await self.raw_posts(number, wanted[:limit])
        items = []
        for n in wanted[:limit]:
            with suppress(ForumMalformed):  # skip one that cannot be read
                items += [await self.build(raws[n])] if n in raws else []
        return Page(tuple(items), str(wanted[limit - 1]) if len(wanted) > limit else None)

    async def post(self, post_id: str) -> Post:
        number = number_of(post_id, "post")
        raw = await self.one(number)
        if raw is not None:
            return await self.build(raw, fresh=True)
        if (known := self._tracker.last_known(number)) is None:
            raise ForumNotFound(f"there is no post {post_id}")
        author = await self.account(known.author.name) or known.author
        return Post(known.id, known.topic_id, known.board_id, author, "", known.created_at, known.version, removed=True)

    async def search(
        self, query: str, *, board_id: str | None = None, cursor: str | None = None, limit: int = 10
    ) -> Page[Post]:
        """Return posts that contain all words of the query, newest first. Search operators (`in:`, `@`, `#`) are
        removed, so that a query cannot search an account's private messages."""
        words = [w for w in query.split() if ":" not in w and not w.startswith(("@", "#", "-"))]
        if not words:
            return Page(())
        place = "#" + (await self.category(board_id))[1].replace("/", ":") if board_id else ""
        start = int(cursor) if cursor and cursor.isdigit() else 0
        page, skip = divmod(start, RESULTS_A_PAGE)
        term = " ".join(filter(None, (*words, place, "order:latest")))
        found = (await self._client.get("/search.json", q=term, page=page + 1))["posts"] or []
        with translate_errors():
            hits = [(int(p["topic_id"]), int(p["id"])) for p in found]
        shown = hits[skip : skip + limit]
        posts: dict[int, Mapping[str, Any]] = {}
        for topic_id in dict.fromkeys(t for t, _ in shown):
            posts |= await self.raw_posts(topic_id, [n for t, n in shown if t == topic_id])
        items = [await self.build(posts[n]) for _, n in shown if n in posts]
        more = len(hits) > skip + limit or len(found) >= RESULTS_A_PAGE
        return Page(tuple(items), str(start + len(shown)) if more and shown else None)

    async def download(self, url: str) -> bytes:
        return await self._client.bytes(url)

    # ---------------------------------------------------------------- Writer
    async def create_topic(
        self, board_id: str, title: str, body: str, *, key: str, images: Sequence[bytes] = ()
    ) -> Written:
        return await self._writer.create_topic(board_id, title, body, key, images)

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
        return await self._writer.reply(number_of(topic_id, "topic"), body, key, reply_to, images, card)

    async def edit(
        self, post_id: str, body: str, *, images: Sequence[bytes] = (), card: StatusCard | None = None
    ) -> Post:
        return await self._writer.edit(number_of(post_id, "post"), body, images, card)

    async def find(self, key: str) -> Post | None:
        return await self._writer.find(key)

    # ---------------------------------------------------------------- Accounts
    async def me(self) -> Account:
        name = self._client.credentials.name
        if not name:
            name = (await self._client.get("/session/current.json"))["current_user"]["username"]
        me = await self.account(name)
        if me is None:
            raise ForumDenied(f"the forum has no account {name}")
        self._me = me
        return me

    async def account(self, name: str) -> Account | None:
        try:
            found = await self._client.get(f"/u/{path_segment(name)}.json")
        except ForumNotFound:
            return None
        with translate_errors():
            account = settings_of.account(found["user"], self.options)
        self._remembered[account.name] = (time.monotonic(), account)
        return account

    async def switch(self, name: str) -> Account:
        """Act as this account from now on; needs an API key for all users. After `ForumDenied` nothing has changed."""
        before = self._client.credentials
        if "Api-Key" not in before.headers:
            raise ForumDenied("switching accounts needs an API key for all users")
        self._client.credentials = before.named(name)
        try:
            me = await self.me()
        except ForumError:
            self._client.credentials = before
            raise
        self._writer = PostWriter(self, self._client, self.options)
        self._tracker = ChangeTracker(self)
        return me

    async def create_account(self, name: str, email: str, password: str, display_name: str = "") -> Account | None:
        """Create an account: at once with an admin's API key, otherwise as visitors do. Returns None if it must first
        be confirmed by e-mail or approved."""
        if not await create_account(self._client, name, email, password, display_name):
            return None
        return await self.account(name)

    async def register(self, name: str, *, kind: AccountKind = AccountKind.HUMAN, display_name: str = "") -> Registered:
        return await AccountAdmin(self, self._client).register(name, kind, display_name)

    async def set_rights(self, name: str, *, role: Role | None = None, suspended: bool | None = None) -> Account:
        return await AccountAdmin(self, self._client).set_rights(name, role, suspended)

    async def notifications(self, cursor: str | None = None, limit: int = 20) -> Page[Notification]:
        return await notifications_of(self, self._client, cursor, limit)

    # ---------------------------------------------------------------- Events
    async def now(self) -> tuple[str, datetime]:
        return await self._tracker.now()

    async def changes(self, after: str, limit: int = 100) -> tuple[Event, ...]:
        return await self._tracker.changes(after, limit)

    async def stream(self, after: str, heartbeat_s: float = 0.5) -> AsyncIterator[Event]:
        if not self.live:
            raise ForumUnreachable("this key's request limit is too low for push; poll changes()")
        async for event in listen(self._tracker, self._client, after, heartbeat_s):
            yield event

    async def mentions(self, limit: int = 30) -> tuple[Post, ...]:
        """Return posts that mention this account, newest first, from its notifications."""
        return tuple(n.post for n in (await self.notifications(limit=limit)).items if n.kind == "mention")

    # ---------------------------------------------------------------- what the other parts need
    async def newest(self, before: int | None) -> Sequence[_JSON]:
        found = await self._client.get("/posts.json", **({"before": before} if before else {}))
        with translate_errors():
            posts: list[_JSON] = found["latest_posts"]
            return sorted(posts, key=lambda p: -int(p["id"]))

    async def one(self, post_id: int) -> _JSON | None:
        try:
            raw: _JSON = await self._client.get(f"/posts/{post_id}.json")
        except ForumNotFound:
            return None
        except ForumDenied:
            await self.me()  # is the post gone, or has our session ended?
            return None
        return raw

    def clock(self) -> datetime:
        if self._client.clock_at is None:
            return datetime.now(UTC)
        said, then_s = self._client.clock_at
        return said + timedelta(seconds=time.monotonic() - then_s)

    async def myself(self) -> Account:
        return self._me or await self.me()

    async def topic_json(self, topic_id: int, **query: Any) -> _JSON:
        found: _JSON = await self._client.get(f"/t/{topic_id}.json", **query)
        with translate_errors():
            self._topic_boards[topic_id] = int(found["category_id"])
        return found

    async def number_of(self, post_id: str) -> int | None:
        """Return a post's position in its topic."""
        if post_id not in self._places:
            raw = await self.one(number_of(post_id, "post"))
            if raw is None:
                return None
            self._remember(int(raw["topic_id"]), int(raw["post_number"]), post_id)
        return self._places[post_id]

    async def by_number(self, topic_id: int, number: int) -> _JSON | None:
        try:
            raw: _JSON = await self._client.get(f"/posts/by_number/{topic_id}/{number}.json")
        except (ForumNotFound, ForumDenied):
            return None
        return raw

    async def raw_posts(self, topic_id: int, post_ids: Sequence[int]) -> dict[int, _JSON]:
        """Return posts of a topic with their raw text, fifty per request."""
        found: dict[int, _JSON] = {}
        for start in range(0, len(post_ids), 50):
            query = {"post_ids[]": list(post_ids[start : start + 50]), "include_raw": "true"}
            answer = await self._client.get(f"/t/{topic_id}/posts.json", **query)
            with translate_errors():
                found |= {int(p["id"]): p for p in answer["post_stream"]["posts"]}
        for post_id in [n for n, raw in found.items() if "raw" not in raw]:  # an old Discourse
            if (raw := await self.one(post_id)) is not None:
                found[post_id] = raw
        return found

    async def category(self, board_id: str) -> tuple[int, str]:
        """Return a category's number and path of slugs."""
        for attempt in (1, 2):
            for number, board in self._boards.items():
                if board.id == board_id:
                    return number, board_id
            if attempt == 1:
                await self.boards()
        raise ForumNotFound(f"no board {board_id!r}; valid: {', '.join(b.id for b in self._boards.values())}")

    async def build(self, raw: _JSON, fresh: bool = False) -> Post:
        """Build our post from Discourse's; `fresh`: with its author's current rights."""
        with translate_errors():
            name, number, post_id = str(raw["username"]), int(raw["topic_id"]), int(raw["id"])
            author = (await self.account(name) if fresh else await self._known(name)) or stranger_of(raw)
            self._remember(number, int(raw["post_number"]), str(post_id))
            created_at, version, gone = time_of(raw["created_at"]), self._versions.of(raw), removed(raw)
            me = await self.myself()
            cooked, robots = str(raw["cooked"]), author.kind is AccountKind.ROBOT_AGENT
            ours = author.id == me.id or robots
            marked, (mentioned, pictures) = unmark(text_of(raw["raw"]), ours), mentions_and_images(cooked)
            return Post(
                id=str(post_id),
                topic_id=str(number),
                board_id=await self._board_of(raw, fresh),
                author=author,
                raw="" if gone else marked.text,
                created_at=created_at,
                version=version,
                edited_at=time_of(raw["updated_at"]) if version > 1 else None,
                removed=gone,
                mentions=() if gone else mentioned,
                reply_to=await self._answered(number, raw.get("reply_to_post_number")),
                key=self._writer.own_key(marked.key) if author.id == me.id else None,
                url=str(self._client.base.join(f"/t/{raw.get('topic_slug') or '-'}/{number}/{raw['post_number']}")),
                images=() if gone else tuple(str(self._client.base.join(p)) for p in pictures),
                card=None if gone else card_by(author, marked.card),
                rendering_differs=not gone and not robots and rendering_differs(marked.text, cooked),
            )

    # ---------------------------------------------------------------- inside
    async def _known(self, name: str) -> Account:
        """Return an account, remembered for a while; a deleted account has no rights."""
        at_s, account = self._remembered.get(name.lower(), (-REMEMBERED_S, None))
        if account is None or time.monotonic() - at_s > REMEMBERED_S:
            account = await self.account(name)
        return account or Account("0", name.lower(), AccountKind.MONITORING_AGENT)

    def _poster(self, t: _JSON, users: Mapping[Any, str]) -> Account:
        """Return who began a listed topic: its first poster."""
        number = next((p["user_id"] for p in t.get("posters") or ()), 0)
        name = users.get(number, "").lower()
        remembered = self._remembered.get(name)
        return remembered[1] if remembered else Account(str(number), name)

    async def _board_of(self, raw: _JSON, fresh: bool = False) -> str:
        """Return the board of a topic; `fresh`: ask again, since a moderator may have moved it."""
        number = int(raw["topic_id"])
        if fresh:
            self._topic_boards.pop(number, None)
        if "category_id" in raw:
            self._topic_boards[number] = int(raw["category_id"])
        if number not in self._topic_boards:
            await self.topic_json(number)
        return await self._board_id(self._topic_boards[number])

    async def _board_id(self, category: int) -> str:
        if category not in self._boards:
            await self.boards()
        board = self._boards.get(category)
        return board.id if board else str(category)

    def _remember(self, topic_id: int, number: int, post_id: str) -> None:
        self._numbers[topic_id, number] = post_id
        self._places[post_id] = number

    async def _answered(self, topic_id: int, number: int | None) -> str | None:
        """Return the post that a reply answers; Discourse gives its position in the topic."""
        if number is None:
            return None
        if (topic_id, int(number)) not in self._numbers:
            raw = await self.by_number(topic_id, int(number))
            if raw is None:
                return None
            self._remember(topic_id, int(number), str(raw["id"]))
        return self._numbers[topic_id, int(number)]

    def _as_topic(self, t: _JSON, board_id: str, author: Account) -> Topic:
        url = str(self._client.base.join(f"/t/{t['slug']}/{t['id']}"))
        return Topic(str(t["id"]), board_id, t["title"], url, author, time_of(t["created_at"]))
