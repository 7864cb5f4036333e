"""May this command move its robot now: asked again immediately before motion, on today's state (laws 4, 5 and 7)."""

from __future__ import annotations

import asyncio

from agentrob.agent.sentences import say
from agentrob.errors import ForumError, ForumNotFound, RobotError
from agentrob.forums.forum import Forum
from agentrob.judge.screen import screen
from agentrob.model import Account, Capabilities, Command, Decision, Plan, Post, Verdict
from agentrob.robots.client import DriverClient


def judge(command: Command, plan: Plan, author: Account, capabilities: Capabilities, allow_flip: bool) -> Verdict:
    """The screen, which asks for the author's rights first."""
    return screen(
        plan,
        text=command.text,
        author=author,
        capabilities=capabilities,
        language=command.language,
        allow_flip=allow_flip,
    )


async def permission(
    forum: Forum, driver: DriverClient, command: Command, plan: Plan, allow_flip: bool
) -> tuple[Verdict, Capabilities | None]:
    """Read the post, its author and the robot's limits anew and judge again; also the limits that were judged by.

    What cannot be read is not granted. Rules that begin with `command.` say that the command is no longer what it was.
    """
    try:
        post, author, capabilities = await asyncio.gather(
            forum.post(command.post_id), forum.account(command.author.name), driver.capabilities()
        )
    except ForumNotFound:
        return _denied("command.removed", command), None
    except (ForumError, RobotError):
        return _denied("command.unverified", command), None
    if (changed := _changed(post, author, command)) is not None:
        return _denied(changed, command), None
    assert author is not None
    return judge(command, plan, author, capabilities, allow_flip), capabilities


def _changed(post: Post, author: Account | None, command: Command) -> str | None:
    """A command is (post, text, author): the rule that names which of them is no longer so."""
    if post.removed:
        return "command.removed"
    if post.content_hash != command.content_hash:
        return "command.edited"
    if author is None or author.suspended or author.id != command.author.id:
        return "command.suspended"
    return None


def _denied(rule: str, command: Command) -> Verdict:
    said = say(f"because.{rule.removeprefix('command.')}", command.language)
    return Verdict(Decision.REFUSE, rule, said)
