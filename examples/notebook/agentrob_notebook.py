"""A forum in one file: the example of a third-party forum adapter (docs/forum/add-a-forum.md).

`forum.jsonl` has one line per event, oldest first; pictures are stored beside it. Anyone who can write to the folder
can post under any name, so use it for experiments only.
"""

from __future__ import annotations

import asyncio
import fcntl
import json
import re
import sys
from collections.abc import AsyncIterator, Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypeVar
from uuid import uuid4

from agentrob import (
    Account,
    AccountKind,
    Board,
    ConfigError,
    Event,
    EventKind,
    ForumConfig,
    ForumDenied,
    ForumNotFound,
    ForumUnreachable,
    Page,
    Post,
    Role,
    StatusCard,
    Topic,
    Written,
    card_by,
)

T = TypeVar("T")
BOARD = Board("robots", "Robots")
KINDS = {"create": EventKind.POST_CREATED, "edit": EventKind.POST_EDITED, "remove": EventKind.POST_REMOVED}
OPTIONS = ("operators", "admins", "robot_agents", "commanding_agents")


@dataclass
class Pages:
    """The state of the forum after all lines."""

    mark: str = ""
    posts: dict[str, Post] = field(default_factory=dict)
    topics: dict[str, Topic] = field(default_factory=dict)
    accounts: dict[str, Account] = field(default_factory=dict)
    keys: dict[tuple[str, str], str] = field(default_factory=dict)
    events: list[tuple[EventKind, str, datetime]] = field(default_factory=list)


class Notebook:
    """See `agentrob.forums.protocol.Forum`. `url` is a folder, the token is the account's name;
    there are no secrets."""

    max_edits: int | None = None
    live = False
    fastest_poll_s = 0.2

    def __init__(self, settings: ForumConfig, token: str) -> None:
        if wrong := sorted(settings.options.keys() - set(OPTIONS)):
            raise ConfigError(f"forum.options has no {', '.join(wrong)}; valid are: {', '.join(OPTIONS)}")
        self._folder = Path(settings.url)
        self._rights = settings.options
        self._name = token.lower()

    async def close(self) -> None:
        """Do nothing: no resources are open."""

    # ---------------------------------------------------------------- Reader
    async def boards(self) -> Sequence[Board]:
        self._read()
        return (BOARD,)

    async def topic(self, topic_id: str) -> Topic:
        return _there(self._read().topics, topic_id, "topic")

    async def topics(self, board_id: str, cursor: str | None = None, limit: int = 20) -> Page[Topic]:
        pages = self._read()
        if board_id != BOARD.id:
            raise ForumNotFound(f"there is no board {board_id!r}; there is: {BOARD.id}")
        latest = dict.fromkeys(p.topic_id for p in reversed(pages.posts.values()))
        return _page([pages.topics[t] for t in latest], cursor, limit)

    async def posts(self, topic_id: str, cursor: str | None = None, limit: int = 50) -> Page[Post]:
        pages = self._read()
        _there(pages.topics, topic_id, "topic")
        return _page([self._shown(pages, p.id) for p in pages.posts.values() if p.topic_id == topic_id], cursor, limit)

    async def post(self, post_id: str) -> Post:
        return self._shown(self._read(), post_id)

    async def download(self, url: str) -> bytes:
        path = self._folder / Path(url).name
        if not path.is_file():
            raise ForumNotFound(f"there is no picture {url}")
        return path.read_bytes()

    # ---------------------------------------------------------------- Writer
    async def create_topic(
        self, board_id: str, title: str, body: str, *, key: str, images: Sequence[bytes] = ()
    ) -> Written:
        await self.topics(board_id)
        return self._create(key, images, {"title": title, "body": body})

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
        await self.topic(topic_id)
        about = {"topic": topic_id, "reply_to": reply_to, "card": asdict(card) if card else None}
        return self._create(key, images, {"body": body, **about})

    async def edit(
        self, post_id: str, body: str, *, images: Sequence[bytes] = (), card: StatusCard | None = None
    ) -> Post:
        with self._writing() as (pages, write):
            post = _there(pages.posts, post_id, "post")
            if post.author.name != self._name:
                raise ForumDenied(f"post {post_id} belongs to {post.author.name}")
            write("edit", id=post_id, body=body, images=self._keep(images), card=asdict(card) if card else None)
        return await self.post(post_id)

    async def find(self, key: str) -> Post | None:
        pages = self._read()
        post_id = pages.keys.get((self._name, key))
        return self._shown(pages, post_id) if post_id else None

    # ---------------------------------------------------------------- Accounts
    async def me(self) -> Account:
        return self._account(self._name, self._read())

    async def account(self, name: str) -> Account | None:
        pages = self._read()
        known = {*pages.accounts, *(n for names in self._rights.values() for n in names)}
        return self._account(name, pages) if name in known else None

    # ---------------------------------------------------------------- Events
    async def now(self) -> tuple[str, datetime]:
        pages = self._read()
        return f"{len(pages.events)}-{pages.mark}", datetime.now(UTC)

    async def changes(self, after: str, limit: int = 100) -> tuple[Event, ...]:
        pages = self._read()
        number, _, mark = after.partition("-")
        if mark != pages.mark or not number.isdigit() or int(number) > len(pages.events):
            raise ForumNotFound(f"{after} is no event of this notebook")
        first = int(number)
        return tuple(
            Event(f"{n}-{mark}", kind, at, post=self._shown(pages, post_id))
            for n, (kind, post_id, at) in enumerate(pages.events[first : first + limit], first + 1)
        )

    async def stream(self, after: str, heartbeat_s: float = 0.5) -> AsyncIterator[Event]:
        raise ForumUnreachable("a notebook has no stream; poll changes()")
        yield

    # ---------------------------------------------------------------- moderation
    def suspend(self, name: str) -> None:
        with self._writing() as (_, write):
            write("suspend", name=name)

    def remove(self, post_id: str) -> None:
        with self._writing() as (_, write):
            write("remove", id=post_id)

    def open(self) -> Notebook:
        """Create the notebook if it does not exist, and sign in."""
        self._folder.mkdir(parents=True, exist_ok=True)
        (self._folder / "forum.jsonl").touch()
        with self._writing() as (pages, write):
            if not pages.mark:
                write("begin", mark=uuid4().hex[:8])
            if self._name not in pages.accounts:
                write("account", name=self._name)
        return self

    # ---------------------------------------------------------------- inside
    def _read(self) -> Pages:
        try:
            text = (self._folder / "forum.jsonl").read_text(encoding="utf-8")
        except OSError as e:
            raise ForumUnreachable(f"there is no notebook in {self._folder}: {e.strerror}") from None
        pages = Pages()
        for line in text.rpartition("\n")[0].splitlines():  # the last line may be incomplete
            self._add(pages, json.loads(line))
        return pages

    def _add(self, pages: Pages, line: Mapping[str, Any]) -> None:
        at, what = datetime.fromisoformat(line["at"]), line["what"]
        if what == "begin":
            pages.mark = line["mark"]
        elif what == "account":
            pages.accounts[line["name"]] = self._account(line["name"], pages)
        elif what == "suspend":
            pages.accounts[line["name"]] = replace(self._account(line["name"], pages), suspended=True)
        elif what == "create":
            self._add_post(pages, line, at)
        elif what == "edit":
            post = pages.posts[line["id"]]
            pages.posts[post.id] = replace(
                post, raw=line["body"], version=post.version + 1, edited_at=at,
                card=card_by(post.author, _card(line)) or post.card,
                images=(*post.images, *line["images"]), mentions=_mentions(pages, line["body"]),
            )  # fmt: skip
        elif what == "remove":
            pages.posts[line["id"]] = replace(pages.posts[line["id"]], removed=True)
        if what in KINDS:
            pages.events.append((KINDS[what], line["id"], at))

    def _add_post(self, pages: Pages, line: Mapping[str, Any], at: datetime) -> None:
        author = self._account(line["by"], pages)
        pages.accounts.setdefault(author.name, author)
        topic_id = line.get("topic") or line["id"]
        if not line.get("topic"):
            pages.topics[topic_id] = Topic(topic_id, BOARD.id, line["title"], f"notebook:{topic_id}", author, at)
        pages.posts[line["id"]] = Post(
            line["id"], topic_id, BOARD.id, author, line["body"], at, key=line["key"],
            card=card_by(author, _card(line)),
            mentions=_mentions(pages, line["body"]), reply_to=line.get("reply_to"), images=tuple(line["images"]),
        )  # fmt: skip
        pages.keys[author.name, line["key"]] = line["id"]

    def _create(self, key: str, images: Sequence[bytes], about: Mapping[str, Any]) -> Written:
        with self._writing() as (pages, write):
            old = pages.keys.get((self._name, key))
            post_id = old or str(len(pages.posts) + 1)
            if old is None:
                write("create", id=post_id, by=self._name, key=key, images=self._keep(images), **about)
        return Written(self._shown(self._read(), post_id), created=old is None)

    @contextmanager
    def _writing(self) -> Iterator[tuple[Pages, Callable[..., None]]]:
        """Lock the file, so that one process writes at a time and reads the current state."""
        self._read()
        with (self._folder / "forum.jsonl").open("a", encoding="utf-8") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            pages = self._read()
            if self._account(self._name, pages).suspended:
                raise ForumDenied(f"{self._name} is suspended")

            def write(what: str, **more: Any) -> None:
                file.write(json.dumps({"what": what, "at": datetime.now(UTC).isoformat(), **more}) + "\n")
                file.flush()

            yield pages, write

    def _keep(self, images: Sequence[bytes]) -> list[str]:
        names = [f"{uuid4().hex}.picture" for _ in images]
        for name, image in zip(names, images, strict=True):
            (self._folder / name).write_bytes(image)
        return names

    def _account(self, name: str, pages: Pages) -> Account:
        """An account with the rights of the configuration; one that is in no list may only look and stop."""
        of = {option: name in self._rights.get(option, ()) for option in OPTIONS}
        role = Role.ADMIN if of["admins"] else Role.OPERATOR if of["operators"] else Role.MEMBER
        kind = AccountKind.HUMAN
        if of["robot_agents"] or of["commanding_agents"]:
            kind = AccountKind.ROBOT_AGENT if of["robot_agents"] else AccountKind.COMMANDING_AGENT
        suspended = name in pages.accounts and pages.accounts[name].suspended
        return Account(f"n:{name}", name, kind, role, suspended, name)

    def _shown(self, pages: Pages, post_id: str) -> Post:
        """A post with the current state of its author's account; only the author sees its key."""
        post = _there(pages.posts, post_id, "post")
        own = post.author.name == self._name
        return replace(post, author=self._account(post.author.name, pages), key=post.key if own else None)


def _there(known: Mapping[str, T], name: str, what: str) -> T:
    if name not in known:
        raise ForumNotFound(f"there is no {what} {name}")
    return known[name]


def _card(line: Mapping[str, Any]) -> StatusCard | None:
    return StatusCard(**line["card"]) if line.get("card") else None


def _mentions(pages: Pages, text: str) -> tuple[str, ...]:
    return tuple(dict.fromkeys(n for n in re.findall(r"(?<!\w)@([a-z][a-z0-9_-]*)", text) if n in pages.accounts))


def _page(items: Sequence[T], cursor: str | None, limit: int) -> Page[T]:
    start = int(cursor or 0)
    end = start + limit
    return Page(tuple(items[start:end]), str(end) if end < len(items) else None)


async def ask(folder: str, name: str, text: str = "", wait_s: float = 60.0) -> str:
    """Sign in (creating account and notebook if needed), post, and wait for the robot's answer."""
    robots = re.findall(r"@([a-z][a-z0-9_-]*)", text)  # without a list of robots, take every mention for one
    forum = Notebook(ForumConfig(kind="notebook", url=folder, options={"robot_agents": robots}), name).open()
    if not text:
        return f"{name} is in {folder}"
    post = (await forum.create_topic(BOARD.id, text[:60], text, key=uuid4().hex)).post
    async with asyncio.timeout(wait_s):
        while True:
            for answer in (await forum.posts(post.topic_id)).items[1:]:
                if answer.card and answer.card.state not in ("seen", "queued", "running"):
                    return answer.raw
            await asyncio.sleep(forum.fastest_poll_s)


if __name__ == "__main__":
    print(asyncio.run(ask(*sys.argv[1:4])))
