"""The embeddings of posts: stored in the database, and held in memory for comparison.

A worker embeds all existing posts once, oldest first, then follows the events, which include those written by other
processes. It only asks the writer to store finished embeddings, so that posting never waits for it.
"""

from __future__ import annotations

import asyncio
import re
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import structlog
from numpy.typing import NDArray
from sqlalchemy import Column, Integer, LargeBinary, MetaData, Row, String, Table, delete, func, insert, select, text

from agentrob.board.db import schema as db
from agentrob.board.db.reader import Reader
from agentrob.board.db.writer import Transaction
from agentrob.errors import BoardError
from agentrob.semantic.encoder import MODEL, SIZE, EncoderError, TextEncoder

log = structlog.get_logger(__name__)
#: The number of characters of a post that are embedded, including its topic's title.
MAX_CHARS = 1500
#: Posts that are checked together, and posts that are encoded together; a search waits for an encoding.
WINDOW, TOGETHER = 500, 16
#: How often the worker checks for events, and when it tries again after a failure.
POLL_S, AGAIN_S = 1.0, 5.0
#: Vectors that are compared together: they fit into the processor's cache, and are too few to use other cores.
_BLOCK = 512
_LINK = re.compile(r"!?\[([^\[\]]{0,200})\]\([^()\s]{0,500}\)")

#: Part of the database, but not of a backup, because it can be rebuilt from the posts.
derived = MetaData(naming_convention=db.metadata.naming_convention)
post_meanings = Table(
    "post_meanings",
    derived,
    Column("post_id", db.Id, primary_key=True, autoincrement=False),
    Column("version", Integer, nullable=False),
    Column("model", String(20), nullable=False),
    Column("vector", LargeBinary, nullable=False),
)
_POSTS = (
    f"SELECT p.id, p.version, p.removed, substr(p.raw, 1, {MAX_CHARS}) AS raw, "
    "m.version AS known, m.model, m.vector, "
    "CASE WHEN p.id = (SELECT min(id) FROM posts WHERE topic_id = p.topic_id) THEN t.title ELSE '' END AS title "
    "FROM posts p JOIN topics t ON t.id = p.topic_id LEFT JOIN post_meanings m ON m.post_id = p.id "
)
_WINDOW = text(_POSTS + "WHERE p.id > :after ORDER BY p.id LIMIT :most")
_ONE = text(_POSTS + "WHERE p.id = :id")


class EmbeddingIndex:
    """The vectors in memory, by ascending id of post. Callers must check which posts are visible."""

    def __init__(self, encoder: TextEncoder) -> None:
        self.encoder = encoder
        self._lock = threading.Lock()
        self._count = 0
        self._ids = np.zeros(1024, np.int64)
        self._versions = np.zeros(1024, np.int32)
        self._lengths = np.ones(1024, np.float32)
        self._vectors = np.zeros((1024, SIZE), np.int8)

    def __len__(self) -> int:
        return self._count

    def put(self, post_id: int, version: int, vector: bytes) -> None:
        """Store the vector of a version of a post; the id must be known, or greater than all known ones."""
        row = np.frombuffer(vector, np.int8)
        with self._lock:
            at = int(np.searchsorted(self._ids[: self._count], post_id))
            if at == self._count:
                self._grow()
                self._count += 1
            self._ids[at], self._versions[at], self._vectors[at] = post_id, version, row
            self._lengths[at] = max(1.0, float(np.linalg.norm(row.astype(np.float32))))

    def _grow(self) -> None:
        """Make room for one more, in new arrays, so that a running comparison keeps the old ones."""
        if self._count == len(self._ids):
            more = self._count // 2
            self._ids = np.concatenate([self._ids, np.zeros(more, np.int64)])
            self._versions = np.concatenate([self._versions, np.zeros(more, np.int32)])
            self._lengths = np.concatenate([self._lengths, np.ones(more, np.float32)])
            self._vectors = np.concatenate([self._vectors, np.zeros((more, SIZE), np.int8)])

    def compared(self, vector: bytes) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float32]]:
        """Return the posts' ids, their known versions, and the similarity of each to the vector (1 is equal)."""
        wanted = np.frombuffer(vector, np.int8).astype(np.float32)
        wanted /= max(1.0, float(np.linalg.norm(wanted)))
        with self._lock:
            count = self._count
            ids, versions = self._ids[:count], self._versions[:count]
            lengths, vectors = self._lengths[:count], self._vectors[:count]
        alike = np.empty(count, np.float32)
        for n in range(0, count, _BLOCK):
            alike[n : n + _BLOCK] = vectors[n : n + _BLOCK].astype(np.float32) @ wanted
        return ids, versions, alike / lengths


@dataclass(frozen=True, slots=True)
class _Kept:
    post_id: int
    version: int
    vector: bytes


class EmbeddingWorker:
    """Keeps the vectors up to date. `reader` is used by the worker alone and sees every board."""

    def __init__(self, encoder: TextEncoder, reader: Reader) -> None:
        self.meanings, self._reader = EmbeddingIndex(encoder), reader
        self._looking = threading.Lock()
        self._seen = 0  # all posts up to this id were checked
        self._event: int | None = None

    def close(self) -> None:
        self.meanings.encoder.close()
        with self._looking:
            self._reader.connection.close()

    async def run(self, do: Any) -> None:
        """Run until cancelled; `do` passes a job to the writer."""
        while True:
            begun = self._event, self._seen
            try:
                rows = await asyncio.to_thread(self._look)
                for some in (rows[n : n + TOGETHER] for n in range(0, len(rows), TOGETHER)):
                    await self._keep(some, do)
                if not rows:
                    await asyncio.sleep(POLL_S)
            except Exception as e:  # the worker must survive any error: the next try may well succeed
                known = isinstance(e, BoardError | EncoderError)
                log.warning("board.meanings_wait", error=str(e), again_s=AGAIN_S, exc_info=None if known else e)
                self._event, self._seen = begun  # check again: the results may not have been stored
                await asyncio.sleep(AGAIN_S)

    def _look(self) -> Sequence[Row[Any]]:
        """Return the next posts that may need a vector: those with new events, then those not checked yet."""
        with self._looking:
            events = db.events.c
            if self._event is None:
                newest = self._reader.first(select(func.max(events.id)))
                self._event = (newest[0] if newest else None) or 0
            newer = select(events.id, events.post_id).where(events.id > self._event).order_by(events.id).limit(WINDOW)
            happened = self._reader.rows(newer)
            if happened:
                self._event = happened[-1].id
            touched = sorted({r.post_id for r in happened if r.post_id is not None and r.post_id <= self._seen})
            if touched:
                return [row for post_id in touched for row in self._reader.rows(_ONE, id=post_id)]
            rows = self._reader.rows(_WINDOW, after=self._seen, most=WINDOW)
            if rows:
                self._seen = rows[-1].id
            return rows

    async def _keep(self, rows: Sequence[Row[Any]], do: Any) -> None:
        lacking = [r for r in rows if _shown(r) and not _known(r)]
        made: list[_Kept] = []
        if lacking:
            vectors = await asyncio.to_thread(self.meanings.encoder.encode, [_said(r) for r in lacking])
            made = [_Kept(r.id, r.version, vector) for r, vector in zip(lacking, vectors, strict=True)]
            await do(lambda t: _write(t, made))
        vectors_of = {kept.post_id: kept.vector for kept in made}
        for row in rows:
            vector = vectors_of.get(row.id, bytes(row.vector) if _shown(row) and _known(row) else bytes(SIZE))
            self.meanings.put(row.id, row.version, vector)


def _shown(row: Row[Any]) -> bool:
    return bool(row.raw) and not row.removed


def _known(row: Row[Any]) -> bool:
    """Return whether the stored vector belongs to this version of the text and to this model."""
    return row.known == row.version and row.model == MODEL and len(row.vector) == SIZE


def _said(row: Row[Any]) -> str:
    return _unmarked(f"{row.title}\n{row.raw}"[:MAX_CHARS])


def _unmarked(raw: str) -> str:
    """Markdown as one line of plain text, without its marks and the URLs of links."""
    bare = _LINK.sub(r"\1", raw)
    bare = re.sub(r"[*`~]+|[\s|:-]{3,}", lambda m: "" if m[0][0] in "*`~" else " " if "---" in m[0] else m[0], bare)
    return " ".join(re.sub(r"[|>#]+", " ", bare).split())


def _write(t: Transaction, made: Sequence[_Kept]) -> None:
    """Store vectors of posts that still have the encoded text; an erased post must leave nothing."""
    p = db.posts.c
    ids = [kept.post_id for kept in made]
    now = {r.id: r.version for r in t.connection.execute(select(p.id, p.version).where(p.id.in_(ids), p.raw != ""))}
    rows = [
        {"post_id": kept.post_id, "version": kept.version, "model": MODEL, "vector": kept.vector}
        for kept in made
        if now.get(kept.post_id) == kept.version
    ]
    t.connection.execute(delete(post_meanings).where(post_meanings.c.post_id.in_(ids)))
    if rows:
        t.connection.execute(insert(post_meanings), rows)
