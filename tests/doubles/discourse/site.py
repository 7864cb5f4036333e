"""The state of the double: accounts, topics, posts and pictures, and Discourse's rules and limits for posting."""

from __future__ import annotations

import hashlib
import re
import secrets
import time
from collections import defaultdict, deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any

from tests.doubles.discourse.bus import MessageBus
from tests.doubles.discourse.cooking import cook

STUB = "(post deleted by author)"

#: Discourse's defaults: first site settings, then settings of its start-up configuration.
DEFAULTS: Mapping[str, float] = {
    "min_post_length": 20,
    "min_first_post_length": 20,
    "min_topic_title_length": 15,
    "title_min_entropy": 10,
    "unique_posts_mins": 5,
    "allow_duplicate_topic_titles": 0,
    "rate_limit_create_post": 5,
    "rate_limit_create_topic": 15,
    "max_edits_per_day": 30,
    "editing_grace_period": 300,
    "approve_post_count": 0,
    "posts_per_page": 20,
    "max_admin_api_reqs_per_minute": 60,
    "max_user_api_reqs_per_minute": 20,
    "max_reqs_per_ip_per_minute": 0,
    "max_reqs_per_ip_per_10_seconds": 0,
    "long_polling_interval_s": 25,
}
#: The limits that `docs/forum/discourse.md` asks an admin to lift.
LIFTED: Mapping[str, float] = {
    "min_post_length": 5,
    "min_first_post_length": 5,
    "min_topic_title_length": 5,
    "title_min_entropy": 5,
    "allow_duplicate_topic_titles": 1,
    "rate_limit_create_post": 0,
    "rate_limit_create_topic": 0,
    "max_edits_per_day": 100_000,
    "max_admin_api_reqs_per_minute": 100_000,
    "max_user_api_reqs_per_minute": 100_000,
}


class Refusal(Exception):
    """An error response; `wait_s` is set for 429 only, which may be plain text."""

    def __init__(self, status: int, said: str, kind: str = "", wait_s: int | None = None, plain: bool = False) -> None:
        super().__init__(said)
        self.status, self.said, self.kind, self.wait_s, self.plain = status, said, kind, wait_s, plain


def denied() -> Refusal:
    return Refusal(403, "You are not permitted to view the requested resource.", "invalid_access")


def missing() -> Refusal:
    return Refusal(404, "The requested URL or resource could not be found.", "not_found")


@dataclass
class User:
    id: int
    username: str
    name: str = ""
    email: str = ""
    password: str = ""
    admin: bool = False
    moderator: bool = False
    trust_level: int = 1
    active: bool = True
    suspended_till: str | None = None
    groups: set[int] = field(default_factory=set)

    @property
    def staff(self) -> bool:
        return self.admin or self.moderator


@dataclass
class Group:
    id: int
    name: str
    #: True if anybody may join.
    public_admission: bool = False


@dataclass
class Category:
    id: int
    name: str
    slug: str
    parent: int | None = None
    only_group: int | None = None


@dataclass
class Topic:
    id: int
    title: str
    category: int
    user: int
    created_at: datetime
    external_id: str | None = None
    closed: bool = False
    slow_mode_seconds: int = 0
    deleted: bool = False
    posts: list[int] = field(default_factory=list)


@dataclass
class Post:
    id: int
    topic: int
    number: int
    user: int
    raw: str
    cooked: str
    created_at: datetime
    updated_at: datetime
    reply_to: int | None = None
    version: int = 1
    version_at: float = 0.0
    deleted_at: datetime | None = None
    user_deleted: bool = False
    hidden: bool = False


class Site:
    """The whole state. `settings` override `DEFAULTS`; times come from the system clock."""

    def __init__(self, settings: Mapping[str, float] | None = None) -> None:
        self.settings = {**DEFAULTS, **(settings or {})}
        self.bus = MessageBus()
        self.users: dict[int, User] = {}
        self.groups: dict[int, Group] = {}
        self.categories: dict[int, Category] = {}
        self.topics: dict[int, Topic] = {}
        self.posts: dict[int, Post] = {}
        self.uploads: dict[str, tuple[str, bytes]] = {}
        #: Files that are stored elsewhere, for example on S3.
        self.moved: dict[str, str] = {}
        self.waiting: dict[int, tuple[int, dict[str, Any]]] = {}
        self.notifications: list[dict[str, Any]] = []
        #: API keys, each for one account or (None) for all; then users' own keys.
        self.api_keys: dict[str, int | None] = {}
        self.user_keys: dict[str, int] = {}
        self._times: dict[tuple[str, Any], deque[float]] = defaultdict(deque)
        self._texts: dict[tuple[int, str], float] = {}
        self._answers: dict[str, tuple[float, dict[str, Any]]] = {}
        self._post_ids = 0
        self.add_user("system", admin=True)
        self.add_category("General", "general")

    # ---------------------------------------------------------------- accounts and categories
    def add_user(self, username: str, **more: Any) -> User:
        if self.named(username) is not None:
            raise Refusal(422, "Username must be unique")
        user = User(len(self.users) + 1, username, **more)
        self.users[user.id] = user
        return user

    def named(self, username: str) -> User | None:
        return next((u for u in self.users.values() if u.username.lower() == username.lower()), None)

    def add_group(self, name: str) -> Group:
        group = Group(40 + len(self.groups) + 1, name)
        self.groups[group.id] = group
        return group

    def add_category(self, name: str, slug: str, parent: int | None = None, only: int | None = None) -> Category:
        category = Category(len(self.categories) + 1, name, slug, parent, only)
        self.categories[category.id] = category
        return category

    def add_key(self, user: User | None = None) -> str:
        """Create an API key of one account, or one for all accounts."""
        key = secrets.token_hex(32)
        self.api_keys[key] = user.id if user else None
        return key

    def sees(self, viewer: User | None, topic: Topic) -> bool:
        only = self.categories[topic.category].only_group
        staff = viewer is not None and viewer.staff
        return (staff or not topic.deleted) and (
            only is None or staff or (viewer is not None and only in viewer.groups)
        )

    def visible(self, viewer: User | None, post: Post) -> bool:
        if not self.sees(viewer, self.topics[post.topic]):
            return False
        return post.deleted_at is None or (viewer is not None and viewer.staff)

    # ---------------------------------------------------------------- limits
    def limit(self, what: str, who: Any, count: float, seconds: float, plain: bool = False) -> None:
        """Count one use; raise 429 beyond `count` uses in this many seconds. A count of 0 means no limit."""
        if count <= 0:
            return
        times, now_s = self._times[what, who], time.monotonic()
        while times and times[0] <= now_s - seconds:
            times.popleft()
        if len(times) >= count:
            wait_s = max(1, round(times[0] + seconds - now_s))
            said = f"You’ve performed this action too many times. Please wait {wait_s} seconds before trying again."
            raise Refusal(429, said, "rate_limit", wait_s, plain)
        times.append(now_s)

    def _may_write(self, user: User, what: str, seconds: float) -> None:
        if not user.staff:
            self.limit(what, user.id, 1 if seconds else 0, seconds)

    # ---------------------------------------------------------------- writing
    def create(self, user: User, wanted: dict[str, Any], by_api: bool) -> dict[str, Any]:
        """Handle `POST /posts.json`: return `{post}` or `{action: enqueued}`. With an API key, the same content gets
        the same response again for 120 s, even an error."""
        signature = hashlib.sha1(repr((user.id, sorted(wanted.items()))).encode()).hexdigest()
        at_s, old = self._answers.get(signature, (-1e9, {}))
        if by_api and time.monotonic() - at_s < 120:
            if "refused" in old:
                raise Refusal(422, old["refused"])
            return old
        try:
            answer = self._create(user, wanted, by_api)
        except Refusal as e:
            if e.status == 422:
                self._answers[signature] = (time.monotonic(), {"refused": e.said})
            raise
        self._answers[signature] = (time.monotonic(), answer)
        return answer

    def _create(self, user: User, wanted: dict[str, Any], by_api: bool) -> dict[str, Any]:
        raw = str(wanted.get("raw", "")).strip()
        topic = self.topics.get(int(wanted["topic_id"])) if wanted.get("topic_id") else None
        if wanted.get("topic_id") and (topic is None or not self.sees(user, topic)):
            raise Refusal(422, "The requested URL or resource could not be found.")
        if topic is not None and topic.closed and not user.staff:
            raise denied()
        self._check(user, raw, topic, wanted, by_api)
        mine = sum(1 for p in self.posts.values() if p.user == user.id)
        if mine < self.settings["approve_post_count"] and not user.staff:
            number = len(self.waiting) + 1
            self.waiting[number] = (user.id, dict(wanted))
            return {"success": True, "action": "enqueued", "pending_post": {"id": number, "raw_text": raw}}
        self._texts[user.id, hashlib.sha1(raw.encode()).hexdigest()] = time.monotonic()
        return {"post": self.write(user, wanted)}

    def _check(self, user: User, raw: str, topic: Topic | None, wanted: Mapping[str, Any], by_api: bool) -> None:
        counted = re.sub(r"\.{2,}", "…", re.sub(r":\w+(:\w+)?:", "X", re.sub(r"<!--(.*?)-->", "", raw))).strip()
        if len(counted) < (least := int(self.settings["min_post_length" if topic else "min_first_post_length"])):
            raise Refusal(422, f"Body is too short (minimum is {least} characters)")
        if topic is None:
            title = str(wanted.get("title", ""))
            if len(title) < (least := int(self.settings["min_topic_title_length"])):
                raise Refusal(422, f"Title is too short (minimum is {least} characters)")
            if len(set(title.lower())) < self.settings["title_min_entropy"]:
                raise Refusal(422, "Title seems unclear, is it a complete sentence?")
            same = any(t.title.lower() == title.lower() and not t.deleted for t in self.topics.values())
            if same and not self.settings["allow_duplicate_topic_titles"]:
                raise Refusal(422, "Title has already been used")
            external = wanted.get("external_id") if by_api else None
            if external and any(t.external_id == external for t in self.topics.values()):
                raise Refusal(422, "External has already been taken")
        at_s = self._texts.get((user.id, hashlib.sha1(raw.encode()).hexdigest()), -1e9)
        if not user.staff and time.monotonic() - at_s < 60 * self.settings["unique_posts_mins"]:
            raise Refusal(422, "Body is too similar to what you recently posted")
        if topic is not None and topic.slow_mode_seconds and not user.staff:
            mine = [self.posts[n].created_at for n in topic.posts if self.posts[n].user == user.id]
            if mine and (datetime.now(UTC) - mine[-1]).total_seconds() < topic.slow_mode_seconds:
                raise Refusal(422, "This topic is in slow mode. Please wait before posting again.")
        what = "post" if topic is not None else "topic"
        self._may_write(user, f"create_{what}", self.settings[f"rate_limit_create_{what}"])

    def write(self, user: User, wanted: Mapping[str, Any], post_id: int | None = None) -> Post:
        """Store a post without checks. `post_id` may be an id reserved earlier, so that the post appears late."""
        now = datetime.now(UTC)
        now = now.replace(microsecond=now.microsecond // 1000 * 1000)
        topic = self.topics.get(int(wanted["topic_id"])) if wanted.get("topic_id") else None
        if topic is None:
            topic = Topic(len(self.topics) + 1, wanted["title"], int(wanted.get("category") or 1), user.id, now)
            topic.external_id = wanted.get("external_id")
            self.topics[topic.id] = topic
        raw = str(wanted["raw"]).strip()
        reply_to = int(wanted["reply_to_post_number"]) if wanted.get("reply_to_post_number") else None
        post = Post(
            post_id or self.reserve(), topic.id, len(topic.posts) + 1, user.id, raw, self.cook(raw), now, now, reply_to,
            version_at=time.monotonic(),
        )  # fmt: skip
        self.posts[post.id] = post
        topic.posts.append(post.id)
        self._notify(post, topic)
        self.say(post, "created")
        self.bus.publish("/latest", {"topic_id": topic.id, "message_type": "latest", "payload": {}}, self._group(topic))
        return post

    def reserve(self) -> int:
        """Reserve the next post id; posts need not appear in the order of their ids."""
        self._post_ids += 1
        return self._post_ids

    def approve(self, number: int) -> Post:
        """Publish a queued post, as when a moderator approves it."""
        user_id, wanted = self.waiting.pop(number)
        return self.write(self.users[user_id], wanted)

    def revise(self, user: User, post: Post, raw: str) -> None:
        """Edit a post. Within the grace period an edit by the same user adds no version."""
        if not (user.staff or user.id == post.user):
            raise denied()
        if not user.staff:
            self.limit("edit", user.id, self.settings["max_edits_per_day"], 86_400)
        if len(raw.strip()) < self.settings["min_post_length"]:
            raise Refusal(422, f"Body is too short (minimum is {self.settings['min_post_length']:.0f} characters)")
        if time.monotonic() - post.version_at > self.settings["editing_grace_period"] or user.id != post.user:
            post.version += 1
            post.version_at = time.monotonic()
        post.raw, post.cooked, post.updated_at = raw.strip(), self.cook(raw), datetime.now(UTC)
        self.say(post, "revised")

    def delete(self, user: User, post: Post) -> None:
        """Delete a post. Staff hide it from others (the first post with its topic); its author leaves a stub."""
        if user.staff:
            post.deleted_at = datetime.now(UTC)
            self.topics[post.topic].deleted |= post.number == 1
        elif user.id == post.user and post.number > 1:
            post.raw, post.cooked, post.user_deleted, post.version = STUB, f"<p>{STUB}</p>", True, post.version + 1
            post.updated_at = datetime.now(UTC)
        else:
            raise denied()
        self.say(post, "deleted")

    def say(self, post: Post, kind: str) -> None:
        message = {
            "id": post.id,
            "post_number": post.number,
            "user_id": post.user,
            "type": kind,
            "version": post.version,
        }
        self.bus.publish(f"/topic/{post.topic}", message, self._group(self.topics[post.topic]))

    def _group(self, topic: Topic) -> int | None:
        return self.categories[topic.category].only_group

    # ---------------------------------------------------------------- text and pictures
    def cook(self, raw: str) -> str:
        return cook(raw, lambda name: self.named(name) is not None, self.upload_path)

    def upload_path(self, link: str) -> str:
        name = link.removeprefix("upload://")
        return f"/uploads/default/original/1X/{name}" if name in self.uploads else link

    def add_upload(self, content: bytes, kind: str) -> str:
        name = f"{hashlib.sha1(content).hexdigest()[:27]}.{kind}"
        self.uploads[name] = (f"image/{kind}", content)
        return name

    def _notify(self, post: Post, topic: Topic) -> None:
        """Notify mentioned users (type 1) and the author of the post replied to (type 2), each once."""
        found = dict.fromkeys(re.findall(r'class="mention" href="/u/([^"]+)"', post.cooked), 1)
        if post.reply_to is not None:
            answered = self.posts[topic.posts[post.reply_to - 1]]
            found.setdefault(self.users[answered.user].username, 2)
        for name, kind in found.items():
            user = self.named(name)
            if user is not None and user.id != post.user:
                note = {"id": len(self.notifications) + 1, "user_id": user.id, "notification_type": kind, "read": False}
                about = {"topic_id": topic.id, "post_number": post.number, "slug": "topic", "data": {}}
                self.notifications.append(note | about | {"created_at": post.created_at.isoformat()})
                self.bus.publish(f"/notification/{user.id}", {"unread_notifications": 1}, users=(user.id,))
