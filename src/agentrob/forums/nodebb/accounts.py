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

#: For lists, where nobody decides by it, an account may have been read so long ago.
LIST_AGE_S = 30.0
#: So long one answer about the forum's setting Private Groups is believed.
SETTING_AGE_S = 10.0


class AccountAdmin:
    """Accounts as the forum vouches for them, with the groups that say what they are and may do."""

    def __init__(self, client: NodeBBClient, options: NodeBBOptions) -> None:
        self._client = client
        self._options = options
        self._me: Account | None = None
        self._lately = BoundedDict[str, tuple[float, Account]](MOST_KNOWN)
        self._private = False
        self._asked_s = -SETTING_AGE_S

    async def me(self, fresh: bool = False) -> Account:
        """The account that we are signed in as; `fresh` with its rights of now."""
        if self._me is None or fresh:
            found = await self._client.get("/api/self")
            slug = str(found["userslug"])
            self._me = await self.by_slug(slug)
        return self._me

    async def by_slug(self, slug: str) -> Account:
        """By the handle after the @. `ForumNotFound` when there is none."""
        path = f"/api/user/{quote(slug, safe='')}/groups"
        try:
            found = await self._client.get(path)
        except ForumDenied as e:
            raise ForumDenied(f"{e}; our account needs the privileges View Users and View Groups") from None
        if not str(found.get("userslug") or ""):
            raise ForumNotFound(f"there is no account {slug}")
        made = account(found, await self._as_they_are(found["groups"]), self._options)
        self._lately[made.name] = (time.monotonic(), made)
        return made

    async def _as_they_are(self, groups: list[dict[str, Any]]) -> list[dict[str, Any]]:
        """With the forum's setting Private Groups switched off anybody joins any group that is not the system's own,
        whatever the group says of itself."""
        named = self._options.rights_of(groups)
        if not named or time.monotonic() - self._asked_s < SETTING_AGE_S:
            return groups if self._private or not named else [{**g, "private": g.get("system")} for g in groups]
        found = await self._client.get(f"/api/groups/{quote(named[0], safe='')}")
        self._private, self._asked_s = bool(found.get("allowPrivateGroups")), time.monotonic()
        return await self._as_they_are(groups)

    async def writer(self, uid: object, slug: str, listed: bool = False) -> Account:
        """Who wrote something; `listed`: for a list, where it may be known from just before."""
        if listed and slug in self._lately and time.monotonic() - self._lately[slug][0] < LIST_AGE_S:
            return self._lately[slug][1]
        try:
            found = await self.by_slug(slug) if slug else None
        except ForumNotFound:
            found = None
        # Nobody commands by a name whose account is gone, or is another's by now.
        return found if found and found.id == str(uid) else former(uid)

    async def add(self, name: str, password: str, kind: AccountKind, email: str, fullname: str = "") -> str:
        """Make an account, as an admin; its handle. Where the name is taken NodeBB makes another name of it: that
        account is removed again, and it is `ForumError`."""
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
        """As an administrator of the forum. A role is membership in the first group that the options name for it."""
        me = await self.me()
        if not any(g.get("slug") == "administrators" for g in await self._groups_of(me.name)):
            raise ForumDenied(f"changing rights is for administrators of the forum; we are {me.name}")
        uid = (await self.by_slug(name)).id
        if suspended is False:  # first: nobody who is banned is made an administrator
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
            raise ForumError(f"{name} is {changed.role} still: by a group that is hidden, or open to anybody")
        return changed

    async def _set_role(self, name: str, uid: str, role: Role) -> None:
        """First out of the groups of other roles, so that nobody has more in between than before or after."""
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
    """The writer of something whose account is gone: nobody, and nobody to be obeyed."""
    return Account(str(uid), "", suspended=True, display_name="(former user)")
