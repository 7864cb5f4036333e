"""Decide who may do what, by the account as the forum vouches for it, never by a text (laws 1 and 2).

A forum's rights for a robot can only narrow the laws: commanding always needs an operator, and agents never approve or
release. A command that needs an approval and may get one is neither allowed nor refused.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Literal

from agentrob.language.messages.catalog import say
from agentrob.language.messages.durations import duration
from agentrob.model import (
    Account,
    AccountKind,
    ActionClass,
    Capabilities,
    Decision,
    Language,
    Plan,
    RobotRights,
    Role,
    Verdict,
)

Action = Literal["look", "stop", "command", "approve", "release", "home"]

#: Rights on forums that store none.
_DEFAULT = RobotRights(command=dict.fromkeys(ActionClass, str(Role.OPERATOR)))


def classes_of(plan: Plan, capabilities: Capabilities | None = None) -> tuple[ActionClass, ...]:
    """Return the action classes of a plan, each once, as the robot declares its operations; without `capabilities` as
    the plan says that they are declared. An operation that nobody declares is risky."""
    declared = ((capabilities and capabilities.operation(step.op)) or step.operation for step in plan.steps)
    return tuple(dict.fromkeys(operation.action_class for operation in declared))


def may(
    account: Account,
    action: Action,
    language: Language = "en",
    owner: str = "",
    rights: RobotRights | None = None,
    classes: Collection[str] = (),
    simulated: bool = False,
) -> Verdict:
    """Return whether `account` may do `action` now.

    `owner` is the handle of the robot's owner in its configuration, `rights` what the forum stores about the robot,
    `classes` the action classes of a command, `simulated` whether the robot itself says that it is. Everybody signed in
    may look and stop. Operators may command, as far as `rights` allow; so may, towards a simulated robot, accounts that
    may command only these. The robot's owner and human admins may release it, set its home, and approve. Suspended
    accounts may do nothing, not even stop. Robot and monitoring agents may only look, whatever their role.
    """
    if account.suspended:
        return _refused("rights.suspended", "refuse.suspended", language)
    if action == "look":
        return Verdict(Decision.ALLOW, "rights.look")
    if account.kind is AccountKind.ROBOT_AGENT:
        return _refused("rights.robot_agent", "refuse.robot", language)
    if account.kind is AccountKind.MONITORING_AGENT:
        return _refused("rights.monitoring_agent", "refuse.monitor", language)
    if action == "command":
        author = replace(account, role=account.role_towards(simulated))
        if objection := _objection(author, rights or _DEFAULT, classes, language):
            return objection
    if action == "approve" and not _approves(account, owner, rights or _DEFAULT):
        who = _who((rights or _DEFAULT).owner or owner, language)
        return _refused("rights.approver", "refuse.approver", language, who=who)
    if action in ("release", "home") and not _releases(account, owner, rights or _DEFAULT):
        return _refused("rights.owner", "refuse.owner", language)
    if action not in ("stop", "command", "approve", "release", "home"):
        raise ValueError(f"Unknown action {action!r}; valid: look, stop, command, approve, release, home")
    return Verdict(Decision.ALLOW, f"rights.{action}")


def may_approve(
    account: Account, author: Account, language: Language = "en", rights: RobotRights | None = None
) -> Verdict:
    """Return whether `account` may now approve or deny a command of `author`.

    Nobody may approve their own, unless the robot's rights allow it.
    """
    rights = rights or _DEFAULT
    granted = may(account, "approve", language, rights=rights)
    if granted.decision is Decision.ALLOW and account.id == author.id and not rights.approve_own:
        return _refused("rights.approve_own", "refuse.approve_own", language)
    return granted


def _objection(account: Account, rights: RobotRights, classes: Collection[str], language: Language) -> Verdict | None:
    """Return why the account may not command, or which approval it needs; None if it may."""
    if account.role.rank < Role.OPERATOR.rank:
        if account.commands_simulated:
            return _refused("rights.simulated", "refuse.simulated", language)
        return _refused("rights.operator", "refuse.operator", language)
    if rights.closed_s is not None:
        return _refused("rights.closed", "refuse.closed", language, left=duration(rights.closed_s, language))
    if not _reaches(account, rights.board, rights.owner):
        return _refused("rights.board", "refuse.board", language)
    for kind in classes:
        who = rights.command.get(kind, "nobody")
        if not _reaches(account, who, rights.owner):
            named = say(f"class.{kind}", language)
            return _refused(f"rights.{kind}", "refuse.class", language, kind=named, who=_who(rights.owner, language))
    asks = [say(f"class.{kind}", language) for kind in classes if kind in rights.approval]
    if not asks:
        return None
    kinds = say("list.joint", language).join(asks)
    if rights.approve not in (*Role, "owner"):
        return _refused("rights.approval", "refuse.approval", language, kind=kinds, who=_who(rights.owner, language))
    return Verdict(Decision.NEEDS_APPROVAL, "rights.approval", say("approval.needed", language, kind=kinds))


def _who(owner: str, language: Language) -> str:
    """Return who can change the rights for a robot: its owner, by name if known, and admins."""
    return say("refuse.who.named" if owner else "refuse.who.any", language, owner=owner)


def _reaches(account: Account, who: str, owner: str) -> bool:
    """Return whether the account is in `who`: a role and all above it, or the owner and admins."""
    if who == "owner":
        return _owns(account, owner) or account.role is Role.ADMIN
    return who in frozenset(Role) and account.role.rank >= Role(who).rank


def _owns(account: Account, owner: str) -> bool:
    return bool(owner) and account.name == owner.lower()


def _releases(account: Account, owner: str, rights: RobotRights) -> bool:
    """Return whether the account may release the robot or set its home.

    Only people may; the forum's rights may exclude everybody.
    """
    allowed = account.role is Role.ADMIN or _owns(account, owner) or _owns(account, rights.owner)
    return (
        account.kind is AccountKind.HUMAN
        and allowed
        and rights.release in ("owner", Role.ADMIN)
        and (rights.release == "owner" or account.role is Role.ADMIN)
    )


def _approves(account: Account, owner: str, rights: RobotRights) -> bool:
    """Return whether the account may approve: only people, and at least operators."""
    if account.kind is not AccountKind.HUMAN or account.role.rank < Role.OPERATOR.rank:
        return False
    return _reaches(account, rights.approve, rights.owner or owner)


def _refused(rule: str, key: str, language: Language, **values: str) -> Verdict:
    return Verdict(Decision.REFUSE, rule, say(key, language, **values))
