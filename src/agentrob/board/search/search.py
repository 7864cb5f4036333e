"""Full-text search, newest first, for words in any language, including single Chinese characters.

It uses the index of `fulltext` on SQLite and PostgreSQL. Other databases are scanned, which is correct but slow.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

from sqlalchemy import Connection, and_, select, text

from agentrob.board.db import schema as db
from agentrob.board.db.cursors import from_cursor, to_cursor
from agentrob.board.db.fulltext import INDEXED, Where, index_query
from agentrob.board.db.read_cache import ReadCache
from agentrob.board.db.reader import Reader
from agentrob.board.db.records import StoredPost
from agentrob.errors import BoardError
from agentrob.language.complexity import nfkc
from agentrob.model import Page

T = TypeVar("T")
#: The largest number of characters and words of a query.
MAX_QUERY, MAX_WORDS = 200, 12
#: Seconds after which a search is cancelled, as for words that are in very many posts.
MOST_S = 1.0
#: Instructions of SQLite's virtual machine between two checks of the clock.
STEPS = 20_000


# -------------------------------------------------------------------- searching
def finder(connection: Connection, sees: Callable[[], frozenset[str]] | None = None) -> Reader:
    """A reader to search with, on a connection of its own."""
    if connection.dialect.name == "postgresql":
        # A generic plan would scan all posts for a rare word, or sort half of them for a common one.
        for setting in (f"statement_timeout = {MOST_S * 1000:.0f}", "plan_cache_mode = force_custom_plan", "jit = off"):
            connection.execute(text(f"SET {setting}"))
    return Reader(connection, sees, ReadCache(connection))


def bounded(reader: Reader, read: Callable[..., T], *asked: Any) -> T:
    """The result of `read`, or 503 if it takes longer than `MOST_S`."""
    with given_up(reader):
        return read(reader, *asked)


@contextmanager
def given_up(reader: Reader) -> Iterator[None]:
    """Cancel a statement that takes longer than `MOST_S`, with a 503."""
    end_s = time.monotonic() + MOST_S
    raw: Any = reader.connection.connection.dbapi_connection
    watched = reader.connection.dialect.name == "sqlite"
    if watched:
        raw.set_progress_handler(lambda: time.monotonic() > end_s, STEPS)
    try:
        yield
    except BoardError as e:
        if e.status != 503 or time.monotonic() < end_s:
            raise
        hint = "add a rarer word, or put words that stand together between double quotes"
        raise BoardError(503, "too_broad", "too many posts had to be looked through", hint) from e
    finally:
        if watched:
            raw.set_progress_handler(None, 0)


def find(
    reader: Reader,
    query: str,
    cursor: str | None = None,
    limit: int = 20,
    board_id: str | None = None,
    tag: str | None = None,
) -> Page[StoredPost]:
    """Visible posts with all the words, of one board or of all, of topics with a tag, newest first.

    A query without a word finds nothing. Raises `BoardError` 422, 503.
    """
    words = terms(query)
    if not words:
        return Page(())
    with given_up(reader):
        where = Where(from_cursor(cursor) if cursor else 2**62, boards_seen(reader, board_id), tag)
        ids = _find(reader, words, where, limit + 1)
    return Page(in_order(reader, ids[:limit]), to_cursor(ids[limit - 1]) if len(ids) > limit else None)


def boards_seen(reader: Reader, board_id: str | None) -> list[str]:
    """The boards to search: one, or all that the viewer may see."""
    seen = reader.seen()
    boards = [b.id for b in reader.all_boards()] if seen is None else sorted(seen)
    return [board for board in boards if board_id in (None, board)]


def in_order(reader: Reader, ids: Sequence[int]) -> tuple[StoredPost, ...]:
    """The posts in the order in which they were found."""
    found = {int(post.id): post for post in reader.posts_by_id(ids)}
    return tuple(found[i] for i in ids if i in found)


def terms(query: str) -> list[str]:
    """The words of a query; a phrase in double quotes counts as one."""
    plain = nfkc(query.replace("\0", ""))[:MAX_QUERY]
    found = (quoted or word for quoted, word in re.findall(r'"([^"]*)"|([^\s"]+)', plain))
    return [word for word in found if any(c.isalnum() for c in word)][:MAX_WORDS]


def _find(reader: Reader, words: Sequence[str], where: Where, most: int) -> list[int]:
    dialect = reader.connection.dialect.name
    if dialect not in INDEXED:
        return _by_looking(reader, words, where, most)
    asked = index_query(dialect, words, where, most)
    return [row.id for row in reader.rows(asked[0], **asked[1])] if asked else []


def _by_looking(reader: Reader, words: Sequence[str], where: Where, most: int) -> list[int]:
    p, t, g = db.posts.c, db.topics.c, db.topic_tags.c
    has = (p.raw.icontains(word, autoescape=True) | t.title.icontains(word, autoescape=True) for word in words)
    shown = and_(p.id < where.before, p.removed.is_(False), t.board_id.in_(where.boards), *has)
    statement = select(p.id).join(db.topics, t.id == p.topic_id).where(shown).order_by(p.id.desc()).limit(most)
    if where.tag is not None:
        statement = statement.where(t.id.in_(select(g.topic_id).where(g.tag == where.tag)))
    return [row.id for row in reader.rows(statement)]


def checked(query: str) -> str:
    """The query without white space around it; 422 if it is too long."""
    if len(query) > MAX_QUERY:
        raise BoardError(422, "long_query", "the query is too long", f"at most {MAX_QUERY} characters")
    return query.strip()
