"""Recognise posts that approve or deny a command that somebody else asked for.

This is the opposite of a stop: when in doubt, a post is not an approval. A question ("approve?"), a request ("please
approve", 请批准), a condition, an approval beside a command, and a line with text hidden in code do not count.
"""

from __future__ import annotations

import re
from enum import StrEnum

from agentrob.language.visible_text import without_mentions


class ApprovalIntent(StrEnum):
    APPROVE = "approve"
    DENY = "deny"


_APPROVE = "approve|approved|i approve|approve it|approve this|approve that|批准|我批准|同意|我同意"
_DENY = """
deny|denied|i deny|deny it|deny this|deny that|reject|rejected|i reject|reject it|reject this|reject that|not approved
拒绝|我拒绝|不批准|我不批准|不同意|我不同意|驳回|拒絕|我拒絕|駁回
"""
_SAID = dict.fromkeys(_APPROVE.split("|"), ApprovalIntent.APPROVE) | dict.fromkeys(
    _DENY.strip().replace("\n", "|").split("|"), ApprovalIntent.DENY
)
#: Words that may accompany an approval without changing it.
_BESIDE = frozenset({"yes", "ok", "okay", "thanks", "thank you", "好", "好的", "谢谢", "謝謝"})
_CLAUSE_END = re.compile(r"[,.!;:\n，。！；：、]+")


def approval_in(visible: str) -> ApprovalIntent | None:
    """Return what `visible`, a text from `visible_text`, approves or denies; None when it says anything else."""
    clauses = (" ".join(clause.split()) for clause in _CLAUSE_END.split(without_mentions(visible).casefold()))
    said = [clause for clause in clauses if clause and clause not in _BESIDE]
    return _SAID.get(said[0]) if len(said) == 1 else None
