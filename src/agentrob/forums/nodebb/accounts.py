"""Accounts of a NodeBB: read their current rights, create them and change them as an admin."""

from __future__ import annotations

import time
from typing import Any
from urllib.parse import quote

from agentrob.errors import ForumDenied, ForumError, ForumNotFound, ForumUnoffered
from agentrob.forums.bounded import MOST_KNOWN, BoundedDict
from agentrob.forums.nodebb.http import NodeBBClient
from agentrob.forums.nodebb.settings import NodeBBOptions, account
from agentrob.model import Account, AccountKind, Role

#: How old a remembered account may be in lists, by which nothing is decided.
LIST_AGE_S = 30.0
#: How long the forum's setting Private Groups is remembered.
SETTING_AGE_S = 10.0


class AccountAdmin:
    """Accounts by the forum's current data, with the groups that give their kind and role."""

    def __init__(self, client: NodeBBClient, options: NodeBBOptions) -> None:
        self._client = client
        self._options = options
        self._me: Account | None = None
        self._lately = BoundedDict[str, tuple[float, Account]](MOST_KNOWN)
        self._private = False
        self._asked_s = -SETTING_AGE_S

    async def me(self, fresh: bool = False) -> Account:
        """Return the signed-in account; `fresh`: with its current rights."""
        if self._me is None or fresh:
            found = await self._client.get("/api/self")
            slug = str(found["userslug"])
            self._me = await self.by_slug(slug)
        return self._me

    async def by_slug(self, slug: str) -> Account:
        """Return the account of a handle. Raises `ForumNotFound` if there is none."""
        path = f"/api/user/{quote(slug, safe='')}/groups"
        try:
            found = await self._client.get(path)
        except ForumDenied as e:
            raise ForumDenied(f"{e}; our account needs the privileges View Users and View Groups") from None
        if not str(found.get("userslug") or ""):
            raise ForumNotFound(f"there is no account {slug}")
        made = account(found, await self._with_open_groups(found["groups"]), self._options)
        self._lately[made.name] = (time.monotonic(), made)
        return made

    async def _with_open_groups(self, groups: list[dict[str, Any]]) -> list[dict[str, Any]]:
        """Return the groups; those that anybody may join count as open.

        If the forum's setting Private Groups is off, anybody can join every group that is not a system group, whatever
        the group itself says.
        """
        named = self._options.rights_of(groups)
        if not named or time.monotonic() - self._asked_s < SETTING_AGE_S:
            return groups if self._private or not named else [{**g, "private": g.get("system")} for g in groups]
        found = await self._client.get(f"/api/groups/{quote(named[0], safe='')}")
        self._private, self._asked_s = bool(found.get("allowPrivateGroups")), time.monotonic()
        return await self._with_open_groups(groups)

    async def writer(self, uid: object, slug: str, listed: bool = False) -> Account:
        """Return an author; `listed`: for a list, where a recently read account will do."""
        if listed and slug in self._lately and time.monotonic() - self._lately[slug][0] < LIST_AGE_S:
            return self._lately[slug][1]
        try:
            found = await self.by_slug(slug) if slug else None
        except ForumNotFound:
            found = None
        # The name's account may be deleted, or belong to another person now.
        return found if found and found.id == str(uid) else former(uid)

    async def add(self, name: str, password: str, kind: AccountKind, email: str, fullname: str = "") -> str:
        """Create an account, as an admin, and return its handle.

        If the name is taken, NodeBB creates an account with another name: it is removed again, and `ForumError` is
        raised.
        """
        group = self._group(kind)
        more = {"email": email, "fullname": fullname}
        said = {"username": name, "password": password, **{k: v for k, v in more.items() if v}}
        made = await self._client.send("POST", "/users", said)
        uid, called, slug = str(made["uid"]), str(made["username"]), str(made["userslug"])
        if called != name:
            await self._client.send("DELETE", f"/users/{uid}")
            raise ForumError(f"the name {name} is taken; choose another one")
        if group:
            await self._client.send("PUT", f"/groups/{quote(group, safe='')}/membership/{uid}")
        return slug

    # ---------------------------------------------------------------- rights
    async def set_rights(self, name: str, role: Role | None, suspended: bool | None) -> Account:
        """Change rights, as an administrator. A role is membership in the first group that the options name for it."""
        me = await self.me()
        if not any(g.get("slug") == "administrators" for g in await self._groups_of(me.name)):
            raise ForumDenied(f"changing rights is for administrators of the forum; we are {me.name}")
        uid = (await self.by_slug(name)).id
        if suspended is False:  # first, so that a banned account never becomes an administrator
            found = await self._client.get(f"/api/user/{quote(name, safe='')}/groups")
            for state, call in (("banned", "ban"), ("muted", "mute")):
                if found.get(state):
                    await self._client.send("DELETE", f"/users/{uid}/{call}")
        if role is not None:
            await self._set_role(name, uid, role)
        if suspended is True:
            await self._client.send("PUT", f"/users/{uid}/ban", {"reason": "suspended through AgentRob"})
        changed = await self.by_slug(name)
        if role is not None and changed.role is not role:
            raise ForumError(f"{name} is still {changed.role}: by a group that is hidden or open to anybody")
        return changed

    async def _set_role(self, name: str, uid: str, role: Role) -> None:
        """Leave the groups of other roles first, so that the account never has more rights than before or after."""
        options = self._options
        named = {Role.OPERATOR: options.operators, Role.MODERATOR: options.moderators, Role.ADMIN: options.admins}
        if role is not Role.MEMBER and not named.get(role):
            raise ForumUnoffered(f"forum.options names no group whose members are {role}")
        wanted = "" if role is Role.MEMBER else options.spelled(named[role][0])
        slugs = {str(g.get("slug", "")).lower() for g in await self._groups_of(name)}
        giving = {options.spelled(group) for groups in named.values() for group in groups}
        for slug in sorted((slugs & giving) - {wanted}):
            await self._client.send("DELETE", f"/groups/{quote(slug, safe='')}/membership/{uid}")
        if wanted and wanted not in slugs:
            await self._client.send("PUT", f"/groups/{quote(wanted, safe='')}/membership/{uid}")

    async def _groups_of(self, slug: str) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = (await self._client.get(f"/api/user/{quote(slug, safe='')}/groups"))["groups"]
        return found

    def _group(self, kind: AccountKind) -> str:
        if kind is AccountKind.HUMAN:
            return ""
        setting = f"{kind.value}s"
        if not (names := getattr(self._options, setting)):
            raise ForumUnoffered(f"forum.options.{setting} names no group, so no account can be a {kind.value}")
        return self._options.spelled(str(names[0]))


def former(uid: object) -> Account:
    """Return an account without rights for an author whose account was deleted; it is never obeyed."""
    return Account(str(uid), "", suspended=True, display_name="(former user)")
