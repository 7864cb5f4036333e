"""May this command move its robot now, and does its approval still hold: asked again immediately before motion, on
today's state (laws 4, 5 and 7)."""

from __future__ import annotations

import asyncio
import math
from dataclasses import dataclass, replace

from agentrob.agent.store.rows import ApprovalDecision
from agentrob.config.robots import RobotConfig
from agentrob.errors import ForumDenied, ForumError, ForumNotFound, RobotError
from agentrob.forums.protocol import Forum, RobotRightsSource
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

#: Through so many commanding agents may a command come (law 1), and so many posts of a chain are read.
MAX_HOPS = 3
MAX_LINKS = 20


@dataclass(frozen=True, slots=True)
class CommandTerms:
    """What the owner and the forum allow besides: flips, and the longest step in seconds (law 16).

    `robot` is the robot's account, by which a forum may keep who may command it. `scene` is what is known to be around
    the robot, in English; `names` are the mentions that call it. `known`: what it is asked is understood to the last
    word, as a goal of a closed vocabulary. `boards` are where the robot may be commanded; empty: anywhere. `rights` are
    the owner's own, where the forum keeps none; the classes of action that need an approval by them need it everywhere.
    `approval`: somebody approved this command.
    """

    allow_flip: bool = False
    step_s: float = math.inf
    robot: str = ""
    scene: str = ""
    names: tuple[str, ...] = ()
    boards: tuple[str, ...] = ()
    known: bool = False
    rights: RobotRights | None = None
    approval: ApprovalDecision | None = None


def own_rights(settings: RobotConfig) -> RobotRights:
    """What the owner configured of who may do what: who commands is for the roles to say, so only the approvals."""
    asks = settings.approval
    return RobotRights(
        owner=settings.owner,
        command=dict.fromkeys(ActionClass, str(Role.OPERATOR)),
        approve=asks.who,
        approval=tuple(map(str, asks.classes)),
        approve_own=asks.own,
    )


async def rights_on(forum: Forum, command: Command, terms: CommandTerms) -> RobotRights | None:
    """What the forum keeps of who may command the robot where this stands now; the owner's where forums keep no such
    thing.

    A forum that should know and does not grants nothing. Raises `ForumError`; then nothing is granted either.
    """
    if not isinstance(forum, RobotRightsSource) or not terms.robot:
        return terms.rights
    try:
        post = await forum.post(command.post_id)  # a moderator may have moved its topic to another board
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
    """The screen, which asks for the author's rights first."""
    others = [name for name in mentions(command.text) if name not in terms.names]
    return screen(
        plan,
        text=command.text,
        author=author,
        capabilities=capabilities,
        language=command.language,
        allow_flip=terms.allow_flip,
        step_s=terms.step_s,
        scene=terms.scene,
        part=text_for_robot(command.text, terms.names, others, known=terms.known),
        rights=rights,
    )


async def permission(
    forum: Forum, driver: DriverClient, command: Command, terms: CommandTerms, plan: Plan
) -> tuple[Verdict, Capabilities | None]:
    """Read the post, its author, the rights and the robot's limits anew and judge again; also the limits judged by.

    What cannot be read is not granted. Rules that begin with `command.` say that the command is no longer what it was.
    """
    try:
        post, author, rights, capabilities = await asyncio.gather(
            forum.post(command.post_id),
            forum.account(command.author.name),
            rights_on(forum, command, terms),
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
    """Whether the approval still stands as it was given, by somebody who may still give it."""
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
            return Verdict(Decision.REFUSE, "rights.hops", say("agent.rights.hops", command.language, count=MAX_HOPS))
        post_id = post.reply_to
    return None


def _denied(rule: str, command: Command) -> Verdict:
    reason = say(f"agent.because.{rule.removeprefix('command.')}", command.language)
    return Verdict(Decision.REFUSE, rule, reason)
