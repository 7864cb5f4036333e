"""Render posts before they are written, so that neither the event loop nor the writer thread parses user text.

Parsing a long text would delay everybody's stops (law 15). Short plain texts, and so every stop, are rendered at once.
All others go to a render process, one at a time per account; robots have a process of their own. A text that exceeds
the limits is shown as plain text.
"""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Callable, Collection, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

from agentrob.board.content.markdown import as_plain_text
from agentrob.board.content.render_process import RenderProcess
from agentrob.board.content.rendered import Rendered, Text
from agentrob.board.db.fulltext import indexed
from agentrob.errors import BoardError
from agentrob.language.complexity import parsing_us
from agentrob.model import Account, AccountKind
from agentrob.process.answering.server import TooSlow

T = TypeVar("T")
#: The estimated microseconds of parsing, and the characters, up to which a text is rendered at once.
AT_ONCE_US, AT_ONCE_CHARS = 3_000, 2_000
#: Above this estimate a text is shown as plain text. Prose of 64 KiB is estimated at a quarter of it.
MOST_US = 1_500_000
#: The largest number of different mentions in a text; each is looked up.
MAX_NAMES = 100
#: The number of waiting texts of one account, and of accounts with waiting texts.
MAX_OF_ONE, MAX_ACCOUNTS = 4, 64
#: Seconds that a text waits for its turn.
PATIENCE_S = 10.0


class Renderer:
    """`accounts` returns which of some names are accounts; it is called on the event loop."""

    def __init__(self, accounts: Callable[[Collection[str]], Collection[str]]) -> None:
        self._accounts = accounts
        self._people, self._robots = _Lane("board-render"), _Lane("board-render-robots")

    async def render(self, raw: str, by: Account) -> Rendered:
        """429 if too many texts of the account wait, 503 if too many wait in all, 422 if the text has too many
        mentions."""
        if len(raw) <= AT_ONCE_CHARS and parsing_us(raw, AT_ONCE_US) <= AT_ONCE_US:
            text = Text(raw)
            return text.rendered(self._known(text.names))
        lane = self._robots if by.kind is AccountKind.ROBOT_AGENT else self._people
        return await lane.of(by.id, raw, self._known)

    def close(self) -> None:
        for lane in (self._people, self._robots):
            lane.close()

    def _known(self, names: Collection[str]) -> Collection[str]:
        if len(names) > MAX_NAMES:
            what = f"the text has {len(names)} different names after an @"
            raise BoardError(422, "too_many_names", what, f"at most {MAX_NAMES}")
        return self._accounts(names) if names else ()


class _Lane:
    """A render process and its queue: first come, first served, but one text of each account at a time."""

    def __init__(self, name: str) -> None:
        self._process, self._thread = RenderProcess(), ThreadPoolExecutor(1, name)
        self._turn = asyncio.Semaphore(1)
        self._waiting: Counter[str] = Counter()
        self._first: dict[str, asyncio.Lock] = {}

    def close(self) -> None:
        self._process.close()
        self._thread.shutdown(cancel_futures=True)

    async def of(self, account: str, raw: str, known: Callable[[Collection[str]], Collection[str]]) -> Rendered:
        if self._waiting[account] >= MAX_OF_ONE:
            what = "earlier texts of this account are still being rendered"
            raise BoardError(429, "too_many_texts", what, "wait for them; a short stop is always taken", 1.0)
        if len(self._waiting) > MAX_ACCOUNTS:
            raise _overloaded()
        self._waiting[account] += 1
        try:
            async with self._first.setdefault(account, asyncio.Lock()):
                return await self._in_turn(raw, known)
        finally:
            self._waiting[account] -= 1
            if not self._waiting[account]:
                del self._waiting[account], self._first[account]

    async def _in_turn(self, raw: str, known: Callable[[Collection[str]], Collection[str]]) -> Rendered:
        try:
            async with asyncio.timeout(PATIENCE_S):
                await self._turn.acquire()
        except TimeoutError:
            raise _overloaded() from None
        # The caller may be cancelled meanwhile; the process still answers, and the next caller must not read that
        # answer.
        working = asyncio.ensure_future(self._work(raw, known))
        working.add_done_callback(self._next)
        return await asyncio.shield(working)

    def _next(self, done: asyncio.Future[Rendered]) -> None:
        self._turn.release()
        if not done.cancelled():
            done.exception()  # retrieved, so that asyncio does not log it

    async def _work(self, raw: str, known: Callable[[Collection[str]], Collection[str]]) -> Rendered:
        if parsing_us(raw, MOST_US) > MOST_US:
            return await self._aside(_as_typed, raw)
        try:
            names = await self._aside(self._process.names_in, raw)
            try:
                accounts: Iterable[str] = known(names)
            except BoardError:
                await self._aside(self._process.made, ())
                raise
            made = await self._aside(self._process.made, accounts)
        except TooSlow:
            return await self._aside(_as_typed, raw)
        return Rendered(**made | {"mentions": tuple(made["mentions"])})

    async def _aside(self, call: Callable[..., T], *asked: Any) -> T:
        return await asyncio.wrap_future(self._thread.submit(call, *asked))


def _as_typed(raw: str) -> Rendered:
    return Rendered(raw, as_plain_text(raw), (), *indexed(raw))


def _overloaded() -> BoardError:
    return BoardError(503, "overloaded", "too many texts are waiting to be rendered", "try again in a moment", 2.0)
