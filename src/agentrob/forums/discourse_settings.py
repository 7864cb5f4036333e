"""What a Discourse needs besides its address: how we sign in, what groups may do, how much we may ask of it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from agentrob.errors import ConfigError
from agentrob.model import Account, AccountKind, Role

#: Discourse lets an admin's key ask 60 times a minute unless its owner lifts that; a user's key 20 times.
DEFAULT_REQUESTS_PER_MINUTE = 60
USER_KEY_REQUESTS_PER_MINUTE = 20
#: From here on the event channel can be proven alive each half second, and there is room for reading and writing.
LIVE_REQUESTS_PER_MINUTE = 240

Groups = tuple[str, ...]
#: Whoever signs up is in these.
EVERYBODY = frozenset({"everyone", "logged_in_users", "trust_level_0"})


class DiscourseOptions(BaseModel):
    """`[forum.options]` of a forum of the kind `discourse`.

    Groups are called by their names on the forum, the automatic ones too: `trust_level_2` means that level and above,
    `staff` admins and moderators. Whoever is in none of `operators` and `admins` looks and stops only; groups that
    anybody may join give nothing (law 2: signing up makes nobody an operator).
    `requests_per_minute`: what the key may ask (default 60, with a user's key 20); from 240 on posts come by push.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    operators: Groups = ()
    admins: Groups = ()
    robot_agents: Groups = ()
    monitoring_agents: Groups = ()
    commanding_agents: Groups = ()
    requests_per_minute: Annotated[int, Field(ge=6)] | None = None
    push: bool = True
    key_prefix: str = ""

    @field_validator("operators", "admins", "commanding_agents")
    @classmethod
    def _not_everybody(cls, names: Groups) -> Groups:
        if found := sorted({name.lower() for name in names} & EVERYBODY):
            raise ValueError(f"whoever signs up is in {found[0]}, and signing up gives no right")
        return names

    @classmethod
    def of(cls, options: Mapping[str, Any]) -> DiscourseOptions:
        """Check what the configuration says. Raises `ConfigError` that names what is valid."""
        try:
            return cls.model_validate(dict(options))
        except ValidationError as e:
            wrong = "; ".join(f"{'.'.join(map(str, x['loc']))}: {x['msg']}" for x in e.errors())
            raise ConfigError(f"forum.options: {wrong}; valid are: {', '.join(cls.model_fields)}") from None


# ---------------------------------------------------------------- who
def account(user: Mapping[str, Any], options: DiscourseOptions) -> Account:
    """An account of `/u/{username}.json`'s `user`, as it is now. What is not said (a hidden profile) gives no right."""
    listed = user.get("groups") or ()
    closed = {str(g["name"]).lower() for g in listed if g.get("automatic") or g.get("public_admission") is False}
    closed |= {f"trust_level_{n}" for n in range(int(user.get("trust_level") or 0) + 1)}
    for flag in ("admin", "moderator"):
        if user.get(flag):
            closed |= {f"{flag}s", "staff"}
    role = Role.MEMBER
    for wanted, names in ((Role.OPERATOR, options.operators), (Role.ADMIN, options.admins)):
        role = wanted if _any(names, closed) else role
    # Being a robot takes rights away, so any group says it, also one that anybody may join.
    said = closed | {str(g["name"]).lower() for g in listed}
    return Account(
        str(user["id"]),
        str(user["username"]).lower(),
        _kind(said, closed, options),
        role,
        suspended=bool(user.get("suspended_till")),
        display_name=user.get("name") or "",
    )


def _kind(said: Collection[str], closed: Collection[str], options: DiscourseOptions) -> AccountKind:
    """Whoever is in groups of several kinds has the one with fewest rights."""
    for kind, names, groups in (
        (AccountKind.MONITORING_AGENT, options.monitoring_agents, said),
        (AccountKind.ROBOT_AGENT, options.robot_agents, said),
        (AccountKind.COMMANDING_AGENT, options.commanding_agents, closed),
    ):
        if _any(names, groups):
            return kind
    return AccountKind.HUMAN


def _any(names: Groups, groups: Collection[str]) -> bool:
    return any(name.lower() in groups for name in names)


# ---------------------------------------------------------------- how we sign in
@dataclass(frozen=True, slots=True)
class Credentials:
    """What the token's variable holds, taken apart; `headers` are sent with each request.

    `name:KEY` an API key, as that account (a key for all users may switch); `KEY` a key of a single user;
    `user-api-key:KEY` a user's own key; `login:name:password` a session. Never printed.
    """

    headers: Mapping[str, str]
    name: str = ""
    password: str = ""

    @classmethod
    def of(cls, token: str) -> Credentials:
        what, _, rest = token.partition(":")
        if what == "login":
            name, _, password = rest.partition(":")
            if not name or not password:
                raise ConfigError("the token is not login:name:password")
            return cls({}, name, password)
        if what == "user-api-key":
            return cls({"User-Api-Key": rest})
        if rest:
            return cls({"Api-Key": rest, "Api-Username": what}, what)
        return cls({"Api-Key": token})

    def __repr__(self) -> str:
        return f"Credentials({self.name or 'by key'})"

    @property
    def by_session(self) -> bool:
        return bool(self.password)

    @property
    def by_api_key(self) -> bool:
        """An admin's key: only these may give topics an `external_id`."""
        return "Api-Key" in self.headers

    def named(self, name: str) -> Credentials:
        """The same key as another account."""
        return Credentials({**self.headers, "Api-Username": name}, name)
