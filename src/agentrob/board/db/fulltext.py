"""The full-text index of posts: FTS5 on SQLite, the same tokens under a GIN index on PostgreSQL.

FTS5's tokenizer splits text at non-letters, so a run of Chinese, Japanese or Korean would be one long word. Such runs
are indexed as overlapping pairs (`机器人` as `机器 器人 人`) and searched as a phrase of pairs; single characters are
indexed separately. PostgreSQL stores the tokens that FTS5 produces (in memory), so that both databases find the same
posts: as a `tsvector`, and in order as a line of text for phrases, because positions in a `tsvector` end at 16,383,
and at 256 per word.
"""

from __future__ import annotations

import re
import sqlite3
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, String, TextClause, bindparam, text

from agentrob.language.complexity import nfkc

_PAIRED = re.compile(r"[\u3005-\u3007\u3040-\u30ff\u3400-\u4dbf\u4e00-\u9fff\uac00-\ud7af\uf900-\ufaff]+")
_FTS5 = "USING fts5(words, chars, tokenize = 'porter unicode61 remove_diacritics 2'"
#: A trigger, so that code that erases a post need not know this table.
_CREATE = {
    "sqlite": (
        f"CREATE VIRTUAL TABLE post_words {_FTS5})",
        "CREATE TRIGGER post_words_erased AFTER UPDATE OF raw ON posts WHEN new.raw = '' "
        "BEGIN DELETE FROM post_words WHERE rowid = new.id; END",
    ),
    "postgresql": (
        "CREATE TABLE post_words (post_id bigint PRIMARY KEY, tokens tsvector NOT NULL, words text NOT NULL)",
        "CREATE FUNCTION post_words_erased() RETURNS trigger LANGUAGE plpgsql AS "
        "$$ BEGIN DELETE FROM post_words WHERE post_id = NEW.id; RETURN NULL; END $$",
        "CREATE TRIGGER post_words_erased AFTER UPDATE OF raw ON posts "
        "FOR EACH ROW WHEN (NEW.raw = '') EXECUTE FUNCTION post_words_erased()",
    ),
}
#: The databases with a full-text index.
INDEXED = frozenset(_CREATE)
#: Created after all posts have their words. Without `fastupdate`, because every search would scan its pending list.
_COMPLETE = {
    "postgresql": (
        "CREATE INDEX ix_post_words_tokens ON post_words USING gin (tokens) WITH (fastupdate = off)",
        "ANALYZE post_words",
    )
}
_DROP = {
    "sqlite": ("DROP TRIGGER post_words_erased", "DROP TABLE post_words"),
    "postgresql": (
        "DROP TRIGGER post_words_erased ON posts",
        "DROP FUNCTION post_words_erased()",
        "DROP TABLE post_words",
    ),
}
_ADD = {
    "sqlite": text("INSERT INTO post_words (rowid, words, chars) VALUES (:id, :words, :chars)"),
    "postgresql": text(
        "INSERT INTO post_words (post_id, tokens, words) "
        "VALUES (:id, array_to_tsvector(CAST(:tokens AS text[])), :words)"
    ),
}
_FORGET = {
    "sqlite": text("DELETE FROM post_words WHERE rowid = :id"),
    "postgresql": text("DELETE FROM post_words WHERE post_id = :id"),
}
_ALL_POSTS = text(
    "SELECT p.id, p.raw, t.title, (SELECT min(id) FROM posts WHERE topic_id = t.id) AS first FROM posts p "
    "JOIN topics t ON t.id = p.topic_id WHERE p.id > :after AND p.raw <> '' ORDER BY p.id LIMIT :most"
)
_BATCH = 1000
#: Characters of a token that count on PostgreSQL, whose index takes none of more than 2 kB.
_LONGEST = 100
_VISIBLE = "NOT p.removed AND t.board_id IN :boards"
TAGGED = "AND EXISTS (SELECT 1 FROM topic_tags g WHERE g.topic_id = t.id AND g.tag = :tag) "
_FIND_SQLITE = (
    "SELECT w.rowid AS id FROM post_words w CROSS JOIN posts p ON p.id = w.rowid "
    "CROSS JOIN topics t ON t.id = p.topic_id WHERE w.post_words MATCH :wanted AND w.rowid < :before "
    f"AND {_VISIBLE} {{tagged}}ORDER BY w.rowid DESC LIMIT :most"
)


@dataclass(frozen=True, slots=True)
class Where:
    """The scope of a search: posts before `before`, on these boards, in topics with this tag if one is given."""

    before: int
    boards: Sequence[str]
    tag: str | None = None


# -------------------------------------------------------------------- maintenance
def create_index(connection: Connection) -> None:
    """Create the index and fill it from all posts; do nothing on a database other than these two."""
    dialect = connection.dialect.name
    if dialect in _CREATE:
        _execute(connection, _CREATE[dialect])
        fill_index(connection)
        _execute(connection, _COMPLETE.get(dialect, ()))


def fill_index(connection: Connection) -> None:
    """Add the words of all posts to an empty index."""
    after, dialect = 0, connection.dialect.name
    if dialect not in INDEXED:
        return
    while rows := connection.execute(_ALL_POSTS, {"after": after, "most": _BATCH}).all():
        found = [_row(dialect, r.id, *indexed(r.raw), r.title if r.id == r.first else "") for r in rows]
        connection.execute(_ADD[dialect], found)
        after = rows[-1].id


def drop_index(connection: Connection) -> None:
    _execute(connection, _DROP.get(connection.dialect.name, ()))


def _execute(connection: Connection, statements: Sequence[str]) -> None:
    for statement in statements:
        connection.execute(text(statement))


def add(connection: Connection, post_id: int, words: str, chars: str, title: str = "") -> None:
    """Index a new post, with the output of `indexed`; the first post of a topic is also found by its title."""
    if (statement := _ADD.get(connection.dialect.name)) is not None:
        connection.execute(statement, _row(connection.dialect.name, post_id, words, chars, title))


def change(connection: Connection, post_id: int, words: str, chars: str, title: str = "") -> None:
    """Index an edited post."""
    if (forget := _FORGET.get(connection.dialect.name)) is not None:
        connection.execute(forget, {"id": post_id})
        add(connection, post_id, words, chars, title)


def _row(dialect: str, post_id: int, words: str, chars: str, title: str) -> dict[str, Any]:
    if title:
        title_words, title_chars = indexed(title)
        words, chars = f"{title_words}\n{words}", f"{title_chars} {chars}"
    if dialect == "sqlite":
        return {"id": post_id, "words": words, "chars": chars}
    tokens = _tokens.of(words)
    return {"id": post_id, "tokens": list({*tokens, *_tokens.of(chars)}), "words": f" {' '.join(tokens)} "}


def indexed(words: str) -> tuple[str, str]:
    """Return the parts of a text for the index: its words, and its Chinese, Japanese and Korean characters."""
    plain = nfkc(words)
    chars = dict.fromkeys("".join(_PAIRED.findall(plain)))
    return _PAIRED.sub(lambda run: f" {' '.join(_pairs(run[0]))} ", plain), " ".join(chars)


def _pairs(run: str) -> Iterator[str]:
    """Return each character with the next one, and the last one alone, so that a word like `走2` is found."""
    return (run[n : n + 2] for n in range(len(run)))


class _Tokens:
    """Tokenizes texts like SQLite's index, with a table of one row in memory."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._memory: sqlite3.Connection | None = None

    def of(self, words: str) -> list[str]:
        """Return the tokens in order; long ones are cut."""
        with self._lock:
            memory = self._memory = self._memory or self._open()
            memory.execute("INSERT INTO one (rowid, words) VALUES (1, ?)", (words.replace("\0", " "),))
            found = memory.execute("SELECT term FROM tokens ORDER BY offset").fetchall()
            memory.execute("INSERT INTO one (one) VALUES ('delete-all')")
        return [term[:_LONGEST] for (term,) in found]

    @staticmethod
    def _open() -> sqlite3.Connection:
        memory = sqlite3.connect(":memory:", check_same_thread=False, isolation_level=None)
        memory.execute(f"CREATE VIRTUAL TABLE one {_FTS5}, content = '')")
        memory.execute("CREATE VIRTUAL TABLE tokens USING fts5vocab(one, 'instance')")
        return memory


_tokens = _Tokens()


# -------------------------------------------------------------------- queries
def index_query(
    dialect: str, words: Sequence[str], where: Where, most: int
) -> tuple[TextClause, dict[str, Any]] | None:
    """Return the statement that finds the posts with all the words, newest first, and its values; None without
    words."""
    boards = bindparam("boards", expanding=True, type_=String)
    tagged = "" if where.tag is None else TAGGED
    values: dict[str, Any] = {"before": where.before, "boards": list(where.boards), "most": most}
    values |= {} if where.tag is None else {"tag": where.tag}
    if dialect == "sqlite":
        found = text(_FIND_SQLITE.format(tagged=tagged)).bindparams(boards)
        return found, {"wanted": expression(words), **values}
    tokens: dict[str, None] = {}
    together: dict[str, str] = {}
    for n, (term, continues) in enumerate(map(_split, words)):
        *ended, last = _tokens.of(term) or [""]
        tokens |= dict.fromkeys(f"'{token}'" for token in ended)
        tokens |= {f"'{last}'{':*' if continues else ''}": None} if last else {}
        if ended:
            together[f"phrase{n}"] = f" {' '.join([*ended, last])}{'' if continues else ' '}"
    if not tokens:
        return None
    has = "".join(f"AND strpos(w.words, :{name}) > 0 " for name in together)
    statement = text(
        "SELECT w.post_id AS id FROM post_words w JOIN posts p ON p.id = w.post_id "
        "JOIN topics t ON t.id = p.topic_id WHERE w.tokens @@ CAST(:wanted AS tsquery) "
        f"{has}AND w.post_id < :before AND {_VISIBLE} {tagged}ORDER BY w.post_id DESC LIMIT :most"
    ).bindparams(boards)
    return statement, {"wanted": " & ".join(tokens), **values, **together}


def expression(words: Sequence[str]) -> str:
    """Return the words as an FTS5 expression, each as a phrase."""
    return " AND ".join(map(_phrase, words))


def _phrase(word: str) -> str:
    if len(word) == 1 and _PAIRED.fullmatch(word):
        return f'chars : "{word}"'
    term, continues = _split(word)
    return f'words : "{term}"{" *" if continues else ""}'


def _split(word: str) -> tuple[str, bool]:
    """Return a word of a query as indexed, and whether its last token may be a prefix.

    A run of characters at the end may continue in the post, so its last character is only matched as part of a pair.
    """

    def pairs(run: re.Match[str]) -> str:
        found = list(_pairs(run[0]))
        return f" {' '.join(found[:-1] if run.end() == len(word) and len(found) > 1 else found)} "

    continues = len(word) > 1 and bool(_PAIRED.match(word[-1])) and not _PAIRED.match(word[-2])
    return _PAIRED.sub(pairs, word).strip(), continues
