"""Write to Discourse: one post per key, also after lost answers, moderation queues, rate limits and retries.

Before a reply is written, the account's own posts in the topic are searched for its key. If somebody else posted in
between, they are searched again afterwards; of two posts with the same key, the older one is kept.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from agentrob.errors import ForumDenied, ForumError, ForumLimited, ForumNotFound
from agentrob.forums.bounded import BoundedDict
from agentrob.forums.discourse import markers as marks
from agentrob.forums.discourse.http import DiscourseClient, Refused
from agentrob.forums.discourse.settings import DiscourseOptions
from agentrob.forums.http import image_file, text_of, translate_errors
from agentrob.forums.protocol import Written
from agentrob.model import Account, Post, StatusCard

#: How many own posts of a topic, and how many topics, are searched for a key; newest first.
SEARCHED_POSTS, SEARCHED_TOPICS = 300, 20
#: How often to ask whether a moderator has approved a post.
APPROVAL_S = 30.0
_JSON = Mapping[str, Any]
_KEPT, _KEPT_TURNS = 2_000, 500


class PostSource(Protocol):
    """The reading side, as needed for writing."""

    async def myself(self) -> Account: ...

    async def post(self, post_id: str) -> Post: ...

    async def one(self, post_id: int) -> _JSON | None: ...

    async def number_of(self, post_id: str) -> int | None:
        """Return a post's position in its topic."""
        ...

    async def topic_json(self, topic_id: int, **query: Any) -> _JSON: ...

    async def raw_posts(self, topic_id: int, post_ids: Sequence[int]) -> dict[int, _JSON]: ...

    async def category(self, board_id: str) -> tuple[int, str]: ...

    async def build(self, raw: _JSON, fresh: bool = False) -> Post: ...


class ReadPosts(BoundedDict[int, str | None]):
    """Posts that were read, with the key of our own ones. `first` is the oldest post of a key.

    Dropped posts count as unread, so that their keys are found on the forum again.
    """

    def __init__(self, most: int) -> None:
        super().__init__(most)
        self._first: dict[str, int] = {}

    def first(self, key: str) -> int | None:
        return self._first.get(key)

    def __setitem__(self, post_id: int, key: str | None) -> None:
        self.dropped(post_id, self.get(post_id))
        if key is not None:
            self._first[key] = min(post_id, self._first.get(key, post_id))
        super().__setitem__(post_id, key)

    def dropped(self, key: int, value: str | None) -> None:
        if value is not None and self._first.get(value) == key:
            del self._first[value]


class PostWriter:
    """Writes as one account. Writes with the same key run one after another."""

    def __init__(self, source: PostSource, client: DiscourseClient, options: DiscourseOptions) -> None:
        self._source = source
        self._client = client
        self._prefix = options.key_prefix
        self._turns: OrderedDict[str, asyncio.Lock] = OrderedDict()
        self._read = ReadPosts(_KEPT)
        #: Keys of posts that wait for a moderator; None: not requested yet.
        self._waiting: set[str] | None = None

    def own_key(self, key: str | None) -> str | None:
        """Return the writer's key from that of a marker, None if it is not ours."""
        return key.removeprefix(self._prefix) if key and key.startswith(self._prefix) else None

    # ---------------------------------------------------------------- topics
    async def create_topic(self, board_id: str, title: str, body: str, key: str, images: Sequence[bytes]) -> Written:
        async with self._turn(key):
            await self._not_waiting(key)
            if (old := await self._topic_of(key) or await self._by_search(key)) is not None:
                return Written(old, created=False)
            self._not_rejected(key)
            number, _ = await self._source.category(board_id)
            raw = marks.mark(marks.MarkedText(body, self._prefix + key, None, await self._upload(images)))
            content = {"title": title, "raw": raw, "category": number}
            if self._client.credentials.by_api_key:
                content["external_id"] = await self._external_id(key)
            try:
                sent = await self._create(key, content)
            except Refused:  # perhaps an answer was lost, and the topic exists
                if (old := await self._topic_of(key) or await self._by_search(key)) is not None:
                    return Written(old, created=False)
                raise
            return Written(await self._noted(key, {**sent, "raw": raw, "category_id": number}))

    async def _topic_of(self, key: str) -> Post | None:
        """Return the first post of the topic with this key's `external_id`, which only API keys may set."""
        if not self._client.credentials.by_api_key:
            return None
        try:
            led = await self._client.location(f"/t/external_id/{await self._external_id(key)}.json")
        except (ForumNotFound, ForumDenied):
            return None
        with translate_errors():
            number = next(int(p) for p in led.partition("?")[0].removesuffix(".json").split("/")[::-1] if p.isdigit())
            first = (await self._source.topic_json(number))["post_stream"]["stream"][0]
            self._read[int(first)] = key
        return await self._source.post(str(first))

    async def _external_id(self, key: str) -> str:
        return marks.external_id((await self._source.myself()).id, self._prefix + key)

    # ---------------------------------------------------------------- replies
    async def reply(
        self,
        topic_id: int,
        body: str,
        key: str,
        reply_to: str | None,
        images: Sequence[bytes],
        card: StatusCard | None,
    ) -> Written:
        async with self._turn(key):
            await self._not_waiting(key)
            highest = await self._search(topic_id)
            if (old := await self._old(key)) is not None:
                return Written(old, created=False)
            self._not_rejected(key)
            raw = marks.mark(marks.MarkedText(body, self._prefix + key, card, await self._upload(images)))
            content: dict[str, Any] = {"raw": raw, "topic_id": topic_id}
            if reply_to is not None and (number := await self._source.number_of(reply_to)) is not None:
                content["reply_to_post_number"] = number
            try:
                sent = await self._create(key, content)
            except Refused as e:  # perhaps an answer was lost, and the post is too similar to itself
                await self._search(topic_id)
                if (old := await self._old(key)) is not None:
                    return Written(old, created=False)
                await self._explain(topic_id, e)
                raise
            if int(sent["post_number"]) > highest + 1:
                await self._search(topic_id)
                if (first := self._read.first(key)) not in (None, int(sent["id"])):
                    await self._client.ask("DELETE", f"/posts/{sent['id']}.json")
                    return Written(await self._source.post(str(first)), created=False)
            return Written(await self._noted(key, {**sent, "raw": raw}))

    async def _search(self, topic_id: int) -> int:
        """Record the keys of the account's own posts in a topic; return the highest post number."""
        me = await self._source.myself()
        topic = await self._source.topic_json(topic_id, username_filters=me.name)
        with translate_errors():
            newest = [int(n) for n in topic["post_stream"]["stream"][-SEARCHED_POSTS:]]
            unread = [number for number in newest if number not in self._read]
            for post_id, raw in (await self._source.raw_posts(topic_id, unread)).items():
                own = str(raw["user_id"]) == me.id
                self._read[post_id] = self.own_key(marks.unmark(text_of(raw["raw"])).key) if own else None
            return int(topic["highest_post_number"] or 0)

    async def _explain(self, topic_id: int, refused: Refused) -> None:
        """Raise `ForumLimited` if the topic is in slow mode, which Discourse's refusal does not say."""
        slow_s = int((await self._source.topic_json(topic_id)).get("slow_mode_seconds") or 0)
        if slow_s > 0:
            raise ForumLimited(f"{refused} (this topic is in slow mode)", float(slow_s)) from None

    # ---------------------------------------------------------------- edits
    async def edit(self, post_id: int, body: str, images: Sequence[bytes], card: StatusCard | None) -> Post:
        before = await self._source.one(post_id)
        if before is None:
            raise ForumNotFound(f"there is no post {post_id}")
        me = await self._source.myself()
        if str(before["user_id"]) != me.id:
            raise ForumDenied(f"post {post_id} belongs to {before['username']}")
        await self._source.build(before)  # to detect the change
        was = marks.unmark(before["raw"])
        pictures = (*was.pictures, *await self._upload(images, len(was.pictures) + 1))
        raw = marks.mark(marks.MarkedText(body, was.key, card or was.card, pictures))
        answer = await self._client.ask("PUT", f"/posts/{post_id}.json", json={"post": {"raw": raw}})
        with translate_errors():
            edited = {**before, **answer["post"]}
        return await self._source.build(edited)

    # ---------------------------------------------------------------- keys
    async def find(self, key: str) -> Post | None:
        """Return our post with that key, among the newest of this account."""
        return await self._old(key) or await self._topic_of(key) or await self._by_search(key)

    async def _by_search(self, key: str) -> Post | None:
        """Search the topics in which this account posted last."""
        if (old := await self._old(key)) is not None:
            return old
        me = await self._source.myself()
        found = await self._client.get("/user_actions.json", offset=0, username=me.name, filter="4,5")
        topics = list(dict.fromkeys(int(a["topic_id"]) for a in found["user_actions"]))[:SEARCHED_TOPICS]
        for topic_id in topics:
            try:
                await self._search(topic_id)
            except (ForumNotFound, ForumDenied):
                continue
            if (old := await self._old(key)) is not None:
                return old
        return None

    async def _old(self, key: str) -> Post | None:
        post_id = self._read.first(key)
        if post_id is None:
            return None
        if self._waiting is not None:  # a moderator approved it
            self._waiting.discard(key)
        return await self._source.post(str(post_id))

    async def _noted(self, key: str, sent: _JSON) -> Post:
        self._read[int(sent["id"])] = key
        return await self._source.build(sent)

    # ---------------------------------------------------------------- inside
    def _turn(self, key: str) -> asyncio.Lock:
        """Return the lock of a key; forget keys that were not used lately."""
        lock = self._turns.setdefault(key, asyncio.Lock())
        self._turns.move_to_end(key)
        for old in list(self._turns)[:-_KEPT_TURNS]:
            if not self._turns[old].locked():
                del self._turns[old]
        return lock

    async def _create(self, key: str, content: Mapping[str, Any]) -> _JSON:
        sent: _JSON = await self._client.ask("POST", "/posts.json", json=content)
        if sent.get("action") == "enqueued":
            self._waiting = (self._waiting or set()) | {key}
            raise ForumLimited("the post waits for a moderator's approval", APPROVAL_S)
        return sent

    async def _not_waiting(self, key: str) -> None:
        """Raise `ForumLimited` if a post with this key waits for a moderator, so that it is not written again."""
        if self._waiting is not None and key not in self._waiting:
            return
        pending = await self._pending()
        if key in pending:
            self._waiting = pending
            raise ForumLimited("the post waits for a moderator's approval", APPROVAL_S)
        self._waiting = self._waiting if self._waiting is not None else pending

    def _not_rejected(self, key: str) -> None:
        """Raise `ForumDenied` if a post with this key waited and was not approved."""
        if self._waiting and key in self._waiting:
            raise ForumDenied("a moderator did not approve the post")

    async def _pending(self) -> set[str]:
        """Return the keys of our posts that wait for approval."""
        me = await self._source.myself()
        try:
            found = await self._client.get(f"/posts/{me.name}/pending.json")
        except (ForumNotFound, ForumDenied):  # not available to every version and key
            return set()
        with translate_errors():
            keys = (self.own_key(marks.unmark(p["raw_text"]).key) for p in found["pending_posts"])
            return {key for key in keys if key is not None}

    async def _upload(self, images: Sequence[bytes], first: int = 1) -> tuple[str, ...]:
        """Upload pictures first; the text then shows them. Uploading twice after a lost answer is harmless."""
        lines = []
        for number, image in enumerate(images, first):
            file = {"file": image_file(number, image)}
            about = {"upload_type": "composer", "synchronous": "true"}
            sent = await self._client.ask("POST", "/uploads.json", data=about, files=file)
            if not str(sent.get("short_url", "")).startswith("upload://"):
                raise ForumError(f"the forum rejected picture {number}")
            lines.append(marks.picture(sent["short_url"], number))
        return tuple(lines)
