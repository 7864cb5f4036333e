"""Who may do what: decided by the account as the forum vouches for it, never by anything in a text (laws 1 and 2)."""

from __future__ import annotations

from typing import Literal

from agentrob.language.phrases import say
from agentrob.model import Account, AccountKind, Decision, Language, Role, Verdict

Action = Literal["look", "stop", "command", "release"]


def may(account: Account, action: Action, language: Language = "en", owner: str = "") -> Verdict:
    """Whether `account` may do `action` now. `owner` is the handle of the robot's owner, needed for `release` only.

    Members look and stop, operators command, the robot's owner and human admins release. Suspended accounts may
    nothing, not even stop; robot and monitoring agents may look and are never obeyed, whatever their role.
    """
    if account.suspended:
        return _refused("rights.suspended", "refuse.suspended", language)
    if action == "look":
        return Verdict(Decision.ALLOW, "rights.look")
    if account.kind is AccountKind.ROBOT_AGENT:
        return _refused("rights.robot_agent", "refuse.robot", language)
    if account.kind is AccountKind.MONITORING_AGENT:
        return _refused("rights.monitoring_agent", "refuse.monitor", language)
    if action == "command" and account.role not in (Role.OPERATOR, Role.ADMIN):
        return _refused("rights.operator", "refuse.operator", language)
    if action == "release" and not _releases(account, owner):
        return _refused("rights.owner", "refuse.owner", language)
    if action not in ("stop", "command", "release"):
        raise ValueError(f"no action named {action!r}; there are look, stop, command and release")
    return Verdict(Decision.ALLOW, f"rights.{action}")


def _releases(account: Account, owner: str) -> bool:
    """A person's to do: no agent takes a robot out of its halt."""
    owns = bool(owner) and account.name == owner.lower()
    return account.kind is AccountKind.HUMAN and (owns or account.role is Role.ADMIN)


def _refused(rule: str, key: str, language: Language) -> Verdict:
    return Verdict(Decision.REFUSE, rule, say(key, language))
