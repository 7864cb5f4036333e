"""Administration of a Discourse with an admin's API key: accounts, rights and notifications.

Discourse has no roles and kinds like ours. Its groups stand for them (`settings`), so changing them means joining and
leaving groups. Groups that Discourse fills automatically (`staff`, `trust_level_2`) cannot be joined.
"""

from __future__ import annotations

import secrets
from collections.abc import Mapping
from typing import Any, Protocol

from agentrob.errors import ForumDenied, ForumError, ForumNotFound, ForumUnoffered
from agentrob.forums.discourse.http import DiscourseClient
from agentrob.forums.discourse.mapping import path_segment
from agentrob.forums.discourse.settings import DiscourseOptions
from agentrob.forums.http import translate_errors
from agentrob.forums.protocol import Notification, Registered
from agentrob.model import Account, AccountKind, Page, Post, Role

_JSON = Mapping[str, Any]
#: `notification_type`; other notifications (likes, badges, messages) are not about a post to answer.
NOTICE_KINDS = {1: "mention", 2: "reply", 3: "quote", 15: "mention"}
#: Notifications per request, and the most requests for one answer.
NOTES_A_PAGE, MOST_PAGES = 60, 5
#: Discourse requires an address for every account; mail to this domain goes nowhere (RFC 2606).
NO_ADDRESS = "agents.invalid"
#: The date that Discourse uses for "for ever".
FOR_EVER = "3021-01-01"


class Forum(Protocol):
    """The part of the adapter that is needed here."""

    options: DiscourseOptions

    async def me(self) -> Account: ...

    async def account(self, name: str) -> Account | None: ...

    async def build(self, raw: _JSON, fresh: bool = False) -> Post: ...

    async def by_number(self, topic_id: int, number: int) -> _JSON | None: ...


async def notifications_of(forum: Forum, client: DiscourseClient, cursor: str | None, limit: int) -> Page[Notification]:
    """Return the notifications of the signed-in account, newest first, without those of deleted posts."""
    at = int(cursor) if cursor and cursor.isdigit() and len(cursor) < 10 else 0
    found: list[Notification] = []
    for _ in range(MOST_PAGES):
        answer = await client.get("/notifications.json", offset=at, limit=NOTES_A_PAGE)
        with translate_errors():
            notes, total = answer["notifications"], int(answer["total_rows_notifications"])
        for note in notes:
            at += 1
            if (notification := await _notification(forum, note)) is not None:
                found.append(notification)
            if len(found) == limit:
                return Page(tuple(found), str(at) if at < total else None)
        if not notes or at >= total:
            return Page(tuple(found))
    return Page(tuple(found), str(at))


async def _notification(forum: Forum, note: _JSON) -> Notification | None:
    with translate_errors():
        kind, topic, number = NOTICE_KINDS.get(note["notification_type"]), note.get("topic_id"), note.get("post_number")
        if kind is None or topic is None or number is None:
            return None
        raw = await forum.by_number(int(topic), int(number))
        return None if raw is None else Notification(str(note["id"]), kind, await forum.build(raw), bool(note["read"]))


async def create_account(client: DiscourseClient, name: str, email: str, password: str, display_name: str = "") -> bool:
    """Create an account: at once with an admin's API key, otherwise as a visitor who must confirm an e-mail.

    Returns whether the account is active. Raises `ForumError` with Discourse's reason when it is refused.
    """
    wanted: dict[str, Any] = {"name": display_name or name, "username": name, "email": email, "password": password}
    if client.credentials.by_api_key:
        wanted |= {"active": True, "approved": True}
    else:  # the honeypot shows that a visitor has read the form
        honeypot = await client.get("/session/hp.json")
        wanted |= {"password_confirmation": honeypot["value"], "challenge": honeypot["challenge"][::-1]}
    answer = await client.ask("POST", "/users.json", json=wanted)
    if not answer.get("success"):  # refused with 200
        raise ForumError(f"the forum rejects the account {name}: {answer.get('message')}")
    return bool(answer.get("active"))


class AccountAdmin:
    """Accounts and rights, for admins of the Discourse. Raises `ForumDenied` for all others."""

    def __init__(self, forum: Forum, client: DiscourseClient) -> None:
        self._forum = forum
        self._client = client

    async def register(self, name: str, kind: AccountKind, display_name: str) -> Registered:
        """Create an account that works at once, with an API key of its own."""
        await self._allowed("making accounts")
        group = None if kind is AccountKind.HUMAN else await self._group_of(_setting(kind))
        password, email = secrets.token_urlsafe(24), f"{name}@{NO_ADDRESS}"
        await create_account(self._client, name, email, password, display_name)
        if group is not None:
            await self._member("PUT", group, name)
        wanted = {"key": {"description": "made by AgentRob", "username": name}}
        made = await self._client.ask("POST", "/admin/api/keys.json", json=wanted)
        with translate_errors():
            secret = f"{name}:{made['key']['key']}"
        return Registered(await self._there(name), secret)

    async def set_rights(self, name: str, role: Role | None, suspended: bool | None) -> Account:
        await self._allowed("changing rights")
        await self._there(name)
        number = int((await self._user(name))["id"])
        if role is not None:
            await self._set_role(name, role)
        if suspended is True:
            about = {"suspend_until": FOR_EVER, "reason": "suspended through AgentRob"}
            await self._client.ask("PUT", f"/admin/users/{number}/suspend.json", json=about)
        elif suspended is False:
            await self._client.ask("PUT", f"/admin/users/{number}/unsuspend.json", json={})
        changed = await self._there(name)
        if role is not None and changed.role is not role:
            raise ForumError(f"{name} is still {changed.role}: by a hidden group, or one that Discourse fills itself")
        return changed

    # ---------------------------------------------------------------- inside
    async def _set_role(self, name: str, role: Role) -> None:
        """Leave the groups of other roles first, so that the account never has more rights than before or after."""
        options = self._forum.options
        names = {Role.OPERATOR: options.operators, Role.ADMIN: options.admins, Role.MEMBER: ()}
        if role not in names:
            raise ForumUnoffered(f"this forum cannot give the role {role}; valid: {', '.join(names)}")
        joined = None
        if role is not Role.MEMBER:
            joined = await self._group_of("operators" if role is Role.OPERATOR else "admins")
        giving = {options.spelled(g) for g in (*options.operators, *options.admins)}
        for group in (await self._user(name)).get("groups") or ():
            leaves = options.spelled(str(group["name"])) in giving and int(group["id"]) != joined
            if leaves and not group.get("automatic"):
                await self._member("DELETE", int(group["id"]), name)
        if joined is not None and joined not in await self._groups_of(name):
            await self._member("PUT", joined, name)

    async def _groups_of(self, name: str) -> set[int]:
        return {int(group["id"]) for group in (await self._user(name)).get("groups") or ()}

    async def _group_of(self, setting: str) -> int:
        """Return the first group of an option that can be joined."""
        for name in getattr(self._forum.options, setting):
            try:
                found = (await self._client.get(f"/groups/{path_segment(name)}.json"))["group"]
            except ForumNotFound:
                continue
            if not found.get("automatic"):
                return int(found["id"])
        raise ForumUnoffered(f"forum.options.{setting} names no group that an account can be put into")

    async def _member(self, method: str, group: int, name: str) -> None:
        await self._client.ask(method, f"/groups/{group}/members.json", json={"usernames": name})

    async def _user(self, name: str) -> _JSON:
        found: _JSON = (await self._client.get(f"/u/{path_segment(name)}.json"))["user"]
        return found

    async def _there(self, name: str) -> Account:
        if (found := await self._forum.account(name)) is None:
            raise ForumNotFound(f"there is no account {name!r}")
        return found

    async def _allowed(self, what: str) -> None:
        """Check that we are an admin: to others Discourse answers as if the address did not exist."""
        me = await self._forum.me()
        if not self._client.credentials.by_api_key or not (await self._user(me.name)).get("admin"):
            raise ForumDenied(f"{what} needs an API key of an admin of the Discourse; we are {me.name}")


def _setting(kind: AccountKind) -> str:
    return f"{kind.value}s"
