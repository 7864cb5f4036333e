"""The contract's interface to a Discourse, real or double, and a served double with validation and fault injection.

Everything goes over HTTP with an admin's key, so the same code runs against the double and a real Discourse.
"""

from __future__ import annotations

import asyncio
import json
import re
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any
from urllib.parse import parse_qs
from uuid import uuid4

import jsonschema_rs
import uvicorn

from agentrob.config.forum import ForumConfig
from agentrob.errors import ForumNotFound
from agentrob.forums.discourse.forum import DiscourseForum
from agentrob.forums.discourse.http import DiscourseClient
from agentrob.forums.discourse.settings import Credentials
from agentrob.forums.protocol import Event
from agentrob.model import AccountKind, EventKind, Role
from tests.doubles.discourse.app import create_app
from tests.doubles.discourse.document import paths
from tests.doubles.discourse.site import LIFTED, Post, Site

GROUPS = {
    "operators": ("robot-operators",),
    "admins": ("robot-admins",),
    "robot_agents": ("robot-agents",),
    "monitoring_agents": ("robot-monitors",),
    "commanding_agents": ("robot-commanders",),
}
_OF_KIND = {
    AccountKind.ROBOT_AGENT: "robot-agents",
    AccountKind.MONITORING_AGENT: "robot-monitors",
    AccountKind.COMMANDING_AGENT: "robot-commanders",
}
_OF_ROLE = {Role.OPERATOR: "robot-operators", Role.ADMIN: "robot-admins"}
CREATED, EDITED, REMOVED = EventKind.POST_CREATED, EventKind.POST_EDITED, EventKind.POST_REMOVED
PASSWORD = "a long enough password"
#: Site settings that docs/forum/discourse.md asks an admin to change; the others belong to the start-up configuration.
SITE_SETTINGS = {k: v for k, v in LIFTED.items() if not k.startswith("max_") or k == "max_edits_per_day"}


class DiscourseWorld:
    """Manages accounts, groups and the board `robots` of a Discourse with an admin's API key for all users."""

    def __init__(self, url: str, key: str, admin: str = "system", **options: Any) -> None:
        self.url, self.key, self.admin = url, key, admin
        self.options = {**GROUPS, "requests_per_minute": 100_000, **options}
        self.client = DiscourseClient(url, Credentials.of(f"{admin}:{key}"))
        self.forums: list[DiscourseForum] = []
        self.groups: dict[str, int] = {}

    async def prepare(self) -> None:
        for name, value in SITE_SETTINGS.items():
            await self.client.ask("PUT", f"/admin/site_settings/{name}.json", json={name: value})
        listed = (await self.client.get("/categories.json"))["category_list"]["categories"]
        if "robots" not in [c["slug"] for c in listed]:
            await self.client.ask("POST", "/categories.json", json={"name": "Robots", "slug": "robots"})
        for names in GROUPS.values():
            for name in names:
                self.groups[name] = await self._group(name)

    async def _group(self, name: str) -> int:
        try:
            found = (await self.client.get(f"/groups/{name}.json"))["group"]
        except ForumNotFound:
            found = (await self.client.ask("POST", "/admin/groups.json", json={"group": {"name": name}}))["basic_group"]
        return int(found["id"])

    # ---------------------------------------------------------------- the contract's World
    async def sign_in(
        self, name: str, *, kind: AccountKind = AccountKind.HUMAN, role: Role = Role.MEMBER
    ) -> DiscourseForum:
        try:
            user = (await self.client.get(f"/u/{name}.json"))["user"]
        except ForumNotFound:
            about = {"name": name, "username": name, "email": f"{name}@example.com", "password": PASSWORD}
            made = await self.client.ask("POST", "/users.json", json={**about, "active": True, "approved": True})
            user = {"id": made["user_id"], "groups": []}
            wanted = {_OF_KIND.get(kind), _OF_ROLE.get(role)} - {None}
            for group in wanted:
                await self._member("PUT", str(group), name)
            if role is Role.ADMIN:
                self.grant(name)
        if user.get("suspended_till"):
            await self.client.ask("PUT", f"/admin/users/{user['id']}/unsuspend.json", json={})
        return self.at(self.url, f"{name}:{self.key}")

    def grant(self, name: str) -> None:
        """Make an account an admin of the Discourse itself; its API cannot do this."""

    async def regroup(self, name: str, kind: AccountKind = AccountKind.HUMAN, role: Role = Role.MEMBER) -> None:
        """Set the groups of an account that an earlier test created on this Discourse."""
        for group in self.groups:
            method = "PUT" if group in (_OF_KIND.get(kind), _OF_ROLE.get(role)) else "DELETE"
            await self._member(method, group, name)

    async def _member(self, method: str, group: str, name: str) -> None:
        await self.client.ask(method, f"/groups/{self.groups[group]}/members.json", json={"usernames": name})

    def at(self, url: str, token: str, **options: Any) -> DiscourseForum:
        self.forums.append(DiscourseForum(ForumConfig(url=url, options={**self.options, **options}), token))
        return self.forums[-1]

    async def suspend(self, name: str) -> None:
        number = (await self.client.get(f"/u/{name}.json"))["user"]["id"]
        about = {"suspend_until": "2121-02-22", "reason": "a test"}
        await self.client.ask("PUT", f"/admin/users/{number}/suspend.json", json=about)

    async def remove(self, post_id: str) -> None:
        await self.client.ask("DELETE", f"/posts/{post_id}.json")

    async def unreachable(self) -> DiscourseForum:
        return self.at("http://127.0.0.1:9", "lost:token")

    async def close(self) -> None:
        for forum in self.forums:
            await forum.close()
        await self.client.close()


class LiveWorld(DiscourseWorld):
    """A real Discourse that other tests may have used before."""

    newcomer = f"planner-{uuid4().hex[:8]}"

    async def sign_in(
        self, name: str, *, kind: AccountKind = AccountKind.HUMAN, role: Role = Role.MEMBER
    ) -> DiscourseForum:
        if role is Role.ADMIN:
            return self.at(self.url, f"{self.admin}:{self.key}")
        forum = await super().sign_in(name, kind=kind, role=role)
        await self.regroup(name, kind, role)
        return forum


class DoubledWorld(DiscourseWorld):
    """The double `site`, on which any account can be made an admin."""

    site: Site

    def grant(self, name: str) -> None:
        user = self.site.named(name)
        assert user is not None
        user.admin = True


class Double:
    """Wraps the double's ASGI app: validates traffic against Discourse's OpenAPI document and injects faults."""

    def __init__(self, site: Site) -> None:
        self.site = site
        self.url = ""
        self.requests: list[tuple[str, str]] = []
        self.headers: list[dict[str, str]] = []
        self.violations: list[str] = []
        #: For each method and path, how many requests are carried out although their response is lost.
        self.lose: dict[tuple[str, str], int] = {}
        self._app = create_app(site)
        self.visitors = self._app.state.visitors

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        self.requests.append((scope["method"], scope["path"]))
        self.headers.append({k.decode(): v.decode() for k, v in scope["headers"]})
        body, answer = bytearray(), bytearray()
        status, kind = 0, ""

        async def read() -> Any:
            message = await receive()
            body.extend(message.get("body", b""))
            return message

        held = "/message-bus/" in scope["path"] and b"dlp=t" not in scope["query_string"]
        kept: list[Any] = []

        async def write(message: Any) -> None:
            nonlocal status, kind
            if held:
                await send(message)
                return
            if message["type"] == "http.response.start":
                status = message["status"]
                kind = dict(message["headers"]).get(b"content-type", b"").decode()
            answer.extend(message.get("body", b""))
            kept.append(message)

        await self._app(scope, read, write)
        if held:
            return
        if self.lose.get(place := (scope["method"], scope["path"]), 0) > 0:
            self.lose[place] -= 1
            raise ConnectionAbortedError("the answer is lost")
        self._check(scope, bytes(body), status, kind, bytes(answer))
        for message in kept:
            await send(message)

    def count(self, method: str, path: str) -> int:
        return sum(1 for m, p in self.requests if m == method and re.fullmatch(path, p))

    # ---------------------------------------------------------------- Discourse's document
    def _check(self, scope: Any, body: bytes, status: int, kind: str, answer: bytes) -> None:
        method, path = scope["method"].lower(), scope["path"]
        template = next((t for t in paths() if _matches(t, path) and method in paths()[t]), None)
        if template is None or status >= 300:
            return
        operation = paths()[template][method]
        where = f"{method} {template}"
        for parameter in operation.get("parameters", ()):
            given = parse_qs(scope["query_string"].decode())
            if parameter["in"] == "query" and parameter.get("required") and parameter["name"] not in given:
                self.violations.append(f"{where}: the query has no {parameter['name']}")
        wanted = (operation.get("requestBody") or {}).get("content", {})
        if "application/json" in wanted and method != "get" and body:
            self._hold(f"{where} request", wanted["application/json"]["schema"], json.loads(body))
        elif "multipart/form-data" in wanted:
            self._hold(f"{where} request", wanted["multipart/form-data"]["schema"], _form(body))
        told = operation["responses"].get("200", {}).get("content", {}).get("application/json")
        if told and "json" in kind:
            found = json.loads(answer)
            if found.get("action") != "enqueued":  # the document knows no queue
                self._hold(f"{where} answer", told["schema"], found)

    def _hold(self, where: str, schema: Any, found: Any) -> None:
        validator = _validator(json.dumps(schema))
        self.violations += [f"{where}: {list(e.instance_path)} {e.message[:200]}" for e in validator.iter_errors(found)]


def _form(body: bytes) -> dict[str, Any]:
    """Return the fields of a multipart body, with a file's name for the file and booleans for "true"."""
    fields = re.findall(rb'name="([^"]+)"(?:; filename="([^"]*)")?[^\r]*\r\n(?:[^\r]+\r\n)*\r\n([^\r]*)', body)
    values = {name.decode(): (file or value).decode(errors="replace") for name, file, value in fields}
    return {name: {"true": True, "false": False}.get(value, value) for name, value in values.items()}


Worlds = tuple[DiscourseWorld, Double]
_validators: dict[str, Any] = {}


def _validator(schema: str) -> Any:
    if schema not in _validators:
        _validators[schema] = jsonschema_rs.Draft202012Validator(json.loads(schema))
    return _validators[schema]


def _matches(template: str, path: str) -> bool:
    pattern = re.sub(r"\\\{(\w+)\\\}", lambda m: r"\d+" if m[1] == "id" else "[^/]+", re.escape(template))
    return re.fullmatch(pattern, path) is not None


@asynccontextmanager
async def served(settings: dict[str, float] | None = None) -> AsyncIterator[Double]:
    """Serve the double on a free port, in this event loop; at the end assert that all traffic matched the document."""
    double = Double(Site(settings))
    # asyncio sets TCP_NODELAY only if the socket's protocol is given, which create_server does not do; without it each
    # response takes 40 ms longer.
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    listener.bind(("127.0.0.1", 0))
    listener.listen()
    double.url = f"http://127.0.0.1:{listener.getsockname()[1]}"
    config = uvicorn.Config(double, log_level="critical", lifespan="off")
    config.load()
    server = uvicorn.Server(config)
    server.lifespan = config.lifespan_class(config)
    await server.startup(sockets=[listener])
    await server.on_tick(0)  # sets the `Date` header; nothing else of uvicorn's main loop is needed
    try:
        yield double
    finally:
        server.force_exit = True
        await server.shutdown([listener])
    assert not double.violations, "\n".join(sorted(set(double.violations)))


@asynccontextmanager
async def double_world(
    settings: dict[str, float] | None = None, **options: Any
) -> AsyncIterator[tuple[DiscourseWorld, Double]]:
    """Yield a prepared world on a double with all limits lifted, except the given ones."""
    async with served({**LIFTED, **(settings or {})}) as double:
        world = DoubledWorld(double.url, double.site.add_key(), **options)
        world.site = double.site
        double.site.add_category("Robots", "robots")
        world.groups = {name: double.site.add_group(name).id for names in GROUPS.values() for name in names}
        try:
            yield world, double
        finally:
            await world.close()


async def begin(forum: DiscourseForum, key: str = "begin") -> str:
    """Start a topic; return its id."""
    return (await forum.create_topic("robots", "A topic", "hello there", key=key)).post.topic_id


async def texts(forum: DiscourseForum, topic_id: str) -> list[str]:
    return [p.raw for p in (await forum.posts(topic_id)).items]


def write(site: Site, post_id: int | None = None, **wanted: object) -> Post:
    """Write a post by an account, bypassing all limits."""
    return site.write(site.users[1], wanted, post_id)


def kinds_and_posts(events: tuple[Event, ...]) -> list[tuple[EventKind, str]]:
    return [(e.kind, e.post.id if e.post else "") for e in events]


async def first(stream: AsyncIterator[Event], kind: EventKind) -> Event:
    async with asyncio.timeout(60):
        async for event in stream:
            if event.kind is kind:
                return event
    raise AssertionError("the stream ended")
