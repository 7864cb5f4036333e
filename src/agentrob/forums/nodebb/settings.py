"""Options of a NodeBB forum: credentials, and the rights of groups."""

from __future__ import annotations

import html
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from agentrob.errors import ConfigError
from agentrob.forums.groups import GroupOptions, Groups
from agentrob.model import Account

#: Groups of every account, or of every visitor.
EVERYBODY = frozenset({"registered-users", "verified-users", "unverified-users", "guests", "spiders", "fediverse"})


class NodeBBOptions(GroupOptions):
    """`[forum.options]` of a forum of the kind `nodebb`: rights and kinds of accounts by the names of their groups.

    Accounts in none of `operators`, `moderators` (who also approve) and `admins` only look and stop. Groups that
    anybody may join, or that are hidden from our account, give no rights (law 2: signing up makes nobody an operator).
    `push`: use the forum's socket; without it posts are found by polling, half a second later.
    """

    everybody = EVERYBODY

    admins: Groups = ("administrators",)
    push: bool = True

    @staticmethod
    def spelled(name: str) -> str:
        """Return a group's slug."""
        return name.lower().replace(" ", "-")

    @property
    def _rights_groups(self) -> Groups:
        return (*self.operators, *self.moderators, *self.admins, *self.commanding_agents)

    def rights_of(self, groups: Iterable[Mapping[str, Any]]) -> list[str]:
        """Return those of the groups, except system groups, that give a right."""
        slugs = {str(g.get("slug", "")).lower() for g in groups if not g.get("system")}
        giving = {self.spelled(name) for name in self._rights_groups}
        return sorted(slugs & giving)


# ---------------------------------------------------------------- who
def account(user: Mapping[str, Any], groups: Iterable[Mapping[str, Any]], options: NodeBBOptions) -> Account:
    """Parse an account from the forum's user and groups."""
    closed = {str(g.get("slug", "")).lower() for g in groups if g.get("private") and not g.get("hidden")}
    listed_names = {str(g.get("slug", "")).lower() for g in groups}
    return Account(
        str(user["uid"]),
        str(user["userslug"]).lower(),
        options.kind(listed_names, closed),
        options.role(closed),
        suspended=bool(user.get("banned") or user.get("muted")),
        display_name=html.unescape(str(user.get("displayname") or user.get("username") or "")),
    )


# ---------------------------------------------------------------- how we sign in
@dataclass(frozen=True, slots=True)
class Credentials:
    """The credentials in the token's variable. Never printed.

    `login:name:password` is a session, the only one that can upload pictures and gets push. `TOKEN` is an account's own
    bearer token, `TOKEN@UID` a master token, used as the account with that number.
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
                raise ConfigError("invalid token; expected login:NAME:PASSWORD")
            return cls(name=name, password=password)
        token, _, uid = secret.partition("@")
        if uid and not uid.isdigit():
            raise ConfigError(f"{uid!r} after the @ of a master token is not an account number (uid)")
        return cls(token=token, uid=uid)

    @property
    def by_session(self) -> bool:
        return bool(self.password)
