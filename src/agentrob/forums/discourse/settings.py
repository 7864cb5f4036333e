"""Options of a Discourse forum: credentials, the rights of groups, and the request limit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field

from agentrob.errors import ConfigError
from agentrob.forums.groups import GroupOptions
from agentrob.model import Account

#: Discourse's default limits: 60 requests per minute for an admin's key, 20 for a user's key.
DEFAULT_REQUESTS_PER_MINUTE = 60
USER_KEY_REQUESTS_PER_MINUTE = 20
#: Enough to prove every half second that the event channel works, and to read and write.
LIVE_REQUESTS_PER_MINUTE = 240

#: Groups of every new account.
EVERYBODY = frozenset({"everyone", "logged_in_users", "trust_level_0"})


class DiscourseOptions(GroupOptions):
    """`[forum.options]` of a forum of the kind `discourse`.

    Groups are given by their names on the forum, also the automatic ones: `trust_level_2` means that level and above,
    `staff` admins and moderators. Accounts in none of `operators`, `moderators` (who also approve) and `admins` only
    look and stop; groups that anybody may join give no rights (law 2: signing up makes nobody an operator).
    `requests_per_minute` is the request limit of the key (default 60, for a user's key 20); from 240 on posts are
    pushed.
    """

    everybody = EVERYBODY

    requests_per_minute: Annotated[int, Field(ge=6)] | None = None
    push: bool = True
    key_prefix: str = ""


# ---------------------------------------------------------------- who
def account(user: Mapping[str, Any], options: DiscourseOptions) -> Account:
    """Parse an account from `user` of `/u/{username}.json`. Missing fields (of a hidden profile) give no rights."""
    listed = user.get("groups") or ()
    closed = {str(g["name"]).lower() for g in listed if g.get("automatic") or g.get("public_admission") is False}
    closed |= {f"trust_level_{n}" for n in range(int(user.get("trust_level") or 0) + 1)}
    for flag in ("admin", "moderator"):
        if user.get(flag):
            closed |= {f"{flag}s", "staff"}
    listed_names = closed | {str(g["name"]).lower() for g in listed}
    return Account(
        str(user["id"]),
        str(user["username"]).lower(),
        options.kind(listed_names, closed),
        options.role(closed),
        suspended=bool(user.get("suspended_till")),
        display_name=user.get("name") or "",
    )


# ---------------------------------------------------------------- how we sign in
@dataclass(frozen=True, slots=True)
class Credentials:
    """The credentials in the token's variable; `headers` are sent with each request. Never printed.

    `name:KEY` is an API key, as that account (a key for all users may switch); `KEY` a key of a single user;
    `user-api-key:KEY` a user's own key; `login:name:password` a session.
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
        """Whether this is an admin's key: only those may give topics an `external_id`."""
        return "Api-Key" in self.headers

    def named(self, name: str) -> Credentials:
        """Return the same key as another account."""
        return Credentials({**self.headers, "Api-Username": name}, name)
