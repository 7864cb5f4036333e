"""Check whether a command may move its robot, and whether its approval still holds; checked again immediately before
motion, on today's state (laws 4, 5 and 7)."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Collection
from dataclasses import dataclass, replace

from agentrob.agent.store.rows import ApprovalDecision
from agentrob.config.robots import RobotConfig
from agentrob.errors import ForumDenied, ForumError, ForumNotFound, RobotError
from agentrob.forums.protocol import Forum, RobotRightsSource
from agentrob.language.joint.parts import JointCommand
from agentrob.language.joint.reading import joint_command
from agentrob.language.messages.catalog import say
from agentrob.language.visible_text import mentions
from agentrob.model import (
    Account,
    AccountKind,
    ActionClass,
    Capabilities,
    Command,
    Decision,
    Plan,
    Post,
    RobotRights,
    Role,
    Verdict,
)
from agentrob.robots.driver.client import DriverClient
from agentrob.screening.audience import text_for_robot
from agentrob.screening.rights import may_approve
from agentrob.screening.screen import screen

#: The most commanding agents that a command may pass through (law 1), and the most posts of a chain that are read.
MAX_HOPS = 3
MAX_LINKS = 20


@dataclass(frozen=True, slots=True)
class CommandTerms:
    """The terms by which a command is judged, besides its text and author.

    `step_s` is the longest step in seconds (law 16). `robot` is the robot's account, under which a forum may keep its
    rights. `scene` describes in English what is known to be around the robot. `names` are the mentions that address it.
    `known`: every word of the command is understood, as a goal of a closed vocabulary. `boards` are where the robot may
    be commanded; empty means anywhere. `rights` are the owner's own, for a forum that keeps none; a class of action
    that needs an approval by them needs it on every forum. `approval` is the decision of somebody who approved it.
    """

    consents: Collection[str] = ()
    step_s: float = math.inf
    robot: str = ""
    scene: str = ""
    names: tuple[str, ...] = ()
    boards: tuple[str, ...] = ()
    known: bool = False
    rights: RobotRights | None = None
    approval: ApprovalDecision | None = None


def own_rights(settings: RobotConfig) -> RobotRights:
    """The rights that the owner configured: who approves what. Roles decide who may command."""
    asks = settings.approval
    return RobotRights(
        owner=settings.owner,
        command=dict.fromkeys(ActionClass, str(Role.OPERATOR)),
        approve=asks.who,
        approval=tuple(map(str, asks.classes)),
        approve_own=asks.own,
    )


async def rights_on(
    forum: Forum, command: Command, terms: CommandTerms, reading: Awaitable[Post] | None = None
) -> RobotRights | None:
    """The robot's rights on the board where the command stands now, or the owner's if the forum keeps none. `reading`
    gives the command's post as it is now, if it is being read already.

    A forum that keeps rights and does not know this robot grants nothing. Raises `ForumError`.
    """
    if not isinstance(forum, RobotRightsSource) or not terms.robot:
        return terms.rights
    try:
        # A moderator may have moved its topic to another board.
        post = await (forum.post(command.post_id) if reading is None else reading)
        kept = await forum.robot_rights(terms.robot, post.board_id)
        return replace(kept, approval=(*kept.approval, *terms.rights.approval)) if terms.rights else kept
    except (ForumNotFound, ForumDenied):
        return RobotRights()


def judge(
    command: Command,
    plan: Plan,
    author: Account,
    capabilities: Capabilities,
    terms: CommandTerms,
    rights: RobotRights | None = None,
) -> Verdict:
    """Screen a plan; the author's rights are checked first."""
    joint = joint_command(command.text) if command.part else None
    if isinstance(joint, JointCommand):  # what is left of its text says who begins when, and is understood
        part = ". ".join(part.text for part in joint.parts)
    else:
        others = [name for name in mentions(command.text) if name not in terms.names]
        part = text_for_robot(command.text, terms.names, others, known=terms.known)
    return screen(
        plan,
        text=command.text,
        author=author,
        capabilities=capabilities,
        language=command.language,
        consents=terms.consents,
        step_s=terms.step_s,
        scene=terms.scene,
        part=part,
        rights=rights,
    )


async def permission(
    forum: Forum, driver: DriverClient, command: Command, terms: CommandTerms, plan: Plan
) -> tuple[Verdict, Capabilities | None]:
    """Read the post, its author, the rights and the robot's limits again and judge the plan by them. Also return the
    limits.

    What cannot be read is not granted. A rule that begins with `command.` means that the command has changed.
    """
    reading = asyncio.ensure_future(forum.post(command.post_id))
    try:
        post, author, rights, capabilities = await asyncio.gather(
            reading,
            forum.account(command.author.name),
            rights_on(forum, command, terms, reading),
            driver.capabilities(),
        )
    except ForumNotFound:
        return _denied("command.removed", command), None
    except (ForumError, RobotError):
        return _denied("command.unverified", command), None
    if (changed := _changed(post, author, command)) is not None:
        return _denied(changed, command), None
    assert author is not None
    verdict = judge(command, plan, author, capabilities, terms, rights)
    if verdict.decision not in (Decision.ALLOW, Decision.NEEDS_APPROVAL):
        return verdict, capabilities
    if terms.boards and post.board_id not in terms.boards:  # a moderator moved its topic
        return _denied("command.moved", command), None
    if terms.approval is None:
        return verdict, capabilities
    return await _approved(forum, command, author, terms.approval, rights), capabilities


async def _approved(
    forum: Forum, command: Command, author: Account, approval: ApprovalDecision, rights: RobotRights | None
) -> Verdict:
    """Whether the approval is unchanged, and its author may still give it."""
    try:
        post, by = await asyncio.gather(forum.post(approval.post_id), forum.account(approval.by.name))
    except ForumNotFound:
        return _denied("command.approval", command)
    except ForumError:
        return _denied("command.unverified", command)
    same = post.content_hash == approval.content_hash and post.author.id == approval.by.id and not post.removed
    if not same or by is None or by.id != approval.by.id:
        return _denied("command.approval", command)
    if may_approve(by, author, command.language, rights).decision is not Decision.ALLOW:
        return Verdict(Decision.REFUSE, "approval.lost", say("agent.approval.lost", command.language))
    return Verdict(Decision.ALLOW, "approval.given")


def _changed(post: Post, author: Account | None, command: Command) -> str | None:
    """A command is (post, text, author): return the rule for the one that has changed, if any."""
    if post.removed:
        return "command.removed"
    if post.topic_id != command.topic_id:  # a stop there would not be taken for one of this command (law 13)
        return "command.thread"
    if post.content_hash != command.content_hash:
        return "command.edited"
    if author is None or author.suspended or author.id != command.author.id:
        return "command.suspended"
    if post.author.id != command.author.id:  # a moderator gave the post to somebody else
        return "command.author"
    return None


async def chain_refusal(forum: Forum, command: Command) -> Verdict | None:
    """Refuse an agent's command that passed through too many agents, as far as their replies show.

    Counts the changes from one commanding agent to another, back to the last human. Reports of robots in between do not
    count. Raises `ForumError`.
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
            return Verdict(Decision.REFUSE, "rights.hops", say("agent.rights.hops", command.language, count=MAX_HOPS))
        post_id = post.reply_to
    return None


def _denied(rule: str, command: Command) -> Verdict:
    reason = say(f"agent.because.{rule.removeprefix('command.')}", command.language)
    return Verdict(Decision.REFUSE, rule, reason)
