"""Laws 1 and 2: rights depend on the account alone."""

from __future__ import annotations

import itertools
from typing import get_args

import pytest

from agentrob.model import Account, AccountKind, Decision, Role
from agentrob.screening.rights import Action, may

ACTIONS: tuple[Action, ...] = get_args(Action)


def allowed(account: Account, owner: str = "") -> set[str]:
    return {a for a in ACTIONS if may(account, a, owner=owner).decision is Decision.ALLOW}


def account(kind: AccountKind = AccountKind.HUMAN, role: Role = Role.MEMBER, suspended: bool = False) -> Account:
    return Account("1", "ann", kind, role, suspended, display_name="owner admin operator")


@pytest.mark.parametrize("kind", [AccountKind.HUMAN, AccountKind.COMMANDING_AGENT])
def test_members_look_and_stop_operators_command_human_admins_release(kind: AccountKind) -> None:
    assert allowed(account(kind, Role.GUEST)) == {"look", "stop"}
    assert allowed(account(kind, Role.MEMBER)) == {"look", "stop"}
    assert allowed(account(kind, Role.OPERATOR)) == {"look", "stop", "command"}
    human = kind is AccountKind.HUMAN
    assert allowed(account(kind, Role.MODERATOR)) == {"look", "stop", "command"} | ({"approve"} if human else set())
    assert allowed(account(kind, Role.ADMIN)) == {"look", "stop", "command"} | (
        {"approve", "release", "home"} if human else set()
    )


@pytest.mark.parametrize("role", Role)
@pytest.mark.parametrize("kind", [AccountKind.ROBOT_AGENT, AccountKind.MONITORING_AGENT])
def test_robot_and_monitoring_agents_are_never_obeyed(kind: AccountKind, role: Role) -> None:
    assert allowed(account(kind, role), owner="ann") == {"look"}


@pytest.mark.parametrize(("kind", "role"), list(itertools.product(AccountKind, Role)))
def test_suspended_accounts_may_nothing(kind: AccountKind, role: Role) -> None:
    assert allowed(account(kind, role, suspended=True), owner="ann") == set()


def test_the_owner_releases_whatever_the_role() -> None:
    assert "release" in allowed(account(), owner="ann")
    assert "release" not in allowed(account(), owner="bob")
    assert "release" not in allowed(account(kind=AccountKind.COMMANDING_AGENT), owner="ann")
    assert "release" not in allowed(Account("2", ""), owner="")


def test_a_refusal_names_its_rule_and_speaks_the_language() -> None:
    assert may(account(), "command").rule == "rights.operator"
    assert "operator" in may(account(), "command", "zh").reason
    assert may(account(), "command", "zh").reason != may(account(), "command", "en").reason


def test_an_unknown_action_is_an_error() -> None:
    with pytest.raises(ValueError, match="valid: look, stop, command, approve, release, home"):
        may(account(role=Role.ADMIN), "fly")  # type: ignore[arg-type]
