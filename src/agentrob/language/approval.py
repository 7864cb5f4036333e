"""Whether a post approves or denies what somebody else asked of a robot: it says that and nothing else.

The opposite of a stop: in doubt it is no approval. So a question ("approve?"), a request ("please approve", 请批准), a
condition and an approval with a command beside it are none, nor is a line of which code hides a part.
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
#: What may stand beside it and changes nothing.
_BESIDE = frozenset({"yes", "ok", "okay", "thanks", "thank you", "好", "好的", "谢谢", "謝謝"})
_CLAUSE_END = re.compile(r"[,.!;:\n，。！；：、]+")


def approval_in(visible: str) -> ApprovalIntent | None:
    """`visible` is what `visible_text` gives. None when it says anything besides."""
    clauses = (" ".join(clause.split()) for clause in _CLAUSE_END.split(without_mentions(visible).casefold()))
    said = [clause for clause in clauses if clause and clause not in _BESIDE]
    return _SAID.get(said[0]) if len(said) == 1 else None
