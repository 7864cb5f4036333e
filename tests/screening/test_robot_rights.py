"""Law 2 with a robot's rights on the forum: these can restrict what accounts may do, and never extend it."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.model import Account, AccountKind, ActionClass, Decision, Op, Plan, Primitive, RobotRights, Role
from agentrob.screening.rights import classes_of, may, may_approve

EVERYTHING = {str(c): "operator" for c in ActionClass}
OPEN = RobotRights(owner="ann", command=EVERYTHING)


def account(role: Role, name: str = "bob", kind: AccountKind = AccountKind.HUMAN) -> Account:
    return Account("1", name, kind, role)


def rule(who: Account, rights: RobotRights, *classes: str) -> str:
    return may(who, "command", rights=rights, classes=classes or ("move",)).rule.removeprefix("rights.")


@given(
    kind=st.sampled_from(AccountKind),
    role=st.sampled_from(Role),
    suspended=st.booleans(),
    name=st.sampled_from(["ann", "bob"]),
    words=st.dictionaries(st.sampled_from(ActionClass), st.sampled_from(["owner", "guest", "member", "operator", "x"])),
    board=st.sampled_from(["guest", "member", "operator", "owner", ""]),
    action=st.sampled_from(["command", "approve", "release"]),
)
def test_law_2_no_rights_of_a_robot_let_somebody_do_what_the_law_does_not(
    kind: AccountKind, role: Role, suspended: bool, name: str, words: dict[str, str], board: str, action: str
) -> None:
    who = Account("1", name, kind, role, suspended)
    rights = RobotRights("ann", words, approve="guest", release="owner", board=board)
    granted = may(who, action, rights=rights, classes=tuple(ActionClass)).decision is Decision.ALLOW  # type: ignore[arg-type]
    lawful = not suspended and kind in (AccountKind.HUMAN, AccountKind.COMMANDING_AGENT)
    if action == "release":
        lawful = lawful and kind is AccountKind.HUMAN and (name == "ann" or role is Role.ADMIN)
    else:
        lawful = lawful and role.rank >= Role.OPERATOR.rank
    assert lawful or not granted


@pytest.mark.parametrize(
    ("who", "roles"),
    [
        *[("operator", {"operator", "moderator", "admin"}), ("moderator", {"moderator", "admin"})],
        *[("admin", {"admin"}), ("owner", {"admin"}), ("nobody", set()), ("Operator", set()), ("", set())],
    ],
)
def test_law_2_a_class_of_action_is_for_those_it_is_granted_to(who: str, roles: set[str]) -> None:
    rights = RobotRights("ann", EVERYTHING | {"move": who})
    assert {r for r in Role if rule(account(r), rights) == "command"} == roles
    assert {r for r in Role if rule(account(r), rights, "photo") == "command"} == {"operator", "moderator", "admin"}


def test_law_2_the_owner_who_is_an_operator_does_what_is_kept_for_the_owner() -> None:
    rights = RobotRights("ann", EVERYTHING | {"risky": "owner"})
    assert rule(account(Role.OPERATOR, "ann"), rights, "risky") == "command"
    assert rule(account(Role.OPERATOR, "bob"), rights, "risky") == "risky"
    assert rule(account(Role.MEMBER, "ann"), rights, "risky") == "operator", "owning is no leave to command"


def test_law_2_a_class_that_nobody_named_is_nobody_s() -> None:
    assert rule(account(Role.ADMIN), RobotRights("ann", {"photo": "operator"})) == "move"
    assert rule(account(Role.ADMIN), RobotRights()) == "move", "a forum that should know and does not"


def test_law_2_a_board_has_its_own_say() -> None:
    rights = RobotRights("ann", EVERYTHING, board="moderator")
    assert [rule(account(r), rights) for r in (Role.OPERATOR, Role.MODERATOR)] == ["board", "command"]


def test_law_7_what_needs_approval_is_neither_allowed_nor_refused() -> None:
    rights = RobotRights("ann", EVERYTHING, approval=("move",))
    verdicts = [may(account(Role.ADMIN), "command", rights=rights, classes=(c,)) for c in ("move", "photo")]
    assert [v.decision for v in verdicts] == [Decision.NEEDS_APPROVAL, Decision.ALLOW]
    assert "walk and turn" in verdicts[0].reason


def test_law_7_a_right_that_is_missing_is_refused_before_any_approval_is_asked_for() -> None:
    rights = RobotRights("ann", EVERYTHING | {"photo": "nobody"}, approval=("move",))
    assert rule(account(Role.ADMIN), rights, "move", "photo") == "photo"
    assert rule(account(Role.MEMBER), rights, "move") == "operator"


@pytest.mark.parametrize("approve", ["nobody", "", "x"])
def test_law_7_what_nobody_may_approve_is_refused(approve: str) -> None:
    verdict = may(
        account(Role.ADMIN),
        "command",
        rights=RobotRights("ann", EVERYTHING, approve=approve, approval=("move",)),
        classes=("move",),
    )
    assert (verdict.decision, verdict.rule) == (Decision.REFUSE, "rights.approval")


@pytest.mark.parametrize(
    ("approve", "allowed"),
    [
        ("operator", {"operator", "moderator", "admin", "owner"}),
        ("moderator", {"moderator", "admin"}),
        ("admin", {"admin"}),
        ("owner", {"admin", "owner"}),
        ("guest", {"operator", "moderator", "admin", "owner"}),
        ("nobody", set()),
    ],
)
def test_law_2_who_may_approve_is_a_person_whom_the_robot_s_rights_name(approve: str, allowed: set[str]) -> None:
    rights = RobotRights("ann", EVERYTHING, approve=approve)
    author = Account("9", "eve", role=Role.OPERATOR)
    people = {str(r): account(r) for r in Role} | {"owner": account(Role.OPERATOR, "ann")}
    assert {
        n for n, who in people.items() if may_approve(who, author, rights=rights).decision is Decision.ALLOW
    } == allowed
    agents = [account(Role.ADMIN, "ann", kind) for kind in AccountKind if kind is not AccountKind.HUMAN]
    assert all(may_approve(agent, author, rights=rights).decision is Decision.REFUSE for agent in agents)


@pytest.mark.parametrize("own", [False, True])
def test_law_2_nobody_approves_their_own_wish_unless_the_robot_s_rights_say_so(own: bool) -> None:
    root = account(Role.ADMIN, "ann")
    verdict = may_approve(root, root, rights=RobotRights("ann", EVERYTHING, approve_own=own))
    assert (verdict.decision is Decision.ALLOW) is own
    assert own or verdict.rule == "rights.approve_own"


def test_law_2_without_rights_of_the_robot_nobody_approves_their_own_command() -> None:
    root = account(Role.ADMIN, "ann")
    assert may_approve(root, root).rule == "rights.approve_own"
    member = account(Role.MEMBER)
    assert may_approve(member, member).rule == "rights.approver", "a right that is missing is told first"


@pytest.mark.parametrize(("in_rights", "configured"), [("ann", ""), ("", "ann"), ("ann", "bob")])
def test_law_2_the_owner_approves_whom_the_forum_names_or_else_the_configuration(
    in_rights: str, configured: str
) -> None:
    rights = RobotRights(in_rights, EVERYTHING, approve="owner")
    ann, eve = account(Role.OPERATOR, "ann"), account(Role.OPERATOR, "eve")
    assert may(ann, "approve", owner=configured, rights=rights).decision is Decision.ALLOW
    refused = may(eve, "approve", owner=configured, rights=rights)
    assert (refused.rule, "Its owner (`ann`) or an admin can" in refused.reason) == ("rights.approver", True)


def test_who_can_change_a_right_is_told_also_when_the_owner_is_not_known() -> None:
    refused = may(account(Role.OPERATOR), "approve", rights=RobotRights(command=EVERYTHING, approve="owner"))
    assert "Its owner or an admin can" in refused.reason


def test_in_maintenance_nobody_commands_and_everybody_stops() -> None:
    closed = RobotRights("ann", EVERYTHING, closed_s=(2 * 60 + 50) * 60)
    verdict = may(account(Role.ADMIN, "ann"), "command", rights=closed, classes=("move",))
    assert (verdict.rule, "for another 2 hours 50 minutes:" in verdict.reason) == ("rights.closed", True)
    assert may(account(Role.GUEST), "stop", rights=closed).decision is Decision.ALLOW


@pytest.mark.parametrize(("release", "allowed"), [("owner", {"ann", "root"}), ("admin", {"root"}), ("nobody", set())])
def test_law_2_release_can_be_narrowed(release: str, allowed: set[str]) -> None:
    rights = RobotRights("ann", EVERYTHING, release=release)
    people = [account(Role.MEMBER, "ann"), account(Role.ADMIN, "root"), account(Role.MODERATOR, "bob")]
    assert {p.name for p in people if may(p, "release", rights=rights).decision is Decision.ALLOW} == allowed


def test_a_plan_has_its_classes_once_each() -> None:
    steps = [Op.TURN, Op.MOVE, Op.HELLO, Op.SIT, Op.GET_FRONT_IMAGE, Op.BACKFLIP]
    plan = Plan(tuple(Primitive(op) for op in steps))
    assert classes_of(plan) == ("move", "gesture", "photo", "risky")
