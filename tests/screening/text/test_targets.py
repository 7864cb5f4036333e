"""Laws 1 and 2 as a table: every kind of account, role and action, written out instead of computed."""

from __future__ import annotations

import itertools
from typing import get_args

import pytest

from agentrob.model import Account, AccountKind, Decision, Role
from agentrob.screening.rights import Action, may

#: Actions that law 2 reserves for the robot's owner, and that no right of an account covers yet.
NOT_OFFERED = ("damp", "limits")

#: "yes", or the rule that refuses. `own` is `release` of a robot that the account owns; "nobody" means that no such
#: right exists.
TABLE = """
kind              role       suspended  look       stop              command           approve           release           own               damp              home              limits
human             guest      no         yes        yes               operator          approver          owner             yes               nobody            owner             nobody
human             member     no         yes        yes               operator          approver          owner             yes               nobody            owner             nobody
human             operator   no         yes        yes               yes               approver          owner             yes               nobody            owner             nobody
human             moderator  no         yes        yes               yes               yes               owner             yes               nobody            owner             nobody
human             admin      no         yes        yes               yes               yes               yes               yes               nobody            yes               nobody
commanding_agent  guest      no         yes        yes               operator          approver          owner             owner             nobody            owner             nobody
commanding_agent  member     no         yes        yes               operator          approver          owner             owner             nobody            owner             nobody
commanding_agent  operator   no         yes        yes               yes               approver          owner             owner             nobody            owner             nobody
commanding_agent  moderator  no         yes        yes               yes               approver          owner             owner             nobody            owner             nobody
commanding_agent  admin      no         yes        yes               yes               approver          owner             owner             nobody            owner             nobody
robot_agent       guest      no         yes        robot_agent       robot_agent       robot_agent       robot_agent       robot_agent       robot_agent       robot_agent       robot_agent
robot_agent       member     no         yes        robot_agent       robot_agent       robot_agent       robot_agent       robot_agent       robot_agent       robot_agent       robot_agent
robot_agent       operator   no         yes        robot_agent       robot_agent       robot_agent       robot_agent       robot_agent       robot_agent       robot_agent       robot_agent
robot_agent       moderator  no         yes        robot_agent       robot_agent       robot_agent       robot_agent       robot_agent       robot_agent       robot_agent       robot_agent
robot_agent       admin      no         yes        robot_agent       robot_agent       robot_agent       robot_agent       robot_agent       robot_agent       robot_agent       robot_agent
monitoring_agent  guest      no         yes        monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent
monitoring_agent  member     no         yes        monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent
monitoring_agent  operator   no         yes        monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent
monitoring_agent  moderator  no         yes        monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent
monitoring_agent  admin      no         yes        monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent  monitoring_agent
human             guest      yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
human             member     yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
human             operator   yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
human             moderator  yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
human             admin      yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
commanding_agent  guest      yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
commanding_agent  member     yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
commanding_agent  operator   yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
commanding_agent  moderator  yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
commanding_agent  admin      yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
robot_agent       guest      yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
robot_agent       member     yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
robot_agent       operator   yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
robot_agent       moderator  yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
robot_agent       admin      yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
monitoring_agent  guest      yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
monitoring_agent  member     yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
monitoring_agent  operator   yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
monitoring_agent  moderator  yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
monitoring_agent  admin      yes        suspended  suspended         suspended         suspended         suspended         suspended         suspended         suspended         suspended
"""  # noqa: E501 (a table is read along its rows)

HEAD, *ROWS = [line.split() for line in TABLE.strip().splitlines()]
ACTIONS = HEAD[3:]
CELLS = [
    pytest.param(kind, role, suspended, action, cell, id=f"{kind}-{role}-{suspended}-{action}")
    for kind, role, suspended, *cells in ROWS
    for action, cell in zip(ACTIONS, cells, strict=True)
]


def test_law_2_the_table_has_every_kind_role_and_action_once() -> None:
    assert sorted(tuple(row[:3]) for row in ROWS) == sorted(itertools.product(AccountKind, Role, ("no", "yes")))
    assert sorted(ACTIONS) == sorted((*get_args(Action), "own", *NOT_OFFERED))
    assert {len(row) for row in ROWS} == {len(HEAD)}


@pytest.mark.parametrize(("kind", "role", "suspended", "action", "cell"), CELLS)
def test_law_2_who_may_do_what(kind: str, role: str, suspended: str, action: str, cell: str) -> None:
    account = Account("7", "ann", AccountKind(kind), Role(role), suspended == "yes", display_name="the owner")
    assert answer(account, action) == cell


def answer(account: Account, action: str) -> str:
    """Return the result of `may` in the words of the table."""
    owner = "Ann" if action == "own" else "somebody-else"
    try:
        verdict = may(account, "release" if action == "own" else action, owner=owner)  # type: ignore[arg-type]
    except ValueError:
        return "nobody"
    if verdict.decision is Decision.ALLOW:
        return "yes"
    assert verdict.decision is Decision.REFUSE
    assert verdict.reason
    return verdict.rule.removeprefix("rights.")


@pytest.mark.parametrize(
    "owner", ["аnn", "a\u200bnn", "ann.", "ａｎｎ", " ann", "ann\n", "ann ", "the owner", "7", "@ann", "an", "annn"]
)
def test_law_1_a_name_that_only_looks_like_the_owner_s_owns_nothing(owner: str) -> None:
    ann = Account("7", "ann", display_name="the owner")
    assert may(ann, "release", owner=owner).rule == "rights.owner"
    assert may(Account("8", owner, display_name="ann"), "release", owner="ann").rule == "rights.owner"


@pytest.mark.parametrize("action", ["Command", "COMMAND", " command", "command ", "", "look,command", "*"])
def test_law_2_a_misspelt_action_is_granted_to_nobody(action: str) -> None:
    for kind, role in itertools.product(AccountKind, Role):
        account = Account("7", "ann", kind, role)
        assert answer(account, action) in ("nobody", "robot_agent", "monitoring_agent")
