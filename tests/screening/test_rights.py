"""Laws 1 and 2: rights depend on the account alone."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import get_args

import pytest

from agentrob.model import Account, AccountKind, Decision, RobotRights, Role
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


@pytest.mark.parametrize("kind", AccountKind)
@pytest.mark.parametrize("role", [Role.GUEST, Role.MEMBER])
def test_law_2_an_account_for_simulated_robots_commands_these_only(kind: AccountKind, role: Role) -> None:
    ann = Account("1", "ann", kind, role, commands_simulated=True)
    obeyed = kind in (AccountKind.HUMAN, AccountKind.COMMANDING_AGENT)
    assert (may(ann, "command", simulated=True).decision is Decision.ALLOW) is obeyed
    assert may(ann, "command").decision is Decision.REFUSE, "a robot that does not say that it is simulated is real"
    assert allowed(ann) == ({"look", "stop"} if obeyed else {"look"}), "and nothing else of an operator"
    if obeyed:
        assert may(ann, "command").rule == "rights.simulated"
        assert "admin" in may(ann, "command").reason
    suspended = replace(ann, suspended=True)
    assert may(suspended, "command", simulated=True).decision is Decision.REFUSE
    assert may(replace(ann, commands_simulated=False), "command", simulated=True).decision is Decision.REFUSE


def test_law_2_an_account_for_simulated_robots_is_bound_by_the_rights_of_the_robot() -> None:
    ann = Account("1", "ann", commands_simulated=True)
    closed = RobotRights(command={"move": "operator"}, closed_s=60.0)
    for rights in (RobotRights(command={"move": "moderator"}), RobotRights(board="moderator"), closed):
        assert may(ann, "command", rights=rights, classes=["move"], simulated=True).decision is Decision.REFUSE
    operators = RobotRights(command={"move": "operator"}, approve="operator")
    assert may(ann, "command", rights=operators, classes=["move"], simulated=True).decision is Decision.ALLOW
    assert may(ann, "approve", rights=operators).decision is Decision.REFUSE


def test_a_higher_role_keeps_its_rights_towards_simulated_robots() -> None:
    assert account(role=Role.ADMIN).role_towards(True) is Role.ADMIN
    admin = replace(account(role=Role.ADMIN), commands_simulated=True)
    assert (admin.role_towards(True), admin.role_towards(False)) == (Role.ADMIN, Role.ADMIN)


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
