"""The resources, `forum://…`: the content that tools return, plus events and pictures for programs.

forum://manual                       how the tools work together
forum://boards                       all boards
forum://board/{board_id}             the topics of a board, first page
forum://topic/{topic_id}             a topic with its latest posts; updates are pushed
forum://post/{post_id}               a post in full
forum://account/{name}               an account
forum://me                           the signed-in account, the newest event, the forum's features
forum://key/{key}                    the account's own post that was written under a key
forum://media/{url}                  a picture of a post
forum://changes/{after}/{limit}      the events after an event
forum://wait/{after}/{heartbeat_s}   the same as soon as there is an event, or the forum's time at a heartbeat
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from urllib.parse import quote, unquote

from agentrob.errors import ForumError, ForumNotFound
from agentrob.mcp import results as r
from agentrob.mcp.envelope import ToolError
from agentrob.mcp.forum.identity import Identity
from agentrob.mcp.forum.manual import manual
from agentrob.mcp.forum.media import MAX_BYTES, media_type
from agentrob.mcp.forum.tools import allowed
from agentrob.mcp.mapping import account_info, board_info, event_info, post_info, topic_info

SCHEME = "forum://"
#: JSON, text, or a picture with its media type.
Content = r._Result | str | tuple[bytes, str]


@dataclass(frozen=True, slots=True)
class Template:
    """A kind of resource. `parts` is the number of path segments after its word."""

    word: str
    uri: str
    description: str
    read: Callable[[Identity, list[str]], Awaitable[Content]]
    mime: str = "application/json"

    @property
    def parts(self) -> int:
        return self.uri.count("{")


async def _manual(who: Identity, _: list[str]) -> Content:
    return manual(None, {t.name: t.description for t in allowed(who, True)})


async def _boards(who: Identity, _: list[str]) -> Content:
    return r.Boards(boards=tuple(map(board_info, await who.forum.boards())))


async def _board(who: Identity, parts: list[str]) -> Content:
    page = await who.forum.topics(parts[0])
    return r.Topics(topics=tuple(map(topic_info, page.items)), untrusted=r.UNTRUSTED)


async def _topic(who: Identity, parts: list[str]) -> Content:
    topic = await who.forum.topic(parts[0])
    page = await who.forum.posts(topic.id)
    posts = tuple(post_info(p, 1_500) for p in page.items)
    return r.TopicPosts(topic=topic_info(topic), posts=posts, untrusted=r.UNTRUSTED)


async def _post(who: Identity, parts: list[str]) -> Content:
    return r.Found(posts=(post_info(await who.forum.post(parts[0])),), untrusted=r.UNTRUSTED)


async def _account(who: Identity, parts: list[str]) -> Content:
    found = await who.forum.account(parts[0])
    if found is None:
        raise ForumNotFound(f"there is no account {parts[0][:64]!r}")
    return r.SignedIn(account=account_info(found))


async def _me(who: Identity, _: list[str]) -> Content:
    forum = who.forum
    event, at = await forum.now()
    return r.ForumFacts(
        account=account_info(await forum.me()),
        event=event,
        at=at,
        live=forum.live,
        fastest_poll_s=forum.fastest_poll_s,
        max_edits=forum.max_edits,
        write=who.rights.write,
    )


async def _key(who: Identity, parts: list[str]) -> Content:
    found = await who.forum.find(parts[0])
    return r.Found(posts=(post_info(found),) if found else (), untrusted=r.UNTRUSTED)


async def _media(who: Identity, parts: list[str]) -> Content:
    picture = await who.forum.download(parts[0])
    kind = media_type(picture[:16])
    if kind is None or len(picture) > MAX_BYTES:
        raise ForumError("that file is not a picture that can be shown")
    return picture, kind


async def _changes(who: Identity, parts: list[str]) -> Content:
    limit = _number(parts[1], 1, 200)
    return r.Changes(events=tuple(map(event_info, await who.forum.changes(parts[0], int(limit)))))


async def _wait(who: Identity, parts: list[str]) -> Content:
    events, at = await who.event_tail.wait(parts[0], _number(parts[1], 0.25, 30))
    return r.Changes(events=tuple(map(event_info, events)), at=at)


def _number(text: str, least: float, most: float) -> float:
    try:
        number = float(text)
    except ValueError:
        number = -1.0
    if not least <= number <= most:
        raise ToolError("invalid_arguments", f"{text[:20]!r} is not possible", f"a number from {least:g} to {most:g}")
    return number


TEMPLATES = (
    Template("manual", "forum://manual", "How the tools work together", _manual, "text/plain"),
    Template("boards", "forum://boards", "All boards", _boards),
    Template("me", "forum://me", "The signed-in account and the newest event", _me),
    Template("board", "forum://board/{board_id}", "Topics of a board; updates are pushed", _board),
    Template("topic", "forum://topic/{topic_id}", "Posts of a topic; updates are pushed", _topic),
    Template("post", "forum://post/{post_id}", "A post in full", _post),
    Template("account", "forum://account/{name}", "An account as it is now", _account),
    Template("key", "forum://key/{key}", "One's own post written under a key", _key),
    Template("media", "forum://media/{url}", "A picture of a post", _media, "image/*"),
    Template("changes", "forum://changes/{after}/{limit}", "What happened after an event", _changes),
    Template("wait", "forum://wait/{after}/{heartbeat_s}", "The same, as soon as something happens", _wait),
)
_BY_WORD = {t.word: t for t in TEMPLATES}


def address(word: str, *parts: str) -> str:
    """The address of a resource; parts may hold any characters."""
    return "/".join([SCHEME + word, *(quote(p, safe="") for p in parts)])


async def read(who: Identity, uri: str) -> tuple[Content, str]:
    """Read an address; return content and media type. Raises `ForumNotFound` for an unknown kind of address."""
    word, *parts = uri.removeprefix(SCHEME).split("/") if uri.startswith(SCHEME) else [""]
    template = _BY_WORD.get(word)
    if template is None or len(parts) != template.parts or not all(parts):
        raise ForumNotFound(f"there is no resource {uri[:200]!r}")
    content = await template.read(who, [unquote(p) for p in parts])
    return content, content[1] if isinstance(content, tuple) else template.mime
