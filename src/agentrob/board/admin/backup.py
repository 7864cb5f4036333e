"""Back the forum up into one file, restore it (also into another kind of database), and export what people wrote.

A backup is a tar of the tables as JSON lines, the pictures, and a manifest. It is a consistent snapshot; the forum may
continue meanwhile. It holds hashes of passwords and tokens, so only its owner can read it (mode 0600).
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import tarfile
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import IO, Any

from alembic.migration import MigrationContext
from sqlalchemy import Connection, Integer, func, insert, select, text
from sqlalchemy.exc import DBAPIError, IntegrityError

from agentrob import __version__
from agentrob.board.content.images import path_of
from agentrob.board.db import fulltext
from agentrob.board.db import schema as db
from agentrob.board.db.database import migrate, open_engine, unavailable
from agentrob.board.settings import BoardSettings
from agentrob.errors import BoardError

FORMAT = 1
_BATCH = 1000
#: Referenced tables come before those that refer to them; the order by id puts posts before their replies.
_TABLES = [table for table in db.metadata.sorted_tables if table.info != db.FLEETING]


def backup(settings: BoardSettings, target: Path) -> dict[str, int]:
    """Write the whole forum into a new file; return the number of rows of each table. Raises `BoardError`."""
    if target.exists():
        raise BoardError(409, "file_exists", f"{target} exists already", "choose another name")
    with _snapshot(settings) as connection, _new_tar(target) as tar:
        counts = {table.name: _add_table(tar, connection, table) for table in _TABLES}
        pictures = _add_pictures(tar, connection, settings.images_dir)
        manifest = {"format": FORMAT, "version": __version__, "revision": _revision(connection), "tables": counts}
        _add(tar, "manifest.json", json.dumps(manifest | {"pictures": pictures, "at": _now()}, indent=1).encode())
    return counts | {"pictures": pictures}


def restore(settings: BoardSettings, source: Path) -> dict[str, int]:
    """Restore a backup into an empty database, also of another kind; return the number of rows of each table.

    409 if the database has accounts already, 422 if the file is not a backup of a version that this one can read.
    The caller ensures that no process serves the database meanwhile.
    """
    migrate(settings, alone=True)
    engine = open_engine(settings, writes=True)
    try:
        with tarfile.open(source) as tar, engine.begin() as connection:
            if engine.dialect.name == "postgresql":  # reading the pictures may take long
                connection.exec_driver_sql("SET LOCAL idle_in_transaction_session_timeout = 0")
            manifest = _manifest(tar, connection, source)
            _must_be_empty(connection)
            counts = {table.name: _load_table(tar, connection, table) for table in _TABLES}
            if counts != manifest["tables"]:
                raise BoardError(
                    422,
                    "bad_backup",
                    f"{source} is not complete: it has {counts}, its manifest says {manifest['tables']}",
                )
            _go_on_counting(connection)
            fulltext.fill_index(connection)
            counts["pictures"] = _restore_pictures(tar, connection, settings.images_dir)
    except (OSError, EOFError, zlib.error, tarfile.TarError, KeyError, ValueError, IntegrityError) as e:
        raise BoardError(422, "bad_backup", f"{source} cannot be read as a backup: {e}") from e
    except DBAPIError as e:
        raise unavailable(e) from e
    finally:
        engine.dispose()
    return counts


def export(settings: BoardSettings, target: Path, account: str | None = None) -> int:
    """Write all posts, without secrets, as a tar of one JSON file per topic and the pictures; return the number of
    posts.

    With `account` only the posts of that person. Hidden and removed posts are left out.
    """
    if target.exists():
        raise BoardError(409, "file_exists", f"{target} exists already", "choose another name")
    with _snapshot(settings) as connection, _new_tar(target) as tar:
        boards = [dict(r._mapping) for r in connection.execute(select(db.boards).order_by(db.boards.c.position))]
        _add(tar, "boards.json", json.dumps(boards, ensure_ascii=False, indent=1).encode())
        count = 0
        for topic_id, topic in _topics(connection, account):
            count += len(topic["posts"])
            _add(tar, f"topics/{topic_id}.json", json.dumps(topic, ensure_ascii=False, indent=1).encode())
        _add_pictures(tar, connection, settings.images_dir, account, shown=True)
    return count


# -------------------------------------------------------------------- writing
@contextmanager
def _snapshot(settings: BoardSettings) -> Iterator[Connection]:
    """A connection that sees a snapshot of the database."""
    migrate(settings)
    sqlite = settings.database_path is not None
    engine = open_engine(settings, writes=False)
    try:
        with engine.connect() as connection:
            if sqlite:  # in WAL mode, the snapshot is taken by the first read
                connection.exec_driver_sql("BEGIN")
            else:
                connection = connection.execution_options(isolation_level="REPEATABLE READ")  # noqa: PLW2901
            yield connection
    except DBAPIError as e:
        raise unavailable(e) from e
    finally:
        engine.dispose()


@contextmanager
def _new_tar(target: Path) -> Iterator[tarfile.TarFile]:
    """Write to a temporary file, and rename it when it is complete."""
    partial = target.with_name(target.name + ".partial")
    try:
        with os.fdopen(os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
            with tarfile.open(fileobj=file, mode="w:gz", compresslevel=3) as tar:
                yield tar
            file.flush()
            os.fsync(file.fileno())
        partial.rename(target)
    except OSError as e:
        raise BoardError(503, "storage", f"{target} cannot be written: {e.strerror}") from e
    finally:
        partial.unlink(missing_ok=True)


def _add_table(tar: tarfile.TarFile, connection: Connection, table: Any) -> int:
    with tempfile.TemporaryFile() as lines:
        count = 0
        rows = connection.execution_options(stream_results=True).execute(select(table).order_by(*table.primary_key))
        for row in rows.yield_per(_BATCH):
            lines.write(json.dumps(list(row), ensure_ascii=False).encode("utf-8", "surrogatepass") + b"\n")
            count += 1
        _add(tar, f"tables/{table.name}.jsonl", lines)
    return count


def _add_pictures(
    tar: tarfile.TarFile, connection: Connection, folder: Path, account: str | None = None, shown: bool = False
) -> int:
    i, p = db.images.c, db.posts.c
    chosen = select(i.sha256).where(i.gone_us.is_(None)).distinct().order_by(i.sha256)
    if account is not None:
        chosen = chosen.join(db.accounts, db.accounts.c.id == i.account_id).where(db.accounts.c.name == account)
    if shown:
        pi = db.post_images.c
        there = select(pi.image_id).join(db.posts, p.id == pi.post_id).where(p.removed.is_(False))
        chosen = chosen.where(i.id.in_(there))
    count = 0
    for digest in connection.execute(chosen).scalars():
        with suppress(FileNotFoundError):  # it may expire while the backup runs
            tar.add(path_of(folder, digest), f"pictures/{digest}", recursive=False)
            count += 1
    return count


def _topics(connection: Connection, account: str | None) -> Iterator[tuple[int, dict[str, Any]]]:
    t, p, a = db.topics.c, db.posts.c, db.accounts.c
    chosen = select(p.id, p.topic_id, p.raw, p.created_us, p.edited_us, p.reply_to, a.name, t.title, t.board_id)
    chosen = chosen.join(db.topics, t.id == p.topic_id).join(db.accounts, a.id == p.author_id)
    chosen = chosen.where(p.removed.is_(False)).order_by(p.topic_id, p.id)
    if account is not None:
        chosen = chosen.where(a.name == account)
    tags: dict[int, list[str]] = {}
    for row in connection.execute(select(db.topic_tags).order_by(db.topic_tags.c.tag)):
        tags.setdefault(row.topic_id, []).append(row.tag)
    topic: dict[str, Any] = {}
    last = 0
    for row in connection.execution_options(stream_results=True).execute(chosen).yield_per(_BATCH):
        if row.topic_id != last:
            if topic:
                yield last, topic
            last, topic = row.topic_id, {"board": row.board_id, "title": row.title, "posts": []}
            topic["tags"] = tags.get(last, [])
        at, edited = (_time(us) for us in (row.created_us, row.edited_us))
        post = {"id": str(row.id), "author": row.name, "at": at, "edited_at": edited, "text": row.raw}
        topic["posts"].append(post | {"reply_to": str(row.reply_to) if row.reply_to else None})
    if topic:
        yield last, topic


def _add(tar: tarfile.TarFile, name: str, content: bytes | IO[bytes]) -> None:
    info = tarfile.TarInfo(name)
    info.mode = 0o600
    file = io.BytesIO(content) if isinstance(content, bytes) else content
    info.size = file.seek(0, os.SEEK_END)
    file.seek(0)
    tar.addfile(info, file)


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


def _time(us: int | None) -> str | None:
    return datetime.fromtimestamp(us / 1_000_000, UTC).isoformat(timespec="seconds") if us is not None else None


# -------------------------------------------------------------------- reading
def _revision(connection: Connection) -> str:
    return MigrationContext.configure(connection).get_current_revision() or ""


def _manifest(tar: tarfile.TarFile, connection: Connection, source: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(_file(tar, "manifest.json").read())
    if found["format"] != FORMAT or found["revision"] != _revision(connection):
        what = f"{source} is of another version ({found.get('version')}, tables {found.get('revision')})"
        raise BoardError(422, "other_version", what, "restore it with that version, then update AgentRob")
    return found


def _file(tar: tarfile.TarFile, name: str) -> IO[bytes]:
    file = tar.extractfile(name)
    if file is None:
        raise KeyError(f"there is no {name} in it")
    return file


def _must_be_empty(connection: Connection) -> None:
    """409 if there are accounts. Deletes the boards that a new database begins with."""
    if connection.execute(select(func.count()).select_from(db.accounts)).scalar_one():
        raise BoardError(409, "not_empty", "the database has accounts already", "move it away first")
    connection.execute(db.boards.delete())


def _load_table(tar: tarfile.TarFile, connection: Connection, table: Any) -> int:
    names = [c.name for c in table.columns]
    rows: list[dict[str, Any]] = []
    count = 0
    for line in _file(tar, f"tables/{table.name}.jsonl"):
        rows.append(dict(zip(names, json.loads(line), strict=True)))
        if len(rows) == _BATCH:
            connection.execute(insert(table), rows)
            count, rows = count + len(rows), []
    if rows:
        connection.execute(insert(table), rows)
    return count + len(rows)


def _go_on_counting(connection: Connection) -> None:
    """Set PostgreSQL's sequences to continue after the restored ids; SQLite needs no such step."""
    if connection.dialect.name != "postgresql":
        return
    for table in _TABLES:
        key = list(table.primary_key)
        if len(key) == 1 and isinstance(key[0].type, Integer) and key[0].name == "id":
            sequence = f"pg_get_serial_sequence('{table.name}', 'id')"
            newest = f"SELECT setval({sequence}, (SELECT coalesce(max(id), 0) + 1 FROM {table.name}), false)"
            connection.execute(text(newest))


def _restore_pictures(tar: tarfile.TarFile, connection: Connection, folder: Path) -> int:
    """Restore the pictures whose content matches the hash in their names; no name can lead out of the folder."""
    i, count = db.images.c, 0
    for digest in connection.execute(select(i.sha256).where(i.gone_us.is_(None)).distinct()).scalars().all():
        try:
            content = _file(tar, f"pictures/{digest}").read()
        except KeyError:
            continue
        if hashlib.sha256(content).hexdigest() != digest:
            raise ValueError(f"the picture {digest} is damaged")
        path = path_of(folder, digest)
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        path.write_bytes(content)
        count += 1
    return count
