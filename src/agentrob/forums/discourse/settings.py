"""Options of a Discourse forum: credentials, the rights of groups, and the request limit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field

from agentrob.errors import ConfigError
from agentrob.forums.groups import GroupOptions
from agentrob.model import Account

#: Discourse lets an admin's key ask 60 times a minute unless its owner lifts that; a user's key 20 times.
DEFAULT_REQUESTS_PER_MINUTE = 60
USER_KEY_REQUESTS_PER_MINUTE = 20
#: From here on the event channel can be proven alive each half second, and there is room for reading and writing.
LIVE_REQUESTS_PER_MINUTE = 240

#: Whoever signs up is in these.
EVERYBODY = frozenset({"everyone", "logged_in_users", "trust_level_0"})


class DiscourseOptions(GroupOptions):
    """`[forum.options]` of a forum of the kind `discourse`.

    Groups are called by their names on the forum, the automatic ones too: `trust_level_2` means that level and above,
    `staff` admins and moderators. Whoever is in none of `operators`, `moderators` (who approve, too) and `admins` looks
    and stops only; groups that anybody may join give nothing (law 2: signing up makes nobody an operator).
    `requests_per_minute`: what the key may ask (default 60, with a user's key 20); from 240 on posts come by push.
    """

    everybody = EVERYBODY

    requests_per_minute: Annotated[int, Field(ge=6)] | None = None
    push: bool = True
    key_prefix: str = ""


# ---------------------------------------------------------------- who
def account(user: Mapping[str, Any], options: DiscourseOptions) -> Account:
    """An account of `/u/{username}.json`'s `user`, as it is now. What is not said (a hidden profile) gives no right."""
    listed = user.get("groups") or ()
    closed = {str(g["name"]).lower() for g in listed if g.get("automatic") or g.get("public_admission") is False}
    closed |= {f"trust_level_{n}" for n in range(int(user.get("trust_level") or 0) + 1)}
    for flag in ("admin", "moderator"):
        if user.get(flag):
            closed |= {f"{flag}s", "staff"}
    said = closed | {str(g["name"]).lower() for g in listed}
    return Account(
        str(user["id"]),
        str(user["username"]).lower(),
        options.kind(said, closed),
        options.role(closed),
        suspended=bool(user.get("suspended_till")),
        display_name=user.get("name") or "",
    )


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
                raise ConfigError("invalid token; expected login:NAME:PASSWORD")
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
