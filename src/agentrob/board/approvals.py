"""Commands that wait for an approval, and the button that gives or denies one: it writes the same post as a person."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from agentrob.board import rights
from agentrob.board.buttons import known_robot
from agentrob.board.records import Post, Written
from agentrob.board.services import Services
from agentrob.board.store import Store
from agentrob.errors import BoardError
from agentrob.language.languages import language_of
from agentrob.language.visible import visible_text
from agentrob.model import Account

#: The state of a status card whose command waits.
WAITING = "waiting"
_WORDS = {"en": ("approve", "deny"), "zh": ("批准", "拒绝")}


@dataclass(frozen=True, slots=True)
class Waiting:
    """One robot that waits with the command of a post, as its `answer` says. `may`: whoever looks may approve it."""

    robot: str
    post: Post
    answer: Post
    may: bool


def waiting(services: Services, post: Post, robots: Iterable[Account], viewer: Account | None) -> tuple[Waiting, ...]:
    """Which of these robots wait with this post's command."""
    store = services.store
    found = [(robot.name, _asks(store, robot, post)) for robot in robots if not post.removed]
    return tuple(Waiting(name, post, asks, _may(store, name, viewer, post)) for name, asks in found if asks)


def of_post(services: Services, post: Post, viewer: Account | None) -> tuple[Waiting, ...]:
    """Which robots wait with this post's command; they are among those whose line it is in."""
    stage = services.stage
    robots = [
        a for a in services.store.robots() if a.name in post.mentions or post.id in _line(stage.robot(a.name).card)
    ]
    return waiting(services, post, robots, viewer)


async def say(services: Services, by: Account, post_id: str, robot: str, approve: bool, key: str | None) -> Written:
    """Approve or deny: a reply to the command by who pressed. 403 for those who may not, 409 when nothing waits."""
    post, account = services.store.post(post_id), known_robot(services, robot)
    if not _may(services.store, account.name, by, post):
        raise BoardError(403, "not_approver", "this account may not approve this command", "ask the robot's owner")
    if post.removed or _asks(services.store, account, post) is None:
        raise BoardError(409, "nothing_waits", f"{account.name} does not wait with this command", "look at its thread")
    words = _WORDS.get(language_of(visible_text(post.raw)), _WORDS["en"])
    text = f"@{account.name} {words[0 if approve else 1]}"
    return await services.store.reply(by, post.topic_id, text, key=key, reply_to=post.id)


def _asks(store: Store, robot: Account, post: Post) -> Post | None:
    """The robot's status post of this command, written under the key of its claim, when it says that it waits."""
    status = store.find(robot, f"claim:{post.id}")
    waits = status is not None and not status.removed and (status.card or {}).get("state") == WAITING
    return status if waits else None


def _may(store: Store, robot: str, account: Account | None, post: Post) -> bool:
    return account is not None and rights.approves(rights.settings_of(store.reader, robot), account, post.author)


def _line(card: Mapping[str, Any]) -> Sequence[Any]:
    return line if isinstance(line := card.get("line"), (list, tuple)) else ()
