"""Read boards, topics and posts of a NodeBB, including each post's raw Markdown."""

from __future__ import annotations

import asyncio
import html
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from datetime import UTC, datetime
from html.parser import HTMLParser
from typing import Any
from urllib.parse import quote

import structlog

from agentrob.errors import ForumDenied, ForumError, ForumNotFound
from agentrob.forums.bounded import MOST_KNOWN, BoundedDict
from agentrob.forums.cards import card_by
from agentrob.forums.http import text_of
from agentrob.forums.nodebb.accounts import AccountAdmin, former
from agentrob.forums.nodebb.http import NodeBBClient
from agentrob.forums.nodebb.markers import pictures_in, unmark
from agentrob.forums.protocol import Board, Topic
from agentrob.language.rendered_text import is_mention, mention_of, rendering_differs
from agentrob.model import Account, AccountKind, Page, Post

_JSON = dict[str, Any]
BOARDS_AGE_S = 60.0
#: Posts of a page that are requested at the same time.
AT_ONCE = 6
_UPLOADS = "/assets/uploads/"
_log = structlog.get_logger()


class PostReader:
    """Reads posts as one account."""

    def __init__(self, client: NodeBBClient, accounts: AccountAdmin) -> None:
        self._client = client
        self._admin = accounts
        self._boards: list[tuple[int, Board]] = []
        self._boards_s = -BOARDS_AGE_S
        self._known = BoundedDict[str, Post](MOST_KNOWN)
        self._keys = BoundedDict[str, str | None](MOST_KNOWN)
        self._sizes: dict[str, int] = {}

    # ---------------------------------------------------------------- boards
    async def boards(self) -> tuple[Board, ...]:
        found = await self._client.get("/api/categories")
        self._boards = [(int(c["cid"]), _board(c)) for c in _flat(found["categories"]) if not c.get("disabled")]
        self._boards_s = time.monotonic()
        return tuple(board for _, board in self._boards)

    async def cid(self, board_id: str) -> int:
        """Return the category for a board's id (its handle or number)."""
        for _ in range(2):
            for cid, board in self._boards:
                if board_id in (board.id, str(cid)):
                    return cid
            await self.boards()
        known = ", ".join(board.id for _, board in self._boards)
        raise ForumNotFound(f"no board {board_id!r}; valid: {known}")

    async def _board_of(self, cid: int) -> str:
        if time.monotonic() - self._boards_s > BOARDS_AGE_S or cid not in dict(self._boards):
            await self.boards()
        found = dict(self._boards).get(cid)
        return found.id if found else str(cid)

    # ---------------------------------------------------------------- topics
    async def topic(self, topic_id: str) -> Topic:
        found = await self._client.get_v3(f"/topics/{own_place(topic_id)}")
        user = await self._client.get(f"/api/user/uid/{found.get('uid')}")
        return await self._topic({**found, "user": user})

    async def topics(self, board_id: str, cursor: str | None, limit: int) -> Page[Topic]:
        """List topics by latest activity, pinned ones first."""
        cid = await self.cid(board_id)
        start = _start(cursor)
        found, more = await self._rows(f"/api/category/{cid}", "topics", start, limit, sort="recently_replied")
        rows = [t for t in found if not t.get("deleted") and not t.get("scheduled")]
        items = tuple([await self._topic(t) for t in rows])
        return Page(items, str(start + limit) if more else None)

    async def _topic(self, t: _JSON) -> Topic:
        user = t.get("user") or {}
        author = await self._admin.writer(t["uid"], str(user.get("userslug") or ""), listed=True)
        title = html.unescape(str(t.get("titleRaw") or t["title"]))
        board = await self._board_of(int(t["cid"]))
        return Topic(str(t["tid"]), board, title, f"{self._client.url}/topic/{t['tid']}", author, _time(t["timestamp"]))

    # ---------------------------------------------------------------- posts
    async def posts(self, topic_id: str, cursor: str | None, limit: int) -> Page[Post]:
        start = _start(cursor)
        path = f"/api/topic/{own_place(topic_id)}"
        found, more = await self._rows(path, "posts", start, limit, sort="oldest_to_newest")
        gate = asyncio.Semaphore(AT_ONCE)

        async def read(pid: str) -> Post | None:
            async with gate:
                try:
                    return await self.post(pid, listed=True)
                except ForumNotFound:
                    return None
                except ForumError:
                    raise
                except Exception as e:
                    _log.warning("a post is not as NodeBB tells posts", post=pid, error=repr(e)[:200])
                    return None

        read_all = await asyncio.gather(*(read(str(p["pid"])) for p in found if int(p["pid"]) > 0))
        return Page(tuple(p for p in read_all if p is not None), str(start + limit) if more else None)

    async def post(self, post_id: str, listed: bool = False) -> Post:
        """Return the current post. A known post that is no longer visible was removed."""
        try:
            stored, shown = await asyncio.gather(self.stored(post_id), self._shown(post_id))
        except ForumNotFound:
            return await self._removed(post_id)
        user = shown.get("user") or {}
        author = await self._admin.writer(stored["uid"], str(user.get("userslug") or ""), listed)
        made = await self._post(stored, shown, author)
        self._known[made.id] = made
        return made

    async def stored(self, post_id: str) -> _JSON:
        """Return the stored fields of a post, including its raw text."""
        return await self._client.get_v3(f"/posts/{own_place(post_id)}")

    async def _shown(self, post_id: str) -> _JSON:
        return await self._client.get_v3(f"/posts/{own_place(post_id)}/summary")

    async def _removed(self, post_id: str) -> Post:
        """Return a post as removed. The posts of a removed topic are answered as if they had never existed."""
        await self._client.check()  # unless our session was over for a moment
        known = self._known.get(post_id)
        if known is None or await self._is_there(post_id):
            raise ForumNotFound(f"there is no post {post_id}")
        return replace(known, raw="", removed=True, mentions=(), images=(), card=None, rendering_differs=False)

    async def _is_there(self, post_id: str) -> bool:
        try:
            await self.stored(post_id)
        except ForumNotFound:
            return False
        return True

    async def _post(self, stored: _JSON, shown: _JSON, author: Account) -> Post:
        me = await self._admin.me()
        ours = author.id == me.id or author.kind is AccountKind.ROBOT_AGENT
        marked = unmark(text_of(stored.get("content") or ""), ours)
        removed, pid, html = bool(stored.get("deleted")), str(stored["pid"]), str(shown.get("content") or "")
        edited_ms, board_id = int(stored.get("edited") or 0), await self._board_of(int(shown["topic"]["cid"]))
        post = Post(
            id=pid,
            topic_id=str(stored["tid"]),
            board_id=board_id,
            author=author,
            raw=marked.text,
            created_at=_time(stored["timestamp"]),
            version=await self._version(pid) if edited_ms else 1,
            edited_at=_time(edited_ms) if edited_ms else None,
            mentions=mentions_in(html),
            reply_to=str(stored["toPid"]) if stored.get("toPid") else None,
            key=marked.key if author.id == me.id else None,
            url=f"{self._client.url}/post/{pid}",
            images=tuple(u for u in (*pictures_in(marked.text), *marked.pictures) if _UPLOADS in u),
            card=card_by(author, marked.card),
            rendering_differs=author.kind is not AccountKind.ROBOT_AGENT and rendering_differs(marked.text, html),
        )
        return (
            replace(post, raw="", removed=True, mentions=(), images=(), card=None, rendering_differs=False)
            if removed
            else post
        )

    async def _version(self, pid: str) -> int:
        """Return the version, from the edit history if it is kept and visible; otherwise 2."""
        try:
            history = await self._client.get_v3(f"/posts/{pid}/diffs")
            return max(2, len(history.get("timestamps") or ()))
        except (ForumDenied, ForumNotFound):
            return 2

    # ---------------------------------------------------------------- latest
    async def recent(self, page: int) -> list[_JSON]:
        """Return the forum's latest readable posts, newest first, 20 per page; moderators also get deleted ones."""
        found: list[_JSON] = await self._client.get("/api/recent/posts", page=page)
        if not isinstance(found, list):
            raise TypeError(found)
        readable = []
        for p in found:
            if not isinstance(p, dict) or type(p.get("pid")) is not int:
                continue  # from another server
            try:
                if (pid := str(p["pid"])) not in self._known:
                    self._known[pid] = await self._unread(pid, p)
            except ForumError:
                raise
            except Exception as e:  # one bad post must not block the others
                _log.warning("a listed post is not in the form that NodeBB sends", post=p["pid"], error=repr(e)[:200])
            readable.append(p)
        return readable

    async def _unread(self, pid: str, p: _JSON) -> Post:
        """Return enough of a post to report later that it was removed."""
        nobody = former(p["uid"])
        return Post(pid, str(p["tid"]), await self._board_of(int(p["topic"]["cid"])), nobody, "", _time(p["timestamp"]))

    async def search(self, query: str, board_id: str | None, cursor: str | None, limit: int) -> Page[Post]:
        start = _start(cursor)
        params: _JSON = {"term": query, "in": "titlesposts", "sortBy": "timestamp", "sortDirection": "desc"}
        params |= {"itemsPerPage": limit, "page": start // limit + 1}
        if board_id is not None:
            params["categories[]"] = await self.cid(board_id)
        found = await self._client.get("/api/search", **params)
        posts = [await self.post(str(p["pid"]), listed=True) for p in found["posts"]]
        more = start + limit < int(found["matchCount"])
        return Page(tuple(posts), str(start + limit) if more else None)

    # ---------------------------------------------------------------- our own, by key
    async def own_with_key(self, me: Account, key: str, pages: int) -> str | None:
        """Return our post with that key among our latest ones; the earliest of several."""
        found: list[int] = []
        for page in range(1, pages + 1):
            listed = (await self._client.get(f"/api/user/{quote(me.name, safe='')}/posts", page=page))["posts"]
            found += [int(p["pid"]) for p in listed if await self._key_of(str(p["pid"])) == key]
            if len(listed) < 20 or found:
                break
        return str(min(found)) if found else None

    async def own_in_topic(self, me: Account, key: str, topic_id: str, since_ms: int, pages: int) -> str | None:
        """Like `own_with_key`, among our recent posts in the topic; includes removed ones, which lists of our posts
        omit."""
        found: list[int] = []
        path, size = f"/api/topic/{own_place(topic_id)}", await self._page_size("posts")
        for page in range(1, pages + 1):
            listed = await self._client.get(path, page=page, sort="newest_to_oldest")
            ours = [p for p in listed["posts"] if str(p["uid"]) == me.id and int(p["timestamp"]) >= since_ms]
            found += [int(p["pid"]) for p in ours if await self._key_of(str(p["pid"])) == key]
            times = [int(p["timestamp"]) for p in listed["posts"] if p.get("index") != 0]
            if page * size >= int(listed["postcount"]) or min(times, default=0) < since_ms:
                break
        return str(min(found)) if found else None

    async def _key_of(self, pid: str) -> str | None:
        """Return the key of one of our posts. It never changes, so it is cached."""
        if pid not in self._keys:
            try:
                self._keys[pid] = unmark(str((await self.stored(pid)).get("content") or "")).key
            except ForumNotFound:
                return None
        return self._keys[pid]

    async def waiting(self, my_id: str, key: str) -> str | None:
        """Return the name of our post with that key in the moderation queue."""
        try:
            found = await self._client.get("/api/post-queue")
        except (ForumNotFound, ForumDenied):
            return None
        for queued in found["posts"]:
            data = queued["data"]
            raw = html.unescape(str(data.get("rawContent") or ""))
            if str(data.get("uid")) == my_id and unmark(raw).key == key:
                return str(queued["id"])
        return None

    # ---------------------------------------------------------------- pages
    async def _rows(self, path: str, what: str, start: int, limit: int, **params: Any) -> tuple[list[_JSON], bool]:
        """Return `limit` rows from `start` on, across the forum's pages, and whether there are more."""
        size = await self._page_size(what)
        rows: list[_JSON] = []
        count = start + 1
        page = start // size + 1
        while (page - 1) * size < min(start + limit, count):
            found = await self._client.get(path, page=page, **params)
            count = int(found["postcount" if what == "posts" else "topic_count"])
            rows += found[what]
            page += 1
        skipped = start % size
        return rows[skipped : skipped + limit], start + limit < count

    async def _page_size(self, what: str) -> int:
        if not self._sizes:
            config = await self._client.get("/api/config")
            self._sizes = {k: int(config[f"{k}PerPage"]) for k in ("posts", "topics")}
        return self._sizes[what]


class _Mentions(HTMLParser):
    """Collects the names that the forum made links of, except in quotes."""

    def __init__(self) -> None:
        super().__init__()
        self.names: list[str] = []
        self._quoted = 0
        self._unnamed = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        has = {name: value or "" for name, value in attrs}
        self._quoted += tag == "blockquote"
        if tag == "a" and not self._quoted and is_mention(has):
            self.names.append(name := mention_of(has))
            self._unnamed = not name

    def handle_data(self, data: str) -> None:
        if self._unnamed:  # before plugin 5 the link has a number
            self.names[-1] += data.strip().lstrip("@").lower()

    def handle_endtag(self, tag: str) -> None:
        self._quoted -= tag == "blockquote" and self._quoted > 0
        self._unnamed = self._unnamed and tag != "a"


def mentions_in(content: str) -> tuple[str, ...]:
    """Return the handles of the accounts that a post's HTML mentions."""
    reader = _Mentions()
    with suppress(Exception):  # the parser fails on some malformed declarations; keep what it found before
        reader.feed(content)
    return tuple(dict.fromkeys(name for name in reader.names if name))


def own_place(number: str) -> str:
    """Return the number of a post or topic for an address. Posts of other servers, whose ids are addresses, are not
    found."""
    if not number.isdigit():
        raise ForumNotFound(f"there is no {number!r} on this forum")
    return number


def _flat(categories: Sequence[_JSON]) -> list[_JSON]:
    return [c for top in categories for c in (top, *_flat(top.get("children") or ()))]


def _board(c: _JSON) -> Board:
    handle = str(c.get("handle") or str(c["slug"]).rpartition("/")[2] or c["cid"])
    return Board(handle, html.unescape(str(c["name"])), html.unescape(str(c.get("description") or "")))


def _start(cursor: str | None) -> int:
    if cursor is not None and not cursor.isdigit():
        raise ForumNotFound(f"there is no page {cursor!r}")
    return int(cursor or 0)


def _time(ms: Any) -> datetime:
    return datetime.fromtimestamp(int(ms) / 1000, UTC)
