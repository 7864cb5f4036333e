"""Whether a whole command is allowed, possible and within limits, and why not."""

from __future__ import annotations

from agentrob.model import Account, Capabilities, Decision, Language, Plan, Verdict


def screen(
    plan: Plan, *, text: str, author: Account, capabilities: Capabilities, language: Language, allow_flip: bool = False
) -> Verdict:
    """Look at the whole command on today's state. `text` is the visible text."""
    return Verdict(Decision.REFUSE, "screen.not_built")
