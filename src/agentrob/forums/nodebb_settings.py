"""What a NodeBB needs besides its address: how we sign in, and what its groups may do with robots."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError, field_validator

from agentrob.errors import ConfigError
from agentrob.model import Account, AccountKind, Role

Groups = tuple[str, ...]
#: Whoever signs up, or comes, is in these.
EVERYBODY = frozenset({"registered-users", "verified-users", "unverified-users", "guests", "spiders", "fediverse"})


class NodeBBOptions(BaseModel):
    """`[forum.options]` of a forum of the kind `nodebb`: what a member of a group may do, by the groups' names.

    Whoever is in none of `operators` and `admins` looks and stops only. Groups that anybody may join, and groups that
    are hidden from our account, give nothing (law 2: signing up makes nobody an operator). `push`: whether the forum's
    socket is used; without it posts are heard when they are next asked for, half a second later.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    operators: Groups = ()
    admins: Groups = ("administrators",)
    robot_agents: Groups = ()
    monitoring_agents: Groups = ()
    commanding_agents: Groups = ()
    push: bool = True

    @field_validator("operators", "admins", "commanding_agents")
    @classmethod
    def _not_everybody(cls, names: Groups) -> Groups:
        if found := sorted({name.lower().replace(" ", "-") for name in names} & EVERYBODY):
            raise ValueError(f"whoever signs up is in {found[0]}, and signing up gives no right")
        return names

    @classmethod
    def of(cls, options: Mapping[str, Any]) -> NodeBBOptions:
        """Check what the configuration says. Raises `ConfigError` that names what is valid."""
        try:
            return cls.model_validate(dict(options))
        except ValidationError as e:
            wrong = "; ".join(f"{'.'.join(map(str, x['loc']))}: {x['msg']}" for x in e.errors())
            raise ConfigError(f"forum.options: {wrong}; valid are: {', '.join(cls.model_fields)}") from None

    def rights_of(self, groups: Iterable[Mapping[str, Any]]) -> list[str]:
        """Those of the groups, not the forum's own, that give a right."""
        slugs = {str(g.get("slug", "")).lower() for g in groups if not g.get("system")}
        return [
            slug for slug in sorted(slugs) if _any((*self.operators, *self.admins, *self.commanding_agents), {slug})
        ]


# ---------------------------------------------------------------- who
def account(user: Mapping[str, Any], groups: Iterable[Mapping[str, Any]], options: NodeBBOptions) -> Account:
    """An account as it is now, of what the forum says of a user and of the groups it is in."""
    closed = {str(g.get("slug", "")).lower() for g in groups if g.get("private") and not g.get("hidden")}
    role = Role.MEMBER
    for wanted, names in ((Role.OPERATOR, options.operators), (Role.ADMIN, options.admins)):
        role = wanted if _any(names, closed) else role
    # Being a robot takes rights away, so any group says it, also one that anybody may join.
    said = {str(g.get("slug", "")).lower() for g in groups}
    return Account(
        str(user["uid"]),
        str(user["userslug"]).lower(),
        _kind(said, closed, options),
        role,
        suspended=bool(user.get("banned") or user.get("muted")),
        display_name=html.unescape(str(user.get("displayname") or user.get("username") or "")),
    )


def _kind(said: set[str], closed: set[str], options: NodeBBOptions) -> AccountKind:
    """Whoever is in groups of several kinds has the one with fewest rights."""
    for kind, names, groups in (
        (AccountKind.MONITORING_AGENT, options.monitoring_agents, said),
        (AccountKind.ROBOT_AGENT, options.robot_agents, said),
        (AccountKind.COMMANDING_AGENT, options.commanding_agents, closed),
    ):
        if _any(names, groups):
            return kind
    return AccountKind.HUMAN


def _any(names: Groups, slugs: set[str]) -> bool:
    return any(name.lower().replace(" ", "-") in slugs for name in names)


# ---------------------------------------------------------------- how we sign in
@dataclass(frozen=True, slots=True)
class Credentials:
    """What the token's variable holds, taken apart; never printed.

    `login:name:password`: a session, the only one that uploads pictures and has push. `TOKEN`: an account's own bearer
    token. `TOKEN@UID`: a master token, as the account with that number.
    """

    name: str = field(default="", repr=False)
    password: str = field(default="", repr=False)
    token: str = field(default="", repr=False)
    uid: str = ""

    @classmethod
    def of(cls, secret: str) -> Credentials:
        if secret.startswith("login:"):
            name, _, password = secret.removeprefix("login:").partition(":")
            if not name or not password:
                raise ConfigError("the forum's token is not login:name:password")
            return cls(name=name, password=password)
        token, _, uid = secret.partition("@")
        if uid and not uid.isdigit():
            raise ConfigError("after the @ of a master token stands the number of an account (its uid)")
        return cls(token=token, uid=uid)

    @property
    def by_session(self) -> bool:
        return bool(self.password)
