"""The store of the embedded forum: synchronous reads on the event loop, writes batched through one thread.

Reads take well under a millisecond and may be called anywhere on the event loop's thread. Writes are awaited; each
runs in a savepoint of its own, and records an event in the same transaction. All methods raise `BoardError` with an
HTTP status: 404 for a missing object, 503 when the database is unavailable.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from functools import partial
from pathlib import Path
from typing import Any, Literal

from sqlalchemy.exc import DBAPIError

from agentrob.board.auth import visibility
from agentrob.board.content import writes
from agentrob.board.content.renderer import Renderer
from agentrob.board.db.database import open_engine, unavailable
from agentrob.board.db.read_cache import ReadCache
from agentrob.board.db.reader import Reader
from agentrob.board.db.records import Image, StoredEvent, StoredPost, Written, now_us
from agentrob.board.db.writer import Job, T, Writer
from agentrob.board.search import search
from agentrob.board.settings import BoardSettings
from agentrob.errors import BoardError
from agentrob.model import Account, EventKind, Page

SearchMode = Literal["words", "meaning"]
#: The largest number of waiting searches.
MAX_SEARCHES = 20
#: Seconds after which PostgreSQL cancels a read, since the event loop waits for it.
READ_S = 2.0


class Store:
    """One open database, created once per process by `server.create_app`.

    `published` is called on the event loop with the ids of new events, in order, after each commit; other processes
    that serve the same database know this one as `process`. `reader` sees what the current request may see
    (`auth.visibility`); `everything` sees all boards, so its callers must check rights themselves.
    """

    def __init__(
        self, settings: BoardSettings, published: Callable[[list[int]], None] = lambda _: None, process: str = ""
    ) -> None:
        self._limits, self.images_dir = settings.limits, settings.images_dir
        reading = open_engine(settings, writes=False, patience_s=READ_S)
        self._engines = [reading, open_engine(settings, writes=True, process=process)]
        try:
            connection = self._engines[0].connect()
            cache = ReadCache(connection)
            self.reader = Reader(connection, visibility.readable_boards, cache)
            self.everything = Reader(connection, cache=cache)
            self._finder = search.finder(self._engines[0].connect(), visibility.readable_boards)
        except DBAPIError as e:
            raise unavailable(e) from e
        self._pending_searches, self._search_thread = 0, ThreadPoolExecutor(1, "board-search")
        self._embedding_worker = None
        if settings.encoder is not None:
            from agentrob.board.search.embeddings import EmbeddingWorker  # numpy, for those who want it

            self._embedding_worker = EmbeddingWorker(settings.encoder(), Reader(self._engines[0].connect()))
        self.writer = Writer(self._engines[1], published)
        self.renderer = Renderer(self.everything.names)

    def close(self) -> None:
        """Finish pending writes and close the database."""
        if self._embedding_worker is not None:
            self._embedding_worker.close()
        self.writer.close()
        self.renderer.close()
        self._search_thread.shutdown(cancel_futures=True)
        for reader in (self._finder, self.reader):
            reader.connection.close()
        for engine in self._engines:
            engine.dispose()

    # ---------------------------------------------------------------- reads, synchronous
    def image(self, image_id: str) -> Image:
        return self.reader.image(image_id)[0]

    def events(self, after: str, limit: int = 100, topic_id: str | None = None) -> tuple[StoredEvent, ...]:
        """The events after an event, oldest first. 404 if this history has no event `after`."""
        return self.reader.events(self.reader.known_event(after), limit, topic_id)

    # ---------------------------------------------------------------- search, awaited
    @property
    def search_modes(self) -> tuple[SearchMode, ...]:
        return ("words",) if self._embedding_worker is None else ("words", "meaning")

    async def search(
        self,
        query: str,
        cursor: str | None = None,
        limit: int = 20,
        board_id: str | None = None,
        mode: SearchMode = "words",
        tag: str | None = None,
    ) -> Page[StoredPost]:
        """Posts with all the words, newest first, or by similar meaning, most similar first. 404 if this forum has no
        such search, 503 as for `beside`."""
        return await self._aside(self._finder_by(mode), query, cursor, limit, board_id, tag)

    async def beside(self, read: Callable[..., T], *asked: Any) -> T:
        """Run a slow read outside of the event loop. Raises 503 if it takes too long or too many are waiting."""
        return await self._aside(search.bounded, self._finder, read, *asked)

    async def _aside(self, call: Callable[..., T], *asked: Any) -> T:
        """Run on the search thread, one call at a time, so that stops and other requests do not wait (law 15)."""
        if self._pending_searches >= MAX_SEARCHES:
            raise BoardError(503, "overloaded", "too many searches are waiting", "try again in a moment", 2.0)
        self._pending_searches += 1
        try:
            seeing = copy_context().run  # keeps the readable boards of the request
            running = self._search_thread.submit(seeing, call, *asked)
            return await asyncio.wrap_future(running)
        finally:
            self._pending_searches -= 1

    def _finder_by(self, mode: SearchMode) -> Callable[..., Page[StoredPost]]:
        if mode == "words":
            return partial(search.find, self._finder)
        if self._embedding_worker is None:
            hint = "search for words; its owner may install agentrob[semantic] and set board.semantic = true"
            raise BoardError(404, "no_meaning", "this forum has no search by meaning", hint)
        from agentrob.board.search import semantic

        return partial(semantic.find, self._finder, self._embedding_worker.meanings)

    async def run_embedding_worker(self) -> None:
        """Embed new and edited posts until cancelled, if semantic search is enabled."""
        if self._embedding_worker is not None:
            await self._embedding_worker.run(self.do)

    # ---------------------------------------------------------------- writes, awaited
    async def do(self, job: Job[T]) -> T:
        """Run a job on the writer thread."""
        return await self.writer.do(job)

    async def create_topic(
        self,
        author: Account,
        board_id: str,
        title: str,
        body: str,
        *,
        key: str | None = None,
        images: Sequence[str] = (),
        tags: Sequence[str] = (),
    ) -> Written:
        """`tags` as `tags.checked` gives them."""
        text = await self.renderer.render(body, author)
        draft = writes.Draft(author, text, key, images, limits=self._limits)
        job: Job[Written] = lambda t: writes.create_topic(t, board_id, title, draft, tags)  # noqa: E731
        return await self.writer.do(job, first=text.stop)

    async def reply(
        self,
        author: Account,
        topic_id: str,
        body: str,
        *,
        key: str | None = None,
        reply_to: str | None = None,
        images: Sequence[str] = (),
        card: Mapping[str, Any] | None = None,
    ) -> Written:
        text = await self.renderer.render(body, author)
        draft = writes.Draft(author, text, key, images, reply_to, card, self._limits)
        return await self.writer.do(lambda t: writes.reply(t, topic_id, draft), first=text.stop)

    async def edit(
        self,
        editor: Account,
        post_id: str,
        body: str,
        *,
        key: str | None = None,
        images: Sequence[str] = (),
        card: Mapping[str, Any] | Literal["keep"] | None = "keep",
    ) -> StoredPost:
        """Replace the text; images given are added; the card stays unless given. Only the author may (403)."""
        text, most = await self.renderer.render(body, editor), self._limits.posts
        job: Job[StoredPost] = lambda t: writes.edit(t, editor, post_id, text, key, images, card, most)  # noqa: E731
        return await self.writer.do(job, first=text.stop)

    async def remove(self, by: Account, post_id: str, reason: str = "") -> StoredPost:
        """Hide a post, as its author or a moderator (else 403). Repeating it does nothing."""
        return await self.do(lambda t: writes.remove(t, by, post_id, reason))

    async def record(
        self, kind: EventKind, robot: str, by: Account | None, *, key: str | None = None, at_us: int | None = None
    ) -> StoredEvent:
        """Record an event of a robot, such as a stop. Its time is that of the call, however long writing takes."""
        happened_us = now_us() if at_us is None else at_us
        job: Job[StoredEvent] = lambda t: writes.record(t, kind, robot, by, key, happened_us)  # noqa: E731
        return await self.writer.do(job, first=kind is EventKind.ROBOT_STOP)

    async def add_image(
        self, by: Account, file: Path, image: Image, key: str | None = None
    ) -> tuple[Image, bool] | None:
        """Register a picture; False if the key was used before, with the earlier picture. None if its file is
        missing."""
        return await self.do(lambda t: writes.add_image(t, by, file, image, key, self._limits.uploads))
