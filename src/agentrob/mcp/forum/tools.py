"""The forum's tools. Their arguments are in `arguments`, their results in `results`."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from agentrob.errors import ForumUnoffered
from agentrob.forums.cards import NUMBERS as CARD_NUMBERS
from agentrob.forums.cards import TEXTS as CARD_TEXTS
from agentrob.forums.cards import card_of
from agentrob.forums.protocol import Event, Notifications, Permissions, Registrar, Searcher, SemanticSearcher
from agentrob.mcp import results as r
from agentrob.mcp.envelope import ToolError
from agentrob.mcp.forum import arguments as a
from agentrob.mcp.forum.cursors import number_in, place_in, seal, unseal
from agentrob.mcp.forum.identity import Accounts, Identity
from agentrob.mcp.forum.manual import manual
from agentrob.mcp.forum.media import KEEP_S
from agentrob.mcp.mapping import account_info, board_info, post_info, topic_info
from agentrob.mcp.metadata import disarm_tags, with_tag
from agentrob.model import EventKind, Page, Post, StatusCard

#: Interval at which a waiting call checks that the forum answers.
WAIT_HEARTBEAT_S = 5.0


@dataclass(frozen=True, slots=True)
class CallContext:
    """Who calls a tool, and the trace id of the call. `accounts` is None where accounts cannot be switched (HTTP)."""

    who: Identity
    trace_id: str
    accounts: Accounts | None = None
    tools: tuple[Tool, ...] = ()
    subscribe: Callable[[str], Awaitable[None]] | None = None


@dataclass(frozen=True, slots=True)
class Tool:
    """One tool. `writes` tools must be allowed by the server's owner; the other flags are MCP annotations."""

    name: str
    toolset: str
    arguments: type[a.Arguments]
    run: Callable[[CallContext, Any], Awaitable[r._Result]]
    writes: bool = False
    stdio_only: bool = False
    destructive: bool = False
    idempotent: bool = False

    @property
    def description(self) -> str:
        return (self.arguments.__doc__ or "").replace("\n    ", " ").strip()


# ---------------------------------------------------------------------- reading
async def get_manual(call: CallContext, args: a.GetManual) -> r.Manual:
    return r.Manual(text=manual(args.tool, {t.name: t.description for t in call.tools}))


async def list_boards(call: CallContext, args: a.ListBoards) -> r.Boards:
    start = number_in(unseal("list_boards", "", args.cursor), "at")
    boards = await call.who.forum.boards()
    end = start + args.limit
    following = seal("list_boards", "", at=end) if end < len(boards) else None
    return r.Boards(boards=tuple(map(board_info, boards[start:end])), next=following)


async def list_posts(call: CallContext, args: a.ListPosts) -> r.Topics:
    cursor = place_in(unseal("list_posts", args.board_id, args.cursor))
    page = await call.who.forum.topics(args.board_id, cursor, args.limit)
    topics = tuple(map(topic_info, page.items))
    return r.Topics(topics=topics, next=_next("list_posts", args.board_id, page), untrusted=r.UNTRUSTED)


async def get_topic(call: CallContext, args: a.GetTopic) -> r.TopicPosts:
    forum, state = call.who.forum, unseal("get_topic", args.topic_id, args.cursor)
    topic = topic_info(await forum.topic(args.topic_id))
    if (post_id := place_in(state, "post")) is not None:
        rest = await _rest(call, args, post_id, number_in(state, "from"))
        return r.TopicPosts(topic=topic, posts=(rest,), untrusted=r.UNTRUSTED)
    page = await forum.posts(args.topic_id, place_in(state), args.limit)
    posts = _cut(page.items, args.max_chars)
    return r.TopicPosts(topic=topic, posts=posts, next=_next("get_topic", args.topic_id, page), untrusted=r.UNTRUSTED)


async def _rest(call: CallContext, args: a.GetTopic, post_id: str, start: int) -> r.PostInfo:
    """One post with its body from `start` on."""
    whole = post_info(await call.who.forum.post(post_id))
    if whole.topic_id != args.topic_id:
        raise ToolError("invalid_arguments", "this cursor belongs to another topic", "send `more` unchanged")
    end = start + args.max_chars
    left = max(0, len(whole.body) - end)
    more = seal("get_topic", args.topic_id, post=post_id, **{"from": end}) if left else None
    return whole.model_copy(update={"body": whole.body[start:end], "more": more, "left": left})


def _cut(posts: Sequence[Post], max_chars: int) -> tuple[r.PostInfo, ...]:
    def cut(post: Post) -> r.PostInfo:
        shown = post_info(post, max_chars)
        if not shown.left:
            return shown
        return shown.model_copy(update={"more": seal("get_topic", post.topic_id, post=post.id, **{"from": max_chars})})

    return tuple(map(cut, posts))


def _next(tool: str, place: str, page: Page[Any]) -> str | None:
    return seal(tool, place, at=page.next) if page.next is not None else None


async def search_posts(call: CallContext, args: a.SearchPosts) -> r.Found:
    forum, by_meaning = call.who.forum, isinstance(args, a.SearchPostsByMeaning) and args.mode == "meaning"
    if by_meaning and isinstance(forum, SemanticSearcher):
        find = forum.search_semantic
    elif isinstance(forum, Searcher) and not by_meaning:
        find = forum.search
    else:
        raise ForumUnoffered("this forum does not support this search")
    place = f"{args.board_id or ''}\n{'meaning' if by_meaning else ''}\n{args.query}"
    cursor = place_in(unseal("search_posts", place, args.cursor))
    page = await find(args.query, board_id=args.board_id, cursor=cursor, limit=args.limit)
    return r.Found(
        posts=_cut(page.items, args.max_chars), next=_next("search_posts", place, page), untrusted=r.UNTRUSTED
    )


async def list_notifications(call: CallContext, args: a.ListNotifications) -> r.Notifications:
    forum = call.who.forum
    if not isinstance(forum, Notifications):
        raise ForumUnoffered("this forum has no notifications; subscribe_topic returns new posts")
    page = await forum.notifications(place_in(unseal("list_notifications", "", args.cursor)), args.limit)
    found = (r.NoticeInfo(id=n.id, kind=n.kind, post=_cut([n.post], 400)[0], read=n.read) for n in page.items)
    return r.Notifications(
        notifications=tuple(found), next=_next("list_notifications", "", page), untrusted=r.UNTRUSTED
    )


async def subscribe_topic(call: CallContext, args: a.SubscribeTopic) -> r.TopicUpdates:
    """Subscribe first, then wait, so that no post in between is missed."""
    forum = call.who.forum
    topic = await forum.topic(args.topic_id)
    uri = f"forum://topic/{topic.id}"
    after = args.after if args.after is not None else (await forum.now())[0]
    if call.subscribe is not None:
        await call.subscribe(uri)
    posts: list[Post] = []
    if args.wait_s == 0:
        events = await forum.changes(after)
        after, posts = _new_posts(events, after, topic.id)
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(args.wait_s):
            while args.wait_s > 0 and not posts:
                events, _ = await call.who.event_tail.wait(after, WAIT_HEARTBEAT_S)
                after, posts = _new_posts(events, after, topic.id)
    return r.TopicUpdates(uri=uri, after=after, posts=_cut(posts, 1_500), untrusted=r.UNTRUSTED if posts else "")


def _new_posts(events: Sequence[Event], after: str, topic_id: str) -> tuple[str, list[Post]]:
    """The event to continue after, and the posts of a topic that were written or edited."""
    new = (EventKind.POST_CREATED, EventKind.POST_EDITED)
    posts = [e.post for e in events if e.post and e.kind in new and e.post.topic_id == topic_id]
    return events[-1].id if events else after, posts


# ---------------------------------------------------------------------- writing
async def create_topic(call: CallContext, args: a.CreateTopic) -> r.WrittenPost:
    who = call.who
    body = with_tag(args.body, await who.me(), args.status, call.trace_id)
    images = who.media.get(args.images)
    title = disarm_tags(args.title)
    written = await who.forum.create_topic(args.board_id, title, body, key=args.key or call.trace_id, images=images)
    return r.WrittenPost(post=_cut([written.post], 400)[0], created=written.created)


async def reply_to_topic(call: CallContext, args: a.ReplyToTopic) -> r.WrittenPost:
    who = call.who
    body = with_tag(args.body, await who.me(), args.status, call.trace_id)
    written = await who.forum.reply(
        args.topic_id,
        body,
        key=args.key or call.trace_id,
        reply_to=args.reply_to,
        images=who.media.get(args.images),
        card=_card(args.card) if args.card is not None else None,
    )
    return r.WrittenPost(post=_cut([written.post], 400)[0], created=written.created)


async def edit_post(call: CallContext, args: a.EditPost) -> r.WrittenPost:
    who = call.who
    body = with_tag(args.body, await who.me(), args.status, call.trace_id)
    images = who.media.get(args.images)
    state = _card(args.card) if args.card is not None else None
    key = f"{args.post_id} {args.key}" if args.key else None
    post, now = await who.once(key, lambda: who.forum.edit(args.post_id, body, images=images, card=state))
    return r.WrittenPost(post=_cut([post], 400)[0], created=now)


def _card(given: dict[str, Any]) -> StatusCard:
    """A status card; `ToolError` for unknown fields or wrong types."""
    words: dict[str, type] = dict.fromkeys(("robot", "state", *sorted(CARD_TEXTS)), str)
    words |= dict.fromkeys(sorted(CARD_NUMBERS), int)
    wrong = [k for k, v in given.items() if k not in words or not (isinstance(v, words[k]) and not isinstance(v, bool))]
    made = card_of(given)
    if wrong or made is None:
        missing = "robot or state is missing, or a word or number is too long"
        raise ToolError("invalid_arguments", f"card: {', '.join(wrong)[:100] or missing}",
                        f"robot and state, and perhaps {', '.join(list(words)[2:])}")  # fmt: skip
    return made


async def upload_media(call: CallContext, args: a.UploadMedia) -> r.Uploaded:
    media_id, kind, size = call.who.media.put(args.data)
    return r.Uploaded(media_id=media_id, media_type=kind, bytes=size, expires_s=KEEP_S)


# ---------------------------------------------------------------------- accounts
async def login_account(call: CallContext, args: a.LoginAccount) -> r.SignedIn:
    assert call.accounts is not None
    identity = await call.accounts.switch(args.account.lower(), args.token)
    return r.SignedIn(account=account_info(await identity.me()), accounts=call.accounts.names)


async def register_account(call: CallContext, args: a.RegisterAccount) -> r.SignedIn:
    assert call.accounts is not None
    forum = call.who.forum
    if not isinstance(forum, Registrar):
        raise ForumUnoffered("this forum does not let programs create accounts")
    made = await forum.register(args.account.lower(), kind=args.kind, display_name=disarm_tags(args.display_name))
    call.accounts.remember(made.account.name, made.secret)
    return r.SignedIn(account=account_info(made.account), accounts=call.accounts.names)


async def manage_permissions(call: CallContext, args: a.ManagePermissions) -> r.SignedIn:
    forum = call.who.forum
    if not isinstance(forum, Permissions):
        raise ForumUnoffered("this forum does not let programs change rights")
    if args.role is None and args.suspended is None:
        raise ToolError("invalid_arguments", "nothing to change", "give role, suspended or both")
    changed = await forum.set_rights(args.account.lower(), role=args.role, suspended=args.suspended)
    return r.SignedIn(account=account_info(changed))


TOOLS = (
    Tool("get_manual", "core", a.GetManual, get_manual),
    Tool("list_boards", "core", a.ListBoards, list_boards),
    Tool("list_posts", "core", a.ListPosts, list_posts),
    Tool("get_topic", "core", a.GetTopic, get_topic),
    Tool("create_topic", "core", a.CreateTopic, create_topic, writes=True),
    Tool("reply_to_topic", "core", a.ReplyToTopic, reply_to_topic, writes=True),
    Tool("login_account", "core", a.LoginAccount, login_account, stdio_only=True, idempotent=True),
    Tool("register_account", "core", a.RegisterAccount, register_account, writes=True, stdio_only=True),
    Tool("search_posts", "social", a.SearchPosts, search_posts),
    Tool("subscribe_topic", "social", a.SubscribeTopic, subscribe_topic),
    Tool("list_notifications", "social", a.ListNotifications, list_notifications),
    Tool("upload_media", "social", a.UploadMedia, upload_media, writes=True),
    Tool("edit_post", "social", a.EditPost, edit_post, writes=True, destructive=True, idempotent=True),
    Tool("manage_permissions", "admin", a.ManagePermissions, manage_permissions, writes=True, destructive=True,
         idempotent=True),
)  # fmt: skip
BY_NAME = {tool.name: tool for tool in TOOLS}


_BY_MEANING = replace(BY_NAME["search_posts"], arguments=a.SearchPostsByMeaning)


async def as_available(tool: Tool, who: Identity) -> Tool:
    """The tool with the arguments that this account's forum supports."""
    return _BY_MEANING if tool.name == _BY_MEANING.name and await who.has_semantic_search() else tool


def allowed(who: Identity, switching: bool) -> tuple[Tool, ...]:
    """The tools that this account may use here."""
    rights = who.rights
    return tuple(
        t
        for t in TOOLS
        if t.toolset in rights.toolsets and (rights.write or not t.writes) and (switching or not t.stdio_only)
    )
