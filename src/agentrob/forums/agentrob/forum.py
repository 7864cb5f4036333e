"""The adapter for AgentRob's own board, over its HTTP API and event stream (`docs/reference/interfaces.md`)."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from datetime import UTC, datetime
from functools import partial
from typing import Any, TypeVar
from urllib.parse import quote

import httpx2
import structlog

from agentrob.config.forum import ForumConfig
from agentrob.errors import ForumDenied, ForumError, ForumLimited, ForumNotFound, ForumUnoffered, ForumUnreachable
from agentrob.forums.cards import card_by, card_of, facts_of
from agentrob.forums.http import (
    http_client,
    image_file,
    request_line,
    retry_after_s,
    same_origin,
    text_of,
    translate_errors,
)
from agentrob.forums.protocol import TRACE_ID, Board, Event, Notification, PoseViewers, Registered, Topic, Written
from agentrob.model import (
    Account,
    AccountKind,
    EventKind,
    FleetRobot,
    Page,
    Post,
    RobotRights,
    Role,
    StatusCard,
    fleet_robot,
)

_KINDS = frozenset(EventKind)
_JSON = dict[str, Any]
T = TypeVar("T")
_log = structlog.get_logger()


class BoardForum:
    """Our board over HTTP, signed in with a bearer token; fulfils `Forum`, `RobotPages` and `PosePages`.

    Cookies are never kept, since they would conflict with the token. Makes no request before the first call.
    """

    max_edits: int | None = None
    live = True
    readable_by_role = True
    fastest_poll_s = 0.0

    def __init__(self, settings: ForumConfig, token: str) -> None:
        url = settings.url.rstrip("/") + "/api/v1"
        self._http = http_client(url, 10.0, headers={"Authorization": f"Bearer {token}"})

    async def close(self) -> None:
        await self._http.aclose()

    # ---------------------------------------------------------------- Reader
    async def boards(self) -> Sequence[Board]:
        return await self._call("GET", "/boards", _boards)

    async def topic(self, topic_id: str) -> Topic:
        return await self._call("GET", f"/topics/{quote(topic_id, safe='')}", _topic)

    async def topics(self, board_id: str, cursor: str | None = None, limit: int = 20) -> Page[Topic]:
        path = f"/boards/{quote(board_id, safe='')}/topics"
        return await self._call("GET", path, partial(_page, _topic), params=_paging(cursor, limit))

    async def posts(self, topic_id: str, cursor: str | None = None, limit: int = 50) -> Page[Post]:
        path = f"/topics/{quote(topic_id, safe='')}/posts"
        return await self._call("GET", path, partial(_page, _post), params=_paging(cursor, limit))

    async def post(self, post_id: str) -> Post:
        return await self._call("GET", f"/posts/{quote(post_id, safe='')}", _post)

    async def download(self, url: str) -> bytes:
        """Download from this board only: the token goes nowhere else."""
        address = self._http.base_url.join(url)
        if not same_origin(address, self._http.base_url):
            raise ForumError(f"{url} is not a picture of this board")
        with translate_errors("the board"):
            response = await self._http.get(address)
            await _raise_for(response)
            return response.content

    # ---------------------------------------------------------------- Writer
    async def create_topic(
        self, board_id: str, title: str, body: str, *, key: str, images: Sequence[bytes] = ()
    ) -> Written:
        content = {"board_id": board_id, "title": title, "body": body, **await self._upload(images)}
        return await self._call("POST", "/topics", _written, content, key=key)

    async def reply(
        self,
        topic_id: str,
        body: str,
        *,
        key: str,
        reply_to: str | None = None,
        images: Sequence[bytes] = (),
        card: StatusCard | None = None,
    ) -> Written:
        content: _JSON = {"body": body, **await self._upload(images), **_card(card)}
        if reply_to is not None:
            content["reply_to"] = reply_to
        return await self._call("POST", f"/topics/{quote(topic_id, safe='')}/posts", _written, content, key=key)

    async def edit(
        self, post_id: str, body: str, *, images: Sequence[bytes] = (), card: StatusCard | None = None
    ) -> Post:
        return await self._edit(post_id, body, images, card)

    async def edit_once(
        self, post_id: str, body: str, *, key: str, images: Sequence[bytes] = (), card: StatusCard | None = None
    ) -> Post:
        return await self._edit(post_id, body, images, card, key)

    async def _edit(
        self, post_id: str, body: str, images: Sequence[bytes], card: StatusCard | None, key: str | None = None
    ) -> Post:
        content = {"body": body, **await self._upload(images), **_card(card)}
        return await self._call("PATCH", f"/posts/{quote(post_id, safe='')}", _post, content, key=key)

    async def find(self, key: str) -> Post | None:
        found = (await self._call("GET", "/posts", partial(_page, _post), params={"key": key})).items
        return found[0] if found else None

    async def _upload(self, images: Sequence[bytes]) -> _JSON:
        """Upload pictures first; the text then names them. Uploading twice after a lost answer is harmless."""
        ids = []
        for number, image in enumerate(images, 1):
            files = {"file": image_file(number, image)}
            ids.append(await self._call("POST", "/images", lambda sent: str(sent["id"]), files=files))
        return {"images": ids} if ids else {}

    # ---------------------------------------------------------------- Accounts
    async def me(self) -> Account:
        return await self._call("GET", "/me", _account)

    async def account(self, name: str) -> Account | None:
        try:
            return await self._call("GET", f"/accounts/{quote(name, safe='')}", _account)
        except ForumNotFound:
            return None

    async def robot_names(self) -> tuple[str, ...]:
        return await self._call("GET", "/robots", _robot_names, params={"cards": "false"})

    async def fleet(self) -> tuple[FleetRobot, ...]:
        _, now = await self.now()
        return await self._call("GET", "/robots", lambda found: tuple(_fleet_robot(r, now) for r in found["items"]))

    # ---------------------------------------------------------------- RobotRightsSource
    async def robot_rights(self, robot: str, board_id: str) -> RobotRights:
        path = f"/robots/{quote(robot, safe='')}/rights"
        return await self._call("GET", path, _rights, params={"board_id": board_id})

    # ---------------------------------------------------------------- Events
    async def now(self) -> tuple[str, datetime]:
        return await self._call("GET", "/changes", lambda c: (str(c["now"]["id"]), _time(c["now"]["at"])))

    async def changes(self, after: str, limit: int = 100) -> tuple[Event, ...]:
        return await self._call("GET", "/changes", _events, params={"after": after, "limit": limit})

    async def stream(self, after: str, heartbeat_s: float = 0.5) -> AsyncIterator[Event]:
        params: dict[str, str | float] = {"after": after, "heartbeat": heartbeat_s}
        # Give the stream up after several missing heartbeats.
        timeout = httpx2.Timeout(10.0, read=max(2.0, 4 * heartbeat_s))
        with translate_errors("the board"):
            request = self._http.stream(
                "GET", "/events", params=params, timeout=timeout, headers={"Accept": "text/event-stream"}
            )
            async with request as response:
                await _raise_for(response)
                async for message in httpx2.EventSource(response):
                    if message.event == EventKind.HEARTBEAT:
                        yield Event("", EventKind.HEARTBEAT, _heartbeat_at(message.data))
                    elif message.event in _KINDS and (event := _event_of(message.data)) is not None:
                        yield event
        raise ForumUnreachable("the board ended the event stream")

    # ---------------------------------------------------------------- RobotPages
    async def publish_robot(self, robot: str, card: dict[str, Any]) -> None:
        await self._call("PUT", f"/robots/{quote(robot, safe='')}", _nothing, {"card": card})

    async def publish_frame(self, robot: str, jpeg: bytes) -> int:
        path, headers = f"/robots/{quote(robot, safe='')}/frame", {"Content-Type": "image/jpeg"}
        return await self._call("PUT", path, lambda answer: int(answer["viewers"]), content=jpeg, headers=headers)

    async def publish_pose(self, robot: str, frame: dict[str, Any]) -> PoseViewers:
        path = f"/robots/{quote(robot, safe='')}/pose"
        return await self._call("PUT", path, _pose_viewers, frame)

    async def publish_geometry(self, robot: str, geometry: bytes) -> str:
        path, headers = f"/robots/{quote(robot, safe='')}/geometry", {"Content-Type": "application/octet-stream"}
        return await self._call("PUT", path, lambda answer: str(answer["name"]), content=geometry, headers=headers)

    async def publish_replay(self, post_id: str, replay: bytes) -> None:
        path, headers = f"/commands/{quote(post_id, safe='')}/replay", {"Content-Type": "application/octet-stream"}
        await self._call("PUT", path, _nothing, content=replay, headers=headers)

    async def robot_page(self, robot: str) -> str:
        return await self._call("GET", f"/robots/{quote(robot, safe='')}", lambda answer: str(answer["url"]))

    async def command_page(self, post_id: str) -> str:
        return await self._call("GET", f"/commands/{quote(post_id, safe='')}", lambda answer: str(answer["url"]))

    async def publish_record(self, post_id: str, reply_id: str | None, record: dict[str, Any]) -> None:
        path, body = f"/commands/{quote(post_id, safe='')}", {"reply_id": reply_id, "record": record}
        await self._call("PUT", path, _nothing, body)

    # ---------------------------------------------------------------- what not every board has
    async def search(
        self, query: str, *, board_id: str | None = None, cursor: str | None = None, limit: int = 10
    ) -> Page[Post]:
        params = {"q": query, **({"board_id": board_id} if board_id else {}), **_paging(cursor, limit)}
        return await self._call("GET", "/search", partial(_page, _post), params=params)

    async def has_semantic_search(self) -> bool:
        try:
            return await self._call("GET", "/search/modes", lambda found: "meaning" in found["items"])
        except ForumUnoffered:  # an older board
            return False

    async def search_semantic(
        self, query: str, *, board_id: str | None = None, cursor: str | None = None, limit: int = 10
    ) -> Page[Post]:
        params = {
            "q": query,
            "mode": "meaning",
            **({"board_id": board_id} if board_id else {}),
            **_paging(cursor, limit),
        }
        return await self._call("GET", "/search", partial(_page, _post), params=params)

    async def register(self, name: str, *, kind: AccountKind = AccountKind.HUMAN, display_name: str = "") -> Registered:
        """Create an account, as an admin; the secret is a bearer token."""
        new = {"name": name, "kind": str(kind), "display_name": display_name}
        account = await self._call("POST", "/admin/accounts", _account, new)
        path = f"/admin/accounts/{quote(account.name, safe='')}/tokens"
        return Registered(account, await self._call("POST", path, lambda sent: str(sent["token"]), {"label": "mcp"}))

    async def set_rights(self, name: str, *, role: Role | None = None, suspended: bool | None = None) -> Account:
        given = {"role": str(role) if role else None, "suspended": suspended}
        changes = {k: v for k, v in given.items() if v is not None}
        return await self._call("PATCH", f"/admin/accounts/{quote(name, safe='')}", _account, changes)

    async def notifications(self, cursor: str | None = None, limit: int = 20) -> Page[Notification]:
        return await self._call("GET", "/notifications", partial(_page, _notification), params=_paging(cursor, limit))

    # ---------------------------------------------------------------- buttons
    async def press_stop(self, robot: str) -> None:
        """Press the stop button of a robot's page."""
        await self._call("POST", f"/robots/{quote(robot, safe='')}/stop", _nothing)

    async def press_estop(self, robot: str) -> None:
        """Press the button that stops a robot and locks it."""
        await self._call("POST", f"/robots/{quote(robot, safe='')}/estop", _nothing)

    async def press_release(self, robot: str) -> None:
        """Press the owner's button that releases a locked robot."""
        await self._call("POST", f"/robots/{quote(robot, safe='')}/release", _nothing)

    async def press_home(self, robot: str) -> None:
        """Press the owner's button that sets the robot's home to where it stands."""
        await self._call("POST", f"/robots/{quote(robot, safe='')}/home", _nothing)

    async def press_reset(self, robot: str) -> None:
        """Press the button that resets a simulated room; operators only."""
        await self._call("POST", f"/robots/{quote(robot, safe='')}/reset", _nothing)

    # ---------------------------------------------------------------- inside
    async def _call(
        self,
        method: str,
        path: str,
        read: Callable[[Any], T],
        body: Mapping[str, Any] | None = None,
        *,
        key: str | None = None,
        **more: Any,
    ) -> T:
        """Send a request and return `read` of the JSON answer. Raises `ForumError` for everything that goes wrong."""
        headers = dict(more.pop("headers", {}))
        if key is not None:
            headers["Idempotency-Key"] = key
        if trace_id := TRACE_ID.get():
            headers["X-Trace-Id"] = trace_id
        with translate_errors("the board"):
            response = await self._http.request(method, path, json=body, headers=headers, **more)
            await _raise_for(response)
            return read(response.json() if response.content else None)


async def _raise_for(response: httpx2.Response) -> None:
    if response.is_success:
        return
    await response.aread()
    message = _problem(response)
    unoffered = response.status_code == 404 and _code(response) in ("not_found", "no_meaning")
    if response.status_code == 405 or unoffered:
        # or no such path: an older board, or another server
        raise ForumUnoffered(f"this board does not have it: {message}")
    match response.status_code:
        case 401 | 403:
            raise ForumDenied(message)
        case 404 | 410:
            raise ForumNotFound(message)
        case 429:
            raise ForumLimited(message, retry_after_s(response))
        case code if code >= 500:
            raise ForumUnreachable(message)
    raise ForumError(message)


def _problem(response: httpx2.Response) -> str:
    """Return one sentence from a problem-detail answer, or from the text of a proxy."""
    try:
        problem = response.json()
        details = "; ".join(str(problem[k]) for k in ("detail", "hint") if problem.get(k))
        message = details or str(problem.get("title", ""))
    except (ValueError, AttributeError, TypeError):
        message = response.text[:200]
    return f"{request_line(response)} {message}".rstrip()


def _code(response: httpx2.Response) -> str:
    """Return the code of a problem-detail answer, or an empty string."""
    try:
        return str(response.json()["code"])
    except (ValueError, KeyError, TypeError):
        return ""


def _paging(cursor: str | None, limit: int) -> _JSON:
    return {"limit": limit, **({"cursor": cursor} if cursor else {})}


def _card(card: StatusCard | None) -> _JSON:
    return {"card": facts_of(card)} if card else {}


def _time(text: str) -> datetime:
    return datetime.fromisoformat(text).astimezone(UTC)


def _robot_names(found: Any) -> tuple[str, ...]:
    return tuple(str(robot["name"]) for robot in found["items"])


def _fleet_robot(robot: _JSON, now: datetime) -> FleetRobot:
    seen_at = _time(robot["seen_at"]) if robot["seen_at"] else None
    return fleet_robot(str(robot["name"]), robot["card"], seen_at, now)


def _account(a: _JSON) -> Account:
    """Parse an account. An unknown kind or role becomes the one with the fewest rights."""
    kind = AccountKind(a["kind"]) if a["kind"] in frozenset(AccountKind) else AccountKind.MONITORING_AGENT
    role = Role(a["role"]) if a["role"] in frozenset(Role) else Role.GUEST
    shown, simulated = a.get("display_name") or "", a.get("commands_simulated") is True
    return Account(str(a["id"]), a["name"], kind, role, bool(a.get("suspended")), shown, simulated)


def _rights(r: _JSON) -> RobotRights:
    """Parse a robot's rights. Missing fields are an error, so that nothing is granted; unknown words grant nothing."""
    closed = r["closed_until"]
    return RobotRights(
        owner=str(r["owner"]),
        command={str(k): str(v) for k, v in r["command"].items()},
        approve=str(r["approve"]),
        release=str(r["release"]),
        board=str(r["command_role"]),
        approval=tuple(map(str, r["approval"])),
        approve_own=r.get("approve_own") is True,  # older boards do not send it
        closed_s=(_time(closed) - datetime.now(UTC)).total_seconds() if closed is not None else None,
    )


def _topic(t: _JSON) -> Topic:
    return Topic(
        str(t["id"]), str(t["board_id"]), t["title"], t.get("url") or "", _account(t["author"]), _time(t["created_at"])
    )


def _post(p: _JSON) -> Post:
    author = _account(p["author"])
    return Post(
        id=str(p["id"]),
        topic_id=str(p["topic_id"]),
        board_id=str(p["board_id"]),
        author=author,
        raw=text_of(p["raw"]),
        created_at=_time(p["created_at"]),
        version=int(p["version"]),
        edited_at=_time(p["edited_at"]) if p.get("edited_at") else None,
        removed=bool(p.get("removed")),
        mentions=tuple(p.get("mentions") or ()),
        reply_to=str(p["reply_to"]) if p.get("reply_to") is not None else None,
        key=p.get("key"),
        url=p.get("url") or "",
        images=tuple(i["url"] for i in p.get("images") or ()),
        card=card_by(author, card_of(p.get("card"))),
    )


def _page(read: Callable[[Any], T], found: _JSON) -> Page[T]:
    return Page(tuple(read(item) for item in found["items"]), found.get("next"))


def _pose_viewers(answer: _JSON) -> PoseViewers:
    return PoseViewers(int(answer["viewers"]), float(answer["every_s"]), bool(answer["body"]))


def _boards(found: _JSON) -> tuple[Board, ...]:
    return tuple(Board(b["id"], b["name"], b.get("description") or "") for b in found["items"])


def _events(found: _JSON) -> tuple[Event, ...]:
    """Parse events; skip unreadable ones and kinds of newer boards."""
    return tuple(event for e in found["items"] if (event := _event_of(e)) is not None)


def _event_of(data: Any) -> Event | None:
    """Parse an event from JSON or its text.

    An event that cannot be read in full is returned without content, so that the stream continues after it; None if its
    id cannot be read or its kind is unknown.
    """
    try:
        e = json.loads(data) if isinstance(data, str) else data
        event_id, kind = str(e["id"]), str(e["kind"])
        if kind not in _KINDS:
            return None
    except Exception as error:
        _log.warning("an event of the board cannot be read", error=repr(error)[:200])
        return None
    try:
        return _event(e)
    except Exception as error:
        _log.warning("an event of the board cannot be read", event_id=event_id, error=repr(error)[:200])
        return Event(event_id, EventKind(kind), datetime.now(UTC))


def _notification(n: _JSON) -> Notification:
    return Notification(str(n["id"]), str(n["kind"]), _post(n["post"]), bool(n.get("read")))


def _nothing(_: Any) -> None:
    """Ignore the answer's content."""


def _written(answer: _JSON) -> Written:
    return Written(_post(answer["post"]), created=bool(answer.get("created", True)))


def _heartbeat_at(data: str) -> datetime:
    """Return the board's clock from a heartbeat, or ours if it has none."""
    try:
        return _time(json.loads(data)["at"])
    except (ValueError, KeyError, TypeError):
        return datetime.now(UTC)


def _event(e: _JSON) -> Event:
    post, account = e.get("post"), e.get("account")
    return Event(
        str(e["id"]),
        EventKind(e["kind"]),
        _time(e["at"]),
        post=_post(post) if post else None,
        robot=e.get("robot"),
        account=_account(account) if account else None,
    )
