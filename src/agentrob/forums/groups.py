"""`[forum.options]` for forums without robots' roles: which groups are robots, and what each group may do."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, ClassVar, Self

from pydantic import BaseModel, ConfigDict, ValidationError, field_validator

from agentrob.errors import ConfigError
from agentrob.model import AccountKind, Role

Groups = tuple[str, ...]


class GroupOptions(BaseModel):
    """Groups by their names on the forum.

    `closed` are an account's groups that cannot be joined freely, `groups` all groups that the forum lists for it; both
    are spelled as by `spelled`.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    #: Groups that every new account is in: they give no rights (law 2).
    everybody: ClassVar[frozenset[str]]

    operators: Groups = ()
    moderators: Groups = ()
    admins: Groups = ()
    robot_agents: Groups = ()
    monitoring_agents: Groups = ()
    commanding_agents: Groups = ()

    @field_validator("operators", "moderators", "admins", "commanding_agents")
    @classmethod
    def _not_everybody(cls, names: Groups) -> Groups:
        if found := sorted({cls.spelled(name) for name in names} & cls.everybody):
            raise ValueError(f"{found[0]!r} contains every new account, and signing up gives no rights")
        return names

    @classmethod
    def of(cls, options: Mapping[str, Any]) -> Self:
        """Validate the options. Raises `ConfigError`, which names the valid ones."""
        try:
            return cls.model_validate(dict(options))
        except ValidationError as e:
            wrong = "; ".join(f"{'.'.join(map(str, x['loc']))}: {x['msg']}" for x in e.errors())
            raise ConfigError(f"forum.options: {wrong}; valid are: {', '.join(cls.model_fields)}") from None

    @staticmethod
    def spelled(name: str) -> str:
        """Return a group's name as the forum's answers spell it."""
        return name.lower()

    def among(self, names: Groups, groups: Collection[str]) -> bool:
        """Return whether one of these names is among an account's groups."""
        return any(self.spelled(name) in groups for name in names)

    def role(self, closed: Collection[str]) -> Role:
        if self.among(self.admins, closed):
            return Role.ADMIN
        if self.among(self.moderators, closed):
            return Role.MODERATOR
        return Role.OPERATOR if self.among(self.operators, closed) else Role.MEMBER

    def kind(self, groups: Collection[str], closed: Collection[str]) -> AccountKind:
        """Return the kind of account; with groups of several kinds, the one with the fewest rights.

        Being a robot takes rights away, so freely joinable groups count for it too.
        """
        if self.among(self.monitoring_agents, groups):
            return AccountKind.MONITORING_AGENT
        if self.among(self.robot_agents, groups):
            return AccountKind.ROBOT_AGENT
        return AccountKind.COMMANDING_AGENT if self.among(self.commanding_agents, closed) else AccountKind.HUMAN
