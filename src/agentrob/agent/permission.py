"""May this command move its robot now: asked again immediately before motion, on today's state (laws 4, 5 and 7)."""

from __future__ import annotations

import asyncio
import math
from dataclasses import dataclass

from agentrob.agent.sentences import say
from agentrob.errors import ForumDenied, ForumError, ForumNotFound, RobotError
from agentrob.forums.forum import Forum
from agentrob.judge.screen import screen
from agentrob.model import Account, AccountKind, Capabilities, Command, Decision, Plan, Post, Verdict
from agentrob.robots.client import DriverClient

#: Through so many commanding agents may a command come (law 1), and so many posts of a chain are read.
MAX_HOPS = 3
MAX_LINKS = 20


@dataclass(frozen=True, slots=True)
class Terms:
    """What the owner and the forum allow besides: flips, and the longest step in seconds (law 16)."""

    allow_flip: bool = False
    step_s: float = math.inf


def judge(command: Command, plan: Plan, author: Account, capabilities: Capabilities, terms: Terms) -> Verdict:
    """The screen, which asks for the author's rights first."""
    return screen(
        plan,
        text=command.text,
        author=author,
        capabilities=capabilities,
        language=command.language,
        allow_flip=terms.allow_flip,
        step_s=terms.step_s,
    )


async def permission(
    forum: Forum, driver: DriverClient, command: Command, terms: Terms, plan: Plan
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
    return judge(command, plan, author, capabilities, terms), capabilities


def _changed(post: Post, author: Account | None, command: Command) -> str | None:
    """A command is (post, text, author): the rule that names which of them is no longer so."""
    if post.removed:
        return "command.removed"
    if post.content_hash != command.content_hash:
        return "command.edited"
    if author is None or author.suspended or author.id != command.author.id:
        return "command.suspended"
    if post.author.id != command.author.id:  # a moderator gave the post to somebody else
        return "command.author"
    return None


async def chain_refusal(forum: Forum, command: Command) -> Verdict | None:
    """A refusal when an agent's command came through too many agents, as far as their replies to each other tell.

    Counted are the changes from one commanding agent to another, back to the last human; the robots' own reports
    between them do not count. Raises `ForumError`.
    """
    if command.author.kind is not AccountKind.COMMANDING_AGENT:
        return None
    agents: list[str] = []
    post_id: str | None = command.post_id
    for _ in range(MAX_LINKS):
        try:
            post = await forum.post(post_id) if post_id else None
        except (ForumNotFound, ForumDenied):
            post = None
        if post is None or post.author.kind is AccountKind.HUMAN:
            break
        if post.author.kind is AccountKind.COMMANDING_AGENT and agents[-1:] != [post.author.id]:
            agents.append(post.author.id)
        if len(agents) > MAX_HOPS:
            return Verdict(Decision.REFUSE, "rights.hops", say("rights.hops", command.language, count=MAX_HOPS))
        post_id = post.reply_to
    return None


def _denied(rule: str, command: Command) -> Verdict:
    said = say(f"because.{rule.removeprefix('command.')}", command.language)
    return Verdict(Decision.REFUSE, rule, said)
