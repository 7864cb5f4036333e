"""Who may do what: decided by the account as the forum vouches for it, never by anything in a text (laws 1 and 2).

What a forum keeps of a robot's rights narrows the laws and never widens them: whatever stands there, commanding needs
an operator, and no agent approves or releases. What needs an approval and may have one is neither allowed nor refused.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Literal

from agentrob.language.messages.catalog import say
from agentrob.language.messages.durations import duration
from agentrob.model import Account, AccountKind, ActionClass, Decision, Language, Op, Plan, RobotRights, Role, Verdict

Action = Literal["look", "stop", "command", "approve", "release", "home"]

_CLASSES = {Op.GET_FRONT_IMAGE: ActionClass.PHOTO, Op.BACKFLIP: ActionClass.RISKY} | dict.fromkeys(
    (Op.MOVE, Op.TURN), ActionClass.MOVE
)
#: Where a forum keeps no rights of robots.
_DEFAULT = RobotRights(command=dict.fromkeys(ActionClass, str(Role.OPERATOR)))


def classes_of(plan: Plan) -> tuple[ActionClass, ...]:
    """The classes of action that a plan has, each once; whatever is no photo, walk or flip is a gesture."""
    return tuple(dict.fromkeys(_CLASSES.get(step.op, ActionClass.GESTURE) for step in plan.steps))


def may(
    account: Account,
    action: Action,
    language: Language = "en",
    owner: str = "",
    rights: RobotRights | None = None,
    classes: Collection[str] = (),
) -> Verdict:
    """Whether `account` may do `action` now.

    `owner` is the handle of the robot's owner as its configuration has it, `rights` what the forum keeps of the robot,
    `classes` what a command would do. Everybody signed in looks and stops; operators command, where `rights` let them;
    the robot's owner and human admins release it and set its home, and approve. Suspended accounts may nothing, not
    even stop; robot and monitoring agents may look and are never obeyed, whatever their role.
    """
    if account.suspended:
        return _refused("rights.suspended", "refuse.suspended", language)
    if action == "look":
        return Verdict(Decision.ALLOW, "rights.look")
    if account.kind is AccountKind.ROBOT_AGENT:
        return _refused("rights.robot_agent", "refuse.robot", language)
    if account.kind is AccountKind.MONITORING_AGENT:
        return _refused("rights.monitoring_agent", "refuse.monitor", language)
    if action == "command" and (objection := _objection(account, rights or _DEFAULT, classes, language)):
        return objection
    if action == "approve" and not _approves(account, owner, rights or _DEFAULT):
        return _refused("rights.approver", "refuse.approver", language)
    if action in ("release", "home") and not _releases(account, owner, rights or _DEFAULT):
        return _refused("rights.owner", "refuse.owner", language)
    if action not in ("stop", "command", "approve", "release", "home"):
        raise ValueError(f"no action named {action!r}; there are look, stop, command, approve, release and home")
    return Verdict(Decision.ALLOW, f"rights.{action}")


def may_approve(
    account: Account, author: Account, language: Language = "en", rights: RobotRights | None = None
) -> Verdict:
    """Whether `account` may approve or deny now what `author` asked of the robot: nobody their own, unless the robot's
    rights say so."""
    rights = rights or _DEFAULT
    granted = may(account, "approve", language, rights=rights)
    if granted.decision is Decision.ALLOW and account.id == author.id and not rights.approve_own:
        return _refused("rights.approve_own", "refuse.approve_own", language)
    return granted


def _objection(account: Account, rights: RobotRights, classes: Collection[str], language: Language) -> Verdict | None:
    """Why not, or whose leave it needs besides; None when it may."""
    if account.role.rank < Role.OPERATOR.rank:
        return _refused("rights.operator", "refuse.operator", language)
    if rights.closed_s is not None:
        return _refused("rights.closed", "refuse.closed", language, left=duration(rights.closed_s, language))
    if not _reaches(account, rights.board, rights.owner):
        return _refused("rights.board", "refuse.board", language)
    for kind in classes:
        who = rights.command.get(kind, "nobody")
        if not _reaches(account, who, rights.owner):
            return _refused(f"rights.{kind}", "refuse.class", language, kind=say(f"class.{kind}", language))
    asks = [say(f"class.{kind}", language) for kind in classes if kind in rights.approval]
    if not asks:
        return None
    kinds = say("list.joint", language).join(asks)
    if rights.approve not in (*Role, "owner"):
        return _refused("rights.approval", "refuse.approval", language, kind=kinds)
    return Verdict(Decision.NEEDS_APPROVAL, "rights.approval", say("approval.needed", language, kind=kinds))


def _reaches(account: Account, who: str, owner: str) -> bool:
    """Whether the account is what `who` says: a role and all above it, or the owner and admins."""
    if who == "owner":
        return _owns(account, owner) or account.role is Role.ADMIN
    return who in frozenset(Role) and account.role.rank >= Role(who).rank


def _owns(account: Account, owner: str) -> bool:
    return bool(owner) and account.name == owner.lower()


def _releases(account: Account, owner: str, rights: RobotRights) -> bool:
    """A person's to do: no agent takes a robot out of its halt or says where its home is. Nobody's where the forum says
    so."""
    allowed = account.role is Role.ADMIN or _owns(account, owner) or _owns(account, rights.owner)
    return (
        account.kind is AccountKind.HUMAN
        and allowed
        and rights.release in ("owner", Role.ADMIN)
        and (rights.release == "owner" or account.role is Role.ADMIN)
    )


def _approves(account: Account, owner: str, rights: RobotRights) -> bool:
    """A person's to do, and never less than an operator's."""
    if account.kind is not AccountKind.HUMAN or account.role.rank < Role.OPERATOR.rank:
        return False
    return _reaches(account, rights.approve, rights.owner or owner)


def _refused(rule: str, key: str, language: Language, **values: str) -> Verdict:
    return Verdict(Decision.REFUSE, rule, say(key, language, **values))
