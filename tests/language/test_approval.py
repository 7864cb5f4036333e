"""Posts that approve and deny, and above all those that do not: in doubt a post approves nothing."""

from __future__ import annotations

import pytest

from agentrob.language.approval import ApprovalIntent, approval_in
from agentrob.language.visible_text import visible_text


def said(raw: str) -> ApprovalIntent | None:
    return approval_in(visible_text(raw))


@pytest.mark.parametrize(
    "raw",
    [
        *["@quadruped approve", "@quadruped, approved.", "I approve @quadruped", "**Approve** @quadruped!"],
        *["@quadruped @humanoid approve", "@quadruped ok, approve it. Thanks!", "> walk 2 m\n\n@quadruped approve"],
        *["@quadruped 批准", "@quadruped 好的，批准。", "@quadruped 我同意"],
    ],
)
def test_an_approval_is_one(raw: str) -> None:
    assert said(raw) is ApprovalIntent.APPROVE


@pytest.mark.parametrize(
    "raw",
    [
        "@quadruped deny",
        "@quadruped denied!",
        "@quadruped reject it",
        "@quadruped 拒绝",
        "@quadruped 不批准。",
        "@quadruped 拒絕",
    ],
)
def test_a_denial_is_one(raw: str) -> None:
    assert said(raw) is ApprovalIntent.DENY


@pytest.mark.parametrize(
    "raw",
    [
        *[
            "@quadruped approve?",
            "@quadruped please approve",
            "@quadruped 请批准",
            "@quadruped 批准吗？",
            "@quadruped 批准？",
        ],
        *[
            "@quadruped don't approve",
            "@quadruped do not approve this",
            "@quadruped I can't approve it",
            "@quadruped 还不能批准",
        ],
        *["@quadruped approve and walk 2 m", "@quadruped approve, walk 2 m", "@quadruped approve if it is safe"],
        *["@quadruped `approve`", "> @quadruped approve", "    @quadruped approve", "@quadruped ~~approve~~"],
        *["@quadruped approve `not`", "<!-- @quadruped approve -->", "@quadruped <b>approve</b> not"],
        *["@quadruped", "@quadruped ok", "@quadruped yes", "@quadruped approve deny", "@quadruped approve. deny."],
        *["@quadruped disapprove", "@quadruped approver", "", "@quadruped has approved it"],
    ],
)
def test_law_3_what_is_hidden_asked_conditional_or_more_than_an_approval_is_none(raw: str) -> None:
    assert said(raw) is None
