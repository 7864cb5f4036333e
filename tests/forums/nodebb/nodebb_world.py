"""The contract's interface to a NodeBB: create accounts and groups, suspend, remove and lift limits, as an admin."""

from __future__ import annotations

import contextlib
import os
from typing import Any

from agentrob.config.forum import ForumConfig
from agentrob.errors import ForumError
from agentrob.forums.nodebb.forum import NodeBBForum
from agentrob.forums.nodebb.http import NodeBBClient
from agentrob.forums.nodebb.settings import Credentials
from agentrob.forums.protocol import Forum
from agentrob.model import AccountKind, Post, Role

ADMIN = os.environ.get("AGENTROB_TEST_NODEBB_ADMIN", "") or "login:admin:on the tape"
PASSWORD = "a password of a test"
GROUPS: dict[str, list[str]] = {
    "operators": ["robot-operators"],
    "moderators": ["robot-moderators", "Global Moderators"],
    "robot_agents": ["robot-agents"],
    "monitoring_agents": ["robot-monitors"],
    "commanding_agents": ["commanding-agents"],
}
GROUP_OF = {
    Role.OPERATOR: "robot-operators",
    Role.MODERATOR: "robot-moderators",
    Role.ADMIN: "administrators",
}
#: Settings that hinder robots and tests; `docs/forum/nodebb.md` says which of them a forum should change, and how.
LIFTED = {
    "postQueue": 0,
    "newbiePostDelay": 0,
    "initialPostDelay": 0,
    "postDelay": 0,
    "uploadRateLimitThreshold": 0,
    "allowPrivateGroups": 1,
}
#: The defaults of these settings in a new NodeBB.
OWN = {"postQueue": 1, "newbiePostDelay": 120, "initialPostDelay": 10, "postDelay": 10, "uploadRateLimitThreshold": 10}


class NodeBBWorld:
    """A NodeBB, managed by its admin. A test gets new accounts: accounts of earlier tests are deleted."""

    def __init__(self, url: str, admin: str, server: Any = None, **options: Any) -> None:
        self.url = url
        self.server = server
        self.settings = ForumConfig(kind="nodebb", url=url, options={**GROUPS, **options})
        self.password = admin.rpartition(":")[2]
        self.admin = NodeBBForum(self.settings, admin)
        self.client = NodeBBClient(url, Credentials.of(admin))
        self.secrets = {admin.split(":")[1]: admin}
        self.uids: dict[str, str] = {}
        self.forums: list[NodeBBForum] = []

    async def prepare(self) -> None:
        """Create the board and groups if missing, lift limits, and delete the account that the contract creates."""
        await self.forget("planner")
        for setting, value in LIFTED.items():
            await self.set(setting, value)
        boards = [b.id for b in await self.admin.boards()]
        if "robots" not in boards:
            await self.client.send("POST", "/categories", {"name": "Robots"})
        for name, *_ in GROUPS.values():
            with contextlib.suppress(ForumError):
                await self.client.send("POST", "/groups", {"name": name, "private": 1, "disableJoinRequests": 1})

    async def own_limits(self) -> None:
        """Set the limits of a new NodeBB, with the exemptions for the robots' group that docs/forum/nodebb.md asks
        for."""
        exempt = ["administrators", "Global Moderators", *GROUPS["robot_agents"]]
        for setting in ("groupsExemptFromPostQueue", "groupsExemptFromNewUserRestrictions"):
            await self.set(setting, exempt)
        for setting, value in OWN.items():
            await self.set(setting, value)

    async def empty(self) -> None:
        """Remove the topics of earlier tests, so that a recording contains only its own."""
        cid = next(
            c["cid"] for c in (await self.client.get("/api/categories"))["categories"] if c["handle"] == "robots"
        )
        while topics := (await self.client.get(f"/api/category/{cid}"))["topics"]:
            for topic in topics:
                await self.client.send("DELETE", f"/topics/{topic['tid']}")

    async def set(self, setting: str, value: object) -> None:
        await self.client.send("PUT", f"/admin/settings/{setting}", {"value": value})

    async def sign_in(
        self, name: str, *, kind: AccountKind = AccountKind.HUMAN, role: Role = Role.MEMBER
    ) -> NodeBBForum:
        if name not in self.secrets:
            await self.forget(name)
            account, self.secrets[name] = await self.admin.add_account(name, kind=kind)
            self.uids[name] = account.id
            if role is not Role.MEMBER:
                group = {Role.OPERATOR: "robot-operators", Role.MODERATOR: "robot-moderators"}.get(
                    role, "administrators"
                )
                await self.client.send("PUT", f"/groups/{group}/membership/{account.id}")
        return self.at(self.url, self.secrets[name])

    async def forget(self, name: str) -> None:
        old = await self.admin.account(name)
        if old is not None:
            if old.role is Role.ADMIN:
                await self.client.send("DELETE", f"/groups/administrators/membership/{old.id}")
            await self.client.send("DELETE", f"/users/{old.id}/account")  # its posts stay, as a former user's

    async def token(self, uid: str, password: str = "") -> str:
        """Create a bearer token of an account, or a master token for uid `0`, which requires the admin's password."""
        headers = {"x-password-confirmation": password}
        said = {"uid": int(uid), "description": "a test"}
        made = await self.client.ask("POST", "/api/v3/admin/tokens", json=said, headers=headers)
        found = made.json()["response"]
        return str(found.get("secret") or found["token"])

    def at(self, url: str, secret: str) -> NodeBBForum:
        self.forums.append(NodeBBForum(self.settings.model_copy(update={"url": url}), secret))
        return self.forums[-1]

    async def suspend(self, name: str) -> None:
        await self.client.send("PUT", f"/users/{self.uids[name]}/ban", {"reason": "a test"})

    async def remove(self, post_id: str) -> None:
        await self.client.send("DELETE", f"/posts/{post_id}/state")

    async def unreachable(self) -> Forum:
        return self.at("http://127.0.0.1:9", "token")

    async def close(self) -> None:
        for forum in (*self.forums, self.admin):
            await forum.close()
        await self.client.close()


async def prepared(url: str, admin: str) -> None:
    """Prepare a NodeBB for a recording, bypassing the recorder."""
    world = NodeBBWorld(url, admin)
    await world.prepare()
    await world.empty()
    await world.close()


async def begin(forum: NodeBBForum, title: str = "A topic") -> Post:
    return (await forum.create_topic("robots", title, "hello there", key="topic")).post


async def texts(forum: NodeBBForum, topic_id: str) -> list[str]:
    return [p.raw for p in (await forum.posts(topic_id)).items]


def replies(nodebb: NodeBBWorld, name: str, post: Post) -> int:
    """Return how often an account tried to write a reply in the post's topic."""
    asked: int = nodebb.server.asked.count((name, f"POST /api/v3/topics/{post.topic_id}"))
    return asked
