"""Record HTTP exchanges between the adapter and a real NodeBB, and replay them without it.

A tape is a file of JSON lines, one for each exchange in order: the caller, the request and the response. `writes` is
the number of writes before the exchange. In a replay, a write gets the next recorded response to the same caller,
method and path. A read gets the response recorded after the same number of writes, so reads may be more or less
frequent than in the recording, and repeated equal responses are stored once. Timestamps are shifted to the present, and
again if the replay is slower than the recording, so no new post looks old. A write that was recorded after writes of
others that have not been made yet is not on the tape: its answer would show what is still to come. Passwords, session
ids and unused fields are not stored.
"""

from __future__ import annotations

import asyncio
import json
import re
import time
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from dataclasses import asdict, dataclass, field
from email.utils import formatdate
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl, urlencode

import httpx2
import uvicorn
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from agentrob.forums.http import USER_AGENT
from tests.waiting import until

Message = dict[str, Any]
Receive, Send = Callable[[], Awaitable[Message]], Callable[[Message], Awaitable[None]]
_TIME = re.compile(r"(?<!\d)1[78]\d{11}(?!\d)")
_KEPT_WORDS = (
    "status code message response csrf_token loggedIn postsPerPage topicsPerPage categories cid name handle "
    "slug description disabled children uid username userslug displayname banned muted groups private hidden "
    "tid pid mainPid title titleRaw timestamp edited deleted scheduled toPid content topic user category "
    "postcount topic_count posts topics index timestamps queued id data rawContent images url next pong error "
    "reason banned_until uids matchCount notifications nid type read allowPrivateGroups system secret token "
)
_KEPT = frozenset(_KEPT_WORDS.split())
#: More fields that the tests do not need, by endpoint: the adapter requests posts one by one.
_UNREAD = (
    (re.compile(r"GET /api/(categories|groups/)"), {"posts"}),
    (re.compile(r"GET /api/topic/"), {"content", "user", "category"}),
    (re.compile(r"GET /api/category/"), {"category"}),
    (re.compile(r"GET /api/recent/posts"), {"user", "category", "url", "title", "slug"}),
    (re.compile(r"GET /api/user/[^/]+/posts"), {"content", "user", "topic", "category"}),
    (re.compile(r"GET /api/v3/posts/\d+/summary"), {"category", "url"}),
    (re.compile(r"(POST|PUT) /api/v3/(topics|posts)"), {"content", "user", "topic", "category"}),
)
_JSON = "application/json; charset=utf-8"


@dataclass(slots=True)
class Exchange:
    """One request and its response; `what` is `method path`, or `socket` for a WebSocket message."""

    who: str
    what: str
    writes: int
    status: int = 200
    kind: str = _JSON
    cookie: str = ""
    body: str = ""


@dataclass
class Tape:
    """A recording that began at `at_ms`. A tape with `made_of` in its first line was edited by hand from the named
    recording, with another text in a post; a new recording replaces it."""

    at_ms: int = 0
    exchanges: list[Exchange] = field(default_factory=list)

    def save(self, path: Path) -> None:
        """Write the tape; a repeated response is replaced by the number of its first exchange: `"as": 12`."""
        lines, given = [json.dumps({"at_ms": self.at_ms})], dict[str, int]()
        for number, e in enumerate(_without_repeats(self.exchanges)):
            line = {k: v for k, v in asdict(e).items() if v not in ("", 200, _JSON)}
            if e.body in given:
                line["as"] = given[line.pop("body")]
            elif len(e.body) > 20:
                given[e.body] = number
            if "body" in line and e.what != "socket" and e.kind == _JSON:
                line["json"] = json.loads(line.pop("body"))
            lines.append(json.dumps(line, ensure_ascii=False, separators=(",", ":")))
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")

    @classmethod
    def load(cls, path: Path) -> Tape:
        first, *rest = path.read_text(encoding="utf-8").splitlines()
        tape = cls(json.loads(first)["at_ms"])
        for line in rest:
            found = json.loads(line)
            if "json" in found:
                found["body"] = json.dumps(found.pop("json"), ensure_ascii=False)
            if "as" in found:
                found["body"] = tape.exchanges[found.pop("as")].body
            tape.exchanges.append(Exchange(**found))
        return tape


def _without_repeats(exchanges: list[Exchange]) -> list[Exchange]:
    """Drop reads with the same response as the read before them, up to the next change."""
    last: dict[tuple[str, str, int], list[Exchange]] = {}
    for e in exchanges:
        if e.what.startswith("GET "):
            last.setdefault((e.who, e.what, e.writes), []).append(e)
    dropped: set[int] = set()
    for same in last.values():
        while len(same) > 1 and same[-1] == same[-2]:
            dropped.add(id(same.pop()))
    return [e for e in exchanges if id(e) not in dropped]


class _Server:
    """An ASGI application that identifies callers by their cookies or tokens."""

    def __init__(self, tape: Tape) -> None:
        self.tape = tape
        self.writes = 0
        self.callers: dict[str, str] = {}
        #: The most concurrent writes of one caller; NodeBB would refuse the second.
        self.most_at_once = 0
        self._writing: Counter[str] = Counter()
        #: All requests: caller, `method path`.
        self.asked: list[tuple[str, str]] = []
        #: All writes: caller, `method path`, body.
        self.sent: list[tuple[str, str, bytes]] = []

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
            headers = {k.decode().lower(): v.decode() for k, v in scope["headers"]}
            body = b""
            while (part := await receive())["type"] == "http.request":
                body += part["body"]
                if not part["more_body"]:
                    break
            what, who = _what(scope), self.who(headers, scope["path"], body)
            self.asked.append((who, what))
            if not _is_write(what):
                await self.answer(scope, headers, body, send)
                return
            self.sent.append((who, what, body))
            self._writing[who] += 1
            self.most_at_once = max(self.most_at_once, self._writing[who])
            await self.answer(scope, headers, body, send)
            self._writing[who] -= 1
        elif scope["type"] == "websocket":
            headers = {k.decode().lower(): v.decode() for k, v in scope["headers"]}
            await self.serve_socket(scope, headers, receive, send)

    async def answer(self, scope: Message, headers: dict[str, str], body: bytes, send: Send) -> None:
        raise NotImplementedError

    async def serve_socket(self, scope: Message, headers: dict[str, str], receive: Receive, send: Send) -> None:
        raise NotImplementedError

    def who(self, headers: dict[str, str], path: str, body: bytes) -> str:
        """Return the caller: an account's name, a token by its number, or a guest; other programs with their name."""
        program = headers.get("user-agent", USER_AGENT)
        return self._caller(headers, path, body) + ("" if program == USER_AGENT else f" with {program}")

    def _caller(self, headers: dict[str, str], path: str, body: bytes) -> str:
        if path == "/login":
            return "guest " + json.loads(body)["username"]
        if "authorization" in headers:
            return self.callers.setdefault(headers["authorization"], f"token {len(self.callers)}")
        return self.callers.get(headers.get("cookie", ""), "guest")


def _what(scope: Message) -> str:
    query = [(k, v) for k, v in parse_qsl(scope["query_string"].decode()) if k != "lang"]
    path = scope["raw_path"].decode().partition("?")[0]
    return f"{scope['method']} {path}" + (f"?{urlencode(query)}" if query else "")


def _is_write(what: str) -> bool:
    return not what.startswith(("GET ", "POST /login"))


async def _send(send: Send, e: Exchange, body: bytes) -> None:
    headers = [(b"content-type", e.kind.encode()), (b"date", formatdate(usegmt=True).encode())]
    if e.cookie:
        headers.append((b"set-cookie", f"express.sid={e.cookie}; Path=/; HttpOnly".encode()))
    await send({"type": "http.response.start", "status": e.status, "headers": headers})
    await send({"type": "http.response.body", "body": body})


# ---------------------------------------------------------------------- recording
class Recorder(_Server):
    """A proxy in front of a real NodeBB that records the exchanges."""

    def __init__(self, target: str) -> None:
        super().__init__(Tape(_now_ms()))
        self._target = target
        self._http = httpx2.AsyncClient(base_url=target, trust_env=False, timeout=100)
        self._names: dict[str, str] = {}
        self._under_way = 0

    async def answer(self, scope: Message, headers: dict[str, str], body: bytes, send: Send) -> None:
        what, who = _what(scope), self.who(headers, scope["path"], body)
        passed = {k: v for k, v in headers.items() if k not in ("host", "content-length", "connection")}
        path = scope["raw_path"].decode().partition("?")[0] + "?" + scope["query_string"].decode()
        self._http.cookies.clear()
        self._under_way += _is_write(what)
        said = await self._http.request(scope["method"], path, headers=passed, content=body)
        self._under_way -= _is_write(what)
        entry = Exchange(who, what, self.writes, said.status_code, said.headers.get("content-type", ""))
        self.writes += _is_write(what)
        cookie = next((c for c in said.headers.get_list("set-cookie") if c.startswith("express.sid=")), "")
        value = cookie.partition("=")[2].partition(";")[0]
        if cookie:
            entry.cookie = self._names.setdefault(value, f"session-{len(self._names)}")
        if what.startswith("POST /login") and said.status_code == 200:
            self.callers[f"express.sid={value}"] = who.removeprefix("guest ")
        entry.body = pruned(what, said.content) if "json" in entry.kind else said.content.hex()
        self.tape.exchanges.append(entry)
        answer = Exchange(who, what, 0, entry.status, entry.kind, value)
        await _send(send, answer, said.content)

    async def serve_socket(self, scope: Message, headers: dict[str, str], receive: Receive, send: Send) -> None:
        who = self.who(headers, "/socket.io/", b"")
        address = f"ws{self._target.removeprefix('http')}/socket.io/?{scope['query_string'].decode()}"
        async with connect(address, additional_headers={"Cookie": headers["cookie"]}, origin=self._target) as socket:
            await receive()
            await send({"type": "websocket.accept"})

            async def down() -> None:
                async for packet in socket:
                    text = str(packet)
                    if text[:2] in ("0{", "40", "42"):
                        kept = f'42["{json.loads(text[2:])[0]}"]' if text[:2] == "42" else text
                        # it may arrive before the response of the change that it reports
                        self.tape.exchanges.append(Exchange(who, "socket", self.writes + self._under_way, body=kept))
                    await send({"type": "websocket.send", "text": text})

            going = asyncio.create_task(down())
            while (message := await receive())["type"] == "websocket.receive":
                await socket.send(message["text"])
            going.cancel()
            with suppress(asyncio.CancelledError, ConnectionClosed):
                await going


def pruned(what: str, body: bytes) -> str:
    """Return a response without the fields that the tests do not need."""
    unread = frozenset[str]().union(*(names for calls, names in _UNREAD if calls.match(what)))

    def prune(found: Any) -> Any:
        if isinstance(found, dict):
            kept = {k: prune(v) for k, v in found.items() if k in _KEPT and k not in unread}
            return {**kept, "csrf_token": "csrf"} if kept.get("csrf_token") else kept
        return [prune(item) for item in found] if isinstance(found, list) else found

    return json.dumps(prune(json.loads(body or b"null")), ensure_ascii=False)


# ---------------------------------------------------------------------- playing
class Player(_Server):
    """Replays the tape; a request that is not on it gets status 599 and is added to `unknown`."""

    def __init__(self, tape: Tape) -> None:
        super().__init__(tape)
        self.unknown: list[str] = []
        self._shift_ms = _now_ms() - tape.at_ms
        #: Recorded timestamps to replayed ones, and the reverse.
        self._shown: dict[int, int] = {}
        self._was: dict[int, int] = {}
        self._by_call: dict[tuple[str, str], list[Exchange]] = {}
        for e in tape.exchanges:
            self._by_call.setdefault((e.who, e.what), []).append(e)
        self._used: dict[tuple[str, str, int], int] = {}
        self._turn = asyncio.Event()

    async def answer(self, scope: Message, headers: dict[str, str], body: bytes, send: Send) -> None:
        what = _TIME.sub(lambda m: str(self._was.get(int(m[0]), int(m[0]))), _what(scope))
        who = self.who(headers, scope["path"], body)
        found = self._find(who, what)
        if found is not None and self._early(found):
            self.unknown.append(f"{who}: {what}, as write {self.writes} and not {found.writes}")
            found = Exchange(who, what, self.writes, 599, body='"this is later on the tape"')
        elif found is None:
            self.unknown.append(f"{who}: {what}")
            found = Exchange(who, what, 0, 599, body='"this is not on the tape"')
        if what.startswith("POST /login") and found.status == 200:
            self.callers[f"express.sid={found.cookie}"] = who.removeprefix("guest ")
        if _is_write(what):
            self._keep_up(found)
            self.writes = max(self.writes, found.writes + 1)
            self._turn.set()
            self._turn = asyncio.Event()
            await asyncio.sleep(0.02)  # a real server takes as long, and other requests arrive meanwhile
        moved = self._moved(found.body)
        await _send(send, found, moved.encode() if "json" in found.kind else bytes.fromhex(found.body))

    def _find(self, who: str, what: str) -> Exchange | None:
        if what == "GET /api/v3/ping":  # called any number of times, to read the server's date
            return Exchange(who, what, 0, body="{}")
        calls = self._by_call.get((who, what))
        if not calls:
            return None
        if not what.startswith("GET "):
            number = self._used.setdefault((who, what, -1), 0)
            self._used[who, what, -1] = number + 1
            return calls[min(number, len(calls) - 1)]
        then = max((e.writes for e in calls if e.writes <= self.writes), default=calls[0].writes)
        same = [e for e in calls if e.writes == then]
        number = self._used.setdefault((who, what, then), 0)
        self._used[who, what, then] = number + 1
        return same[min(number, len(same) - 1)]

    def _early(self, found: Exchange) -> bool:
        """Whether others wrote before this write in the recording, and have not yet in the replay."""
        passed = range(self.writes, found.writes) if _is_write(found.what) else ()
        writes = (e for e in self.tape.exchanges if _is_write(e.what) and e.what != "socket")
        return any(e.writes in passed and e.who != found.who for e in writes)

    def _keep_up(self, written: Exchange) -> None:
        newest = max(map(int, _TIME.findall(written.body)), default=0)
        if newest and newest not in self._shown:
            self._shift_ms = max(self._shift_ms, _now_ms() - newest)

    def _moved(self, text: str) -> str:
        return _TIME.sub(lambda m: str(self._at(int(m[0]))), text)

    def _at(self, recorded: int) -> int:
        """Return the replayed timestamp of a recorded one: always the same one, and in the recorded order."""
        if recorded not in self._shown:
            later = min((t for t in self._shown if t > recorded), default=None)
            self._shown[recorded] = recorded + (self._shift_ms if later is None else self._shown[later] - later)
            self._was[self._shown[recorded]] = recorded
        return self._shown[recorded]

    async def serve_socket(self, scope: Message, headers: dict[str, str], receive: Receive, send: Send) -> None:
        who = self.who(headers, "/socket.io/", b"")
        said = [e for e in self.tape.exchanges if e.who == who and e.what == "socket"]
        await receive()
        await send({"type": "websocket.accept"})
        saying = asyncio.create_task(self._send_events(said, send))
        await _until_closed(receive)
        saying.cancel()
        with suppress(asyncio.CancelledError):
            await saying

    async def _send_events(self, said: list[Exchange], send: Send) -> None:
        for e in said:
            while self.writes < e.writes:
                await self._turn.wait()
            await send({"type": "websocket.send", "text": e.body})


def _now_ms() -> int:
    return int(time.time() * 1000)


async def _until_closed(receive: Receive) -> None:
    while (await receive())["type"] == "websocket.receive":
        pass


@asynccontextmanager
async def serving(application: Any) -> AsyncIterator[str]:
    """Serve on a free port of loopback; return the address.

    The application sends the `Date` header itself, because uvicorn's may be up to a second old.
    """
    server = uvicorn.Server(
        uvicorn.Config(application, host="127.0.0.1", port=0, log_level="error", lifespan="off", date_header=False)
    )
    task = asyncio.create_task(server.serve())
    await until(lambda: server.started)
    try:
        yield f"http://127.0.0.1:{server.servers[0].sockets[0].getsockname()[1]}"
    finally:
        server.should_exit = server.force_exit = True
        await task
