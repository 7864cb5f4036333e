"""Commands that wait for approval, and the buttons that approve or deny them.

A button posts the same reply that a person would write.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import select

from agentrob.board.auth import rights
from agentrob.board.content import notifications
from agentrob.board.content.store import Store
from agentrob.board.db import schema as db
from agentrob.board.db.records import StoredPost, Written
from agentrob.board.robots.actions import known_robot
from agentrob.board.services import Services
from agentrob.errors import BoardError
from agentrob.language.registry import language_of
from agentrob.language.visible_text import visible_text
from agentrob.model import Account, AccountKind, CommandState

_SOMEBODY = Account("", "")
_WORDS = {"en": ("approve", "deny"), "zh": ("批准", "拒绝")}


@dataclass(frozen=True, slots=True)
class PendingApproval:
    """A robot that waits for approval of the command in a post; `answer` is its reply. `may`: the viewer may
    approve."""

    robot: str
    post: StoredPost
    answer: StoredPost
    may: bool


def waiting(
    services: Services, post: StoredPost, robots: Iterable[Account], viewer: Account | None
) -> tuple[PendingApproval, ...]:
    """Which of these robots wait for approval of the command in this post."""
    store = services.store
    found = [(robot.name, _asks(store, robot, post)) for robot in robots if not post.removed]
    return tuple(
        PendingApproval(name, post, asks, _may(store, name, viewer, post))
        for name, asks in found
        if asks and not _decided(store, name, post, asks)
    )


def in_thread(services: Services, posts: Iterable[StoredPost], viewer: Account | None) -> dict[str, PendingApproval]:
    """The approvals that these posts of robots ask for and the viewer may give, by the ids of the posts."""
    asking = [p for p in posts if p.reply_to and not p.removed and (p.card or {}).get("state") == CommandState.WAITING]
    if viewer is None or not asking:
        return {}
    commands = {p.id: p for p in services.store.reader.posts_by_id([int(str(p.reply_to)) for p in asking])}
    found = {
        one.answer.id: one
        for status in asking
        if (post := commands.get(str(status.reply_to))) and status.author.kind is AccountKind.ROBOT_AGENT
        for one in waiting(services, post, [status.author], viewer)
    }
    return {post_id: one for post_id, one in found.items() if one.may}


def asked_of(services: Services, viewer: Account) -> tuple[PendingApproval, ...]:
    """The commands that wait for an approval of the viewer, the oldest first: those of which they were notified when
    the robot began to wait."""
    found = in_thread(services, notifications.asked(services.store.reader, viewer), viewer)
    return tuple(found.values())


def may_any(services: Services, account: Account) -> bool:
    """Whether an account may approve commands of any robot, if others ask for them."""
    reader = services.store.reader
    return any(rights.approves(rights.settings_of(reader, r.name), account, _SOMEBODY) for r in reader.robots())


def of_post(services: Services, post: StoredPost, viewer: Account | None) -> tuple[PendingApproval, ...]:
    """Which robots wait for approval of the command in this post."""
    presence = services.presence
    robots = [
        a
        for a in services.store.reader.robots()
        if a.name in post.mentions or post.id in _line(presence.robot(a.name).card)
    ]
    return waiting(services, post, robots, viewer)


async def say(services: Services, by: Account, post_id: str, robot: str, approve: bool, key: str | None) -> Written:
    """Approve or deny a command by a reply of the account. 403 if it may not, 409 if nothing waits."""
    post, account = services.store.reader.post(post_id), known_robot(services, robot)
    if not _may(services.store, account.name, by, post):
        raise BoardError(403, "not_approver", "this account may not approve this command", "ask the robot's owner")
    if post.removed or _asks(services.store, account, post) is None:
        raise BoardError(
            409, "nothing_waits", f"{account.name} does not wait for approval of this command", "see its thread"
        )
    words = _WORDS.get(language_of(visible_text(post.raw)), _WORDS["en"])
    text = f"@{account.name} {words[0 if approve else 1]}"
    return await services.store.reply(by, post.topic_id, text, key=key, reply_to=post.id)


def _asks(store: Store, robot: Account, post: StoredPost) -> StoredPost | None:
    """The robot's status post of this command, or of the latest run of this schedule, if it waits for approval."""
    status = store.reader.status_post(robot, post)
    return status if status is not None and (status.card or {}).get("state") == CommandState.WAITING else None


def _decided(store: Store, robot: str, post: StoredPost, asks: StoredPost) -> bool:
    """Whether an approver has decided already, and the agent has not received it yet."""
    p = db.posts.c
    said = [f"@{robot} {word}" for words in _WORDS.values() for word in words]
    later = select(p.id).where(p.topic_id == int(post.topic_id), p.id > int(asks.id), p.reply_to == int(post.id))
    rows = store.reader.rows(later.where(p.raw.in_(said), p.removed.is_(False)).limit(20))
    return any(_may(store, robot, one.author, post) for one in store.reader.posts_by_id([r.id for r in rows]))


def _may(store: Store, robot: str, account: Account | None, post: StoredPost) -> bool:
    return account is not None and rights.approves(rights.settings_of(store.reader, robot), account, post.author)


def _line(card: Mapping[str, Any]) -> Sequence[Any]:
    return line if isinstance(line := card.get("line"), (list, tuple)) else ()
