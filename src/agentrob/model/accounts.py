"""Whose word it is and what it is worth: accounts, their kinds and roles, and who may do what with a robot."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum


class AccountKind(StrEnum):
    """The kind of user behind an account. Robots never obey robot agents and monitoring agents."""

    HUMAN = "human"
    COMMANDING_AGENT = "commanding_agent"
    ROBOT_AGENT = "robot_agent"
    MONITORING_AGENT = "monitoring_agent"


class Role(StrEnum):
    """The rights of an account; each role has those of the roles before it and more.

    Guests look and stop, members also write, operators command, moderators hide, lock and move what others wrote,
    admins run the forum.
    """

    GUEST = "guest"
    MEMBER = "member"
    OPERATOR = "operator"
    MODERATOR = "moderator"
    ADMIN = "admin"

    @property
    def rank(self) -> int:
        """Its place in the order, 0 for guests."""
        return _RANKS[self]


_RANKS = {role: place for place, role in enumerate(Role)}


def _rank(role: Role) -> int:
    return role.rank


class ActionClass(StrEnum):
    """The kinds of actions that a robot's owner can grant apart: a photo, a gesture, walking and turning, a flip."""

    PHOTO = "photo"
    LOOK = PHOTO  # other looks than photos belong to the same class
    GESTURE = "gesture"
    MOVE = "move"
    RISKY = "risky"


@dataclass(frozen=True, slots=True)
class Account:
    """An identity as the forum vouches for it; `name` is the handle after the @, unique and lower case.

    `commands_simulated`: it may command simulated robots as an operator does, whatever its role.
    """

    id: str
    name: str
    kind: AccountKind = AccountKind.HUMAN
    role: Role = Role.MEMBER
    suspended: bool = False
    display_name: str = ""
    commands_simulated: bool = False

    def role_towards(self, simulated: bool) -> Role:
        """The role that counts when it commands a robot that is simulated, or is not."""
        return max(self.role, Role.OPERATOR, key=_rank) if self.commands_simulated and simulated else self.role

    def speaks_for(self, robot: object) -> bool:
        """Whether this is the robot's own account: a card counts only from it, since it shows the robot's state."""
        return self.kind is AccountKind.ROBOT_AGENT and robot == self.name


@dataclass(frozen=True, slots=True)
class RobotRights:
    """Who may do what with one robot on one board, as the forum keeps it. They narrow law 2, they never widen it.

    Each value is the least role, or `owner`, or `nobody`; a word that nobody knows grants nothing. `owner` is a handle.
    `approval` are the classes that need somebody's approval, `approve` who gives it, and `approve_own` whether they may
    approve what they asked for themselves. `closed_s` is how many seconds its maintenance still lasts;
    None: it is open.
    """

    owner: str = ""
    command: Mapping[str, str] = field(default_factory=dict)
    approve: str = "moderator"
    release: str = "owner"
    board: str = "operator"
    approval: tuple[str, ...] = ()
    approve_own: bool = False
    closed_s: float | None = None
