"""Cache the responses that many clients request: posts of a topic as JSON, and as the HTML of its page.

`TopicCache` keeps results made from the posts of a topic. Before each use it checks the version of that topic and of
everything an admin can change, so a write to another topic does not clear it. `ResponseCache` is ASGI middleware: it
repeats a whole response to the same request by the same credential until any commit to the database, so a lost right, a
revoked token or a closed board takes effect at once. Only time ends a session; that takes effect within `REPEAT_S`.
"""

from __future__ import annotations

import hashlib
import re
import time
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Any, TypeVar

from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from agentrob.board.db.reader import Reader, row_id

T = TypeVar("T")
#: Characters or bytes that each of the two layers keeps, with `ENTRY_BYTES` for whatever else an entry takes: its key,
#: headers and places in tables (measured: 1,300, a short answer included).
MAX_KEPT, ENTRY_BYTES = 8_000_000, 2_000
REPEAT_S = 1.0
_HOT = re.compile(r"/api/v1/topics/\d{1,19}/posts")


class TopicCache:
    """Results made from topics' posts, in LRU order. Use it on the event loop's thread only."""

    def __init__(self, max_kept: int = MAX_KEPT) -> None:
        self._kept: OrderedDict[Hashable, tuple[Any, int, Any]] = OrderedDict()
        self._size, self._max = 0, max_kept

    def of(self, reader: Reader, topic_id: str, asked: Hashable, make: Callable[[], tuple[T, int]]) -> T:
        """The result of `make`, which also returns its size; cached until something that it shows changes.

        `asked` must contain everything that decides what the viewer sees: the account and its readable boards. No part
        of it may have unbounded length.
        """
        key, version = (topic_id, asked), reader.topic_version(row_id(topic_id, "topic"))
        if version[1] is None:  # its events were pruned, so that versions cannot be distinguished
            return make()[0]
        if (found := self._kept.get(key)) is not None and found[0] == version:
            self._kept.move_to_end(key)
            kept: T = found[2]
            return kept
        made, size = make()
        size += ENTRY_BYTES
        self._drop(key)
        self._kept[key] = (version, size, made)
        self._size += size
        while self._size > self._max and self._kept:
            self._drop(next(iter(self._kept)))
        return made

    def _drop(self, key: Hashable) -> None:
        if (old := self._kept.pop(key, None)) is not None:
            self._size -= old[1]


class ResponseCache:
    """ASGI middleware that repeats a response while the version of the database stays the same."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app
        self._answers: dict[bytes, tuple[float, list[Message]]] = {}
        self._version, self._size = 0, 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or scope["method"] != "GET" or not _HOT.fullmatch(scope["path"]):
            await self.app(scope, receive, send)
            return
        version = scope["app"].state.services.store.reader.version()
        if version is None:
            await self.app(scope, receive, send)
            return
        if version != self._version or self._size > MAX_KEPT:
            self._answers, self._version, self._size = {}, version, 0
        asked = _question(scope)
        found = self._answers.get(asked)
        if found is None or found[0] < time.monotonic():
            await self._ask(asked, version, scope, receive, send)
            return
        for message in found[1]:
            await send(dict(message))

    async def _ask(self, asked: bytes, version: int, scope: Scope, receive: Receive, send: Send) -> None:
        until, sent = time.monotonic() + REPEAT_S, list[Message]()

        async def send_and_keep(message: Message) -> None:
            sent.append(dict(message))
            await send(message)

        await self.app(scope, receive, send_and_keep)
        whole = len(sent) == 2 and sent[0].get("status") == 200 and not sent[1].get("more_body")
        if whole and version == self._version:
            self._answers[asked] = (until, sent)
            self._size += len(sent[1].get("body", b"")) + ENTRY_BYTES


def _question(scope: Scope) -> bytes:
    """The cache key of a request, 32 bytes: path, query and credential, as `access.viewer` reads it.

    Other headers and cookies do not influence the response.
    """
    request, cookie = HTTPConnection(scope), scope["app"].state.services.settings.cookie
    parts = [scope["path"].encode(), scope["query_string"]]
    for credential in (request.headers.get("authorization"), request.cookies.get(cookie)):
        parts.append(b"-" if credential is None else b"+" + credential.encode("utf-8", "surrogatepass"))
    digest = hashlib.sha256()
    for part in parts:
        digest.update(b"%d:" % len(part) + part)
    return digest.digest()
