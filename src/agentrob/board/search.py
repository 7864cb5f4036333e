"""Full-text search, newest first: words in any language, Chinese of one character or more.

On SQLite it stands on an FTS5 table. Its tokenizer splits text at what is no letter, so a run of Chinese, Japanese or
Korean would be one long word; such runs are therefore written as overlapping pairs (`机器人` as `机器 器人 人`), and a
search for them as a phrase of pairs. The characters by themselves stand in a column of their own. On other databases
posts are looked through for the words (`ILIKE`): right, but not quick.
"""

from __future__ import annotations

import re
import time
import unicodedata
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeVar

from sqlalchemy import Connection, and_, bindparam, select, text

from agentrob.board import schema as db
from agentrob.board.reader import Reader, from_cursor, to_cursor
from agentrob.board.records import Page, Post
from agentrob.board.render import unmarked
from agentrob.errors import BoardError

T = TypeVar("T")
#: Characters and words of a query that count.
MAX_QUERY, MAX_WORDS = 200, 12
#: Seconds after which a search is given up: some words stand in so many posts that none has them all.
MOST_S = 1.0
#: Steps of SQLite's machine between two looks at the clock.
STEPS = 20_000
_PAIRED = re.compile(r"[\u3005-\u3007\u3040-\u30ff\u3400-\u4dbf\u4e00-\u9fff\uac00-\ud7af\uf900-\ufaff]+")
_CREATE = (
    "CREATE VIRTUAL TABLE post_words USING fts5(words, chars, tokenize = 'porter unicode61 remove_diacritics 2')",
    # Whoever erases a post erases its words, without having to know of this table.
    "CREATE TRIGGER post_words_erased AFTER UPDATE OF raw ON posts WHEN new.raw = '' "
    "BEGIN DELETE FROM post_words WHERE rowid = new.id; END",
)
_BATCH = 1000


# -------------------------------------------------------------------- the index
def create_index(connection: Connection) -> None:
    """Make the index of all posts there are; nothing where the database has no FTS5."""
    if connection.dialect.name != "sqlite":
        return
    for statement in _CREATE:
        connection.execute(text(statement))
    after = 0
    query = (
        "SELECT p.id, p.raw, t.title, (SELECT min(id) FROM posts WHERE topic_id = t.id) AS first FROM posts p "
        "JOIN topics t ON t.id = p.topic_id WHERE p.id > :after ORDER BY p.id LIMIT :most"
    )
    while rows := connection.execute(text(query), {"after": after, "most": _BATCH}).all():
        for row in rows:
            add(connection, row.id, row.raw, row.title if row.id == row.first else "")
        after = rows[-1].id


def drop_index(connection: Connection) -> None:
    if connection.dialect.name == "sqlite":
        connection.execute(text("DROP TRIGGER post_words_erased"))
        connection.execute(text("DROP TABLE post_words"))


def add(connection: Connection, post_id: int, raw: str, title: str = "") -> None:
    """A new post; the first one of a topic is found by the title too."""
    if connection.dialect.name == "sqlite":
        words, chars = indexed(f"{title}\n{raw}" if title else raw)
        values = {"id": post_id, "words": words, "chars": chars}
        connection.execute(text("INSERT INTO post_words (rowid, words, chars) VALUES (:id, :words, :chars)"), values)


def change(connection: Connection, post_id: int, raw: str, title: str = "") -> None:
    """An edited post."""
    if connection.dialect.name == "sqlite":
        connection.execute(text("DELETE FROM post_words WHERE rowid = :id"), {"id": post_id})
        add(connection, post_id, raw, title)


def indexed(words: str) -> tuple[str, str]:
    """A text as it is given to the index: its words, and its Chinese, Japanese and Korean characters."""
    plain = unicodedata.normalize("NFKC", words)
    chars = dict.fromkeys("".join(_PAIRED.findall(plain)))
    return _PAIRED.sub(lambda run: f" {' '.join(_pairs(run[0]))} ", plain), " ".join(chars)


def _pairs(run: str) -> Iterator[str]:
    """Each character with the next one; the last alone, so that a word that goes on in letters (`走2`) is found."""
    return (run[n : n + 2] for n in range(len(run)))


# -------------------------------------------------------------------- searching
def finder(connection: Connection, sees: Callable[[], frozenset[str]] | None = None) -> Reader:
    """A reader to search with, on a connection of its own."""
    if connection.dialect.name == "postgresql":
        connection.execute(text(f"SET statement_timeout = {MOST_S * 1000:.0f}"))
    return Reader(connection, sees, keeps=True)


def bounded(reader: Reader, read: Callable[..., T], *asked: Any) -> T:
    """What `read` gives for what is asked, or 503 when it takes longer than `MOST_S`."""
    with _given_up(reader):
        return read(reader, *asked)


@contextmanager
def _given_up(reader: Reader) -> Iterator[None]:
    """Ends a statement that takes longer than `MOST_S`: 503 with what to do."""
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


@dataclass(frozen=True, slots=True)
class Where:
    """What is searched: posts before `before`, on these boards, in topics with the tag when there is one."""

    before: int
    boards: Sequence[str]
    tag: str | None


def find(
    reader: Reader,
    query: str,
    cursor: str | None = None,
    limit: int = 20,
    board_id: str | None = None,
    tag: str | None = None,
) -> Page[Post]:
    """Posts with all the words, of one board or of all, of topics with a tag, newest first, without removed ones and
    those on boards that are not seen.

    A query without any word finds nothing. Raises `BoardError` 422, 503.
    """
    words = terms(query)
    if not words:
        return Page(())
    seen = reader.seen()
    boards = [b.id for b in reader.all_boards()] if seen is None else sorted(seen)
    boards = [board for board in boards if board_id in (None, board)]
    where = Where(from_cursor(cursor) if cursor else 2**62, boards, tag)
    search = _by_index if reader.connection.dialect.name == "sqlite" else _by_looking
    ids = search(reader, words, where, limit + 1)
    found = {int(post.id): post for post in reader.posts_by_id(ids[:limit])}
    posts = tuple(found[i] for i in ids[:limit] if i in found)
    return Page(posts, to_cursor(ids[limit - 1]) if len(ids) > limit else None)


def terms(query: str) -> list[str]:
    """The words of a query; what stands between double quotes is one."""
    plain = unicodedata.normalize("NFKC", query.replace("\0", ""))[:MAX_QUERY]
    found = (quoted or word for quoted, word in re.findall(r'"([^"]*)"|([^\s"]+)', plain))
    return [word for word in found if any(c.isalnum() for c in word)][:MAX_WORDS]


def expression(words: Sequence[str]) -> str:
    """The words in FTS5's language: each a phrase."""
    return " AND ".join(_phrase(word) for word in words)


def _phrase(word: str) -> str:
    if len(word) == 1 and _PAIRED.fullmatch(word):
        return f'chars : "{word}"'
    # In a mixed word (`go2机器人`) a run may go on after what is searched for: its last character is left to its pair.
    mixed = _PAIRED.sub(lambda run: f" {' '.join(p for p in _pairs(run[0]) if len(p) == 2 or len(run[0]) == 1)} ", word)
    return f'words : "{mixed.strip()}"'


def _by_index(reader: Reader, words: Sequence[str], where: Where, most: int) -> list[int]:
    tagged = (
        "AND EXISTS (SELECT 1 FROM topic_tags g WHERE g.topic_id = t.id AND g.tag = :tag) "
        if where.tag is not None
        else ""
    )
    statement = text(
        "SELECT w.rowid AS id FROM post_words w CROSS JOIN posts p ON p.id = w.rowid "
        "CROSS JOIN topics t ON t.id = p.topic_id WHERE w.post_words MATCH :wanted AND w.rowid < :before "
        f"AND NOT p.removed AND t.board_id IN :boards {tagged}ORDER BY w.rowid DESC LIMIT :most"
    ).bindparams(bindparam("boards", expanding=True))
    values: dict[str, Any] = {"wanted": expression(words), "before": where.before, "boards": list(where.boards)}
    values |= {"most": most} | ({"tag": where.tag} if where.tag is not None else {})
    return [row.id for row in reader.rows(statement, **values)]


def _by_looking(reader: Reader, words: Sequence[str], where: Where, most: int) -> list[int]:
    p, t, g = db.posts.c, db.topics.c, db.topic_tags.c
    has = (p.raw.icontains(word, autoescape=True) | t.title.icontains(word, autoescape=True) for word in words)
    shown = and_(p.id < where.before, p.removed.is_(False), t.board_id.in_(where.boards), *has)
    statement = select(p.id).join(db.topics, t.id == p.topic_id).where(shown).order_by(p.id.desc()).limit(most)
    if where.tag is not None:
        statement = statement.where(t.id.in_(select(g.topic_id).where(g.tag == where.tag)))
    return [row.id for row in reader.rows(statement)]


# -------------------------------------------------------------------- showing
def around(raw: str, query: str, length: int = 200) -> tuple[tuple[str, bool], ...]:
    """The part of a text where it is found, in pieces; the second of each says whether it is a word looked for."""
    words = sorted(terms(query), key=len, reverse=True)
    if not words:
        return ((unmarked(raw[:length]), False),)
    pattern = re.compile("|".join(re.escape(w.strip("@")) or re.escape(w) for w in words), re.IGNORECASE)
    # Of a long post only the part where it is found: pages are made on the event loop, which a stop needs too.
    found = pattern.search(raw)
    begin = max(0, found.start() - length) if found else 0
    plain = unmarked(raw[begin : begin + 3 * length])
    first = pattern.search(plain)
    start = max(0, (first.start() if first else 0) - length // 3)
    shown = plain[start : start + length]
    pieces, done = [("…", False)] if begin or start else [], 0
    for match in pattern.finditer(shown):
        pieces += [(shown[done : match.start()], False), (match[0], True)]
        done = match.end()
    pieces += [(shown[done:], False)] + (
        [("…", False)] if start + length < len(plain) or begin + 3 * length < len(raw) else []
    )
    return tuple(piece for piece in pieces if piece[0])


def checked(query: str) -> str:
    """What somebody searches for; 422 when it is too long."""
    if len(query) > MAX_QUERY:
        raise BoardError(422, "long_query", "that is too much to search for", f"at most {MAX_QUERY} characters")
    return query.strip()
