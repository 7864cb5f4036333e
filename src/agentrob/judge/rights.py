"""Who may do what: laws 1 and 2."""

from __future__ import annotations

from typing import Literal

from agentrob.model import Account, Decision, Language, Verdict

Action = Literal["look", "stop", "command", "release"]


def may(account: Account, action: Action, language: Language = "en") -> Verdict:
    """Whether `account` may do `action` now. For `release` the robot's owner is looked up by the caller."""
    return Verdict(Decision.REFUSE, "rights.not_built")
