"""Maps the forum's records to tool results and back; bodies lose the agent's tag, and long ones are cut."""

from __future__ import annotations

from dataclasses import asdict
from functools import lru_cache

from agentrob.forums.cards import card_by, card_of
from agentrob.forums.protocol import Board, Event, Topic
from agentrob.mcp.metadata import split_tag
from agentrob.mcp.results import AccountInfo, BoardInfo, EventInfo, PostInfo, TagInfo, TopicInfo
from agentrob.model import Account, EventKind, Post


@lru_cache(maxsize=512)
def account_info(a: Account) -> AccountInfo:
    """Cached: most posts of a page are by few accounts."""
    shown = a.display_name if a.display_name != a.name else ""
    return AccountInfo(
        id=a.id, name=a.name, kind=a.kind, role=a.role, suspended=a.suspended, display_name=shown,
        commands_simulated=a.commands_simulated,
    )  # fmt: skip


def topic_info(t: Topic) -> TopicInfo:
    return TopicInfo(
        id=t.id, board_id=t.board_id, title=t.title, author=account_info(t.author), created_at=t.created_at, url=t.url
    )


def board_info(b: Board) -> BoardInfo:
    return BoardInfo(id=b.id, name=b.name, description=b.description)


@lru_cache(maxsize=256)
def post_info(p: Post, max_chars: int | None = None) -> PostInfo:
    """A post with its body cut at `max_chars`; `left` is the number of characters cut. Cached, since a topic is read
    again and again and few of its posts change."""
    body, tag = split_tag(p.raw, p.author)
    cut = max_chars is not None and len(body) > max_chars
    return PostInfo(
        id=p.id,
        topic_id=p.topic_id,
        board_id=p.board_id,
        author=account_info(p.author),
        body=body[:max_chars] if cut else body,
        created_at=p.created_at,
        version=p.version,
        edited_at=p.edited_at,
        removed=p.removed,
        mentions=p.mentions,
        reply_to=p.reply_to,
        key=p.key,
        url=p.url,
        images=p.images,
        card={k: v for k, v in asdict(p.card).items() if v not in ("", 0, None)} if p.card else None,
        rendering_differs=p.rendering_differs,
        agent=TagInfo(type=tag.type, status=tag.status, trace_id=tag.trace_id) if tag else None,
        left=len(body) - max_chars if cut and max_chars is not None else 0,
    )


def event_info(e: Event) -> EventInfo:
    return EventInfo(
        id=e.id,
        kind=str(e.kind),
        at=e.at,
        post=post_info(e.post) if e.post else None,
        robot=e.robot,
        account=account_info(e.account) if e.account else None,
    )


# ---------------------------------------------------------------------- results to records, for the client's adapter
def account(a: AccountInfo) -> Account:
    return Account(a.id, a.name, a.kind, a.role, a.suspended, a.display_name or a.name, a.commands_simulated)


def topic(t: TopicInfo) -> Topic:
    return Topic(t.id, t.board_id, t.title, t.url, account(t.author), t.created_at)


def post(p: PostInfo) -> Post:
    author = account(p.author)
    return Post(
        id=p.id,
        topic_id=p.topic_id,
        board_id=p.board_id,
        author=author,
        raw=p.body,
        created_at=p.created_at,
        version=p.version,
        edited_at=p.edited_at,
        removed=p.removed,
        mentions=p.mentions,
        reply_to=p.reply_to,
        key=p.key,
        url=p.url,
        images=p.images,
        card=card_by(author, card_of(p.card)),
        rendering_differs=p.rendering_differs,
    )


def event(e: EventInfo) -> Event:
    return Event(
        e.id,
        EventKind(e.kind),
        e.at,
        post=post(e.post) if e.post else None,
        robot=e.robot,
        account=account(e.account) if e.account else None,
    )
