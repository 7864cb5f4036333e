"""Database failures: locked, full, of another version, served twice; and how the writer handles a batch."""

from __future__ import annotations

import shutil
import signal
import sqlite3
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import httpx2
import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import text

from agentrob.board import server
from agentrob.board.admin import local_admin
from agentrob.board.db import schema
from agentrob.board.db.database import migrate, open_engine
from agentrob.board.db.writer import Transaction
from agentrob.board.search import embeddings
from agentrob.board.settings import BoardSettings
from agentrob.config.board import BoardConfig
from agentrob.errors import BoardError
from agentrob.model import AccountKind, Role
from tests.board.running_board import LIMIT_S, RunningBoard, running_board

TOPIC = {"board_id": "talk", "title": "t", "body": "b"}


@pytest.fixture
def settings(tmp_path: Path) -> BoardSettings:
    made = BoardSettings.from_config(BoardConfig(listen="127.0.0.1:0"), tmp_path)
    return replace(made, busy_timeout_s=0.05)


def test_a_locked_database_is_503_and_loses_nothing(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board(busy_timeout_s=0.05)
    op = board.client("op")
    path = board.settings.database_path
    with closing(sqlite3.connect(str(path), isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        refused = op.post("/topics", json=TOPIC, headers={"Idempotency-Key": "k"})
        assert (refused.status_code, refused.json()["code"]) == (503, "busy")
        assert refused.headers["content-type"] == "application/problem+json"
        assert int(refused.headers["retry-after"]) >= 1
        assert op.get("/boards").status_code == 200
        other.execute("ROLLBACK")
    assert op.post("/topics", json=TOPIC, headers={"Idempotency-Key": "k"}).status_code == 201
    assert len(op.get("/boards/talk/topics").json()["items"]) == 1


def test_a_stop_gets_through_while_the_database_is_locked(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board(busy_timeout_s=0.6)
    op = board.client("op")
    topic = op.post("/topics", json=TOPIC).json()
    newest = op.get("/changes").json()["now"]["id"]
    with closing(sqlite3.connect(str(board.settings.database_path), isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        with board.client("quadruped").stream("GET", "/events") as response:
            lines = response.iter_lines()
            next(lines)
            pressed = op.post("/robots/quadruped/stop")
            assert (pressed.status_code, pressed.json()["kind"]) == (200, "robot.stop")
            told = [next(line for line in lines if line.startswith(start)) for start in ("event: robot", "id")]
            assert told[0] == "event: robot.stop"
            assert told[1] == f"id: {newest}", "resuming after it misses nothing"
        other.execute("ROLLBACK")
    assert topic["created"]


def test_a_full_disk_is_503_and_the_server_goes_on(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board()
    op = board.client("op")
    made = op.post("/topics", json=TOPIC).json()

    def pages(limit: int) -> Callable[[Transaction], None]:
        return lambda t: t.connection.execute(text(f"PRAGMA max_page_count={limit}")) and None

    # SQLite's own limit acts like a full disk; 1 stands for "no more pages than there are".
    board.run(board.services.store.do(pages(1)))
    big = TOPIC | {"body": "x" * 60_000}
    answers = [op.post("/topics", json=big) for _ in range(3)]
    assert {(a.status_code, a.json()["code"]) for a in answers} == {(503, "storage_full")}
    assert op.get(f"/topics/{made['topic']['id']}").json() == made["topic"]
    board.run(board.services.store.do(pages(1_000_000)))
    assert op.post("/topics", json=big).status_code == 201
    assert len(op.get("/boards/talk/topics").json()["items"]) == 2


def test_a_failed_job_rolls_back_only_itself(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board()
    op = board.client("op")
    topic = op.post("/topics", json=TOPIC).json()["topic"]["id"]
    hold, held = threading.Event(), threading.Event()

    def block(_: Transaction) -> None:
        held.set()
        hold.wait(LIMIT_S)

    def reply(n: int) -> int:
        body = {"body": str(n)} | ({"reply_to": "999"} if n % 2 else {})
        return board.client("op").post(f"/topics/{topic}/posts", json=body).status_code

    # While one job occupies the writer, the others gather into one batch.
    with ThreadPoolExecutor(11) as pool:
        blocked = pool.submit(board.run, board.services.store.do(block))
        assert held.wait(LIMIT_S)
        answers = [pool.submit(reply, n) for n in range(10)]
        hold.set()
        assert sorted(a.result() for a in answers) == [201] * 5 + [404] * 5
        blocked.result()
    assert op.get(f"/topics/{topic}").json()["posts"] == 6
    kinds = [e["kind"] for e in op.get("/changes", params={"after": "0"}).json()["items"]]
    assert kinds == ["post.created"] * 6


def test_writes_survive_a_restart(tmp_path: Path) -> None:
    with running_board(tmp_path) as first:
        made = first.client("op").post("/topics", json=TOPIC).json()
    settings = BoardSettings.from_config(BoardConfig(), tmp_path)
    with closing(sqlite3.connect(str(settings.database_path))) as database:
        assert database.execute("PRAGMA integrity_check").fetchone() == ("ok",)
        assert database.execute("SELECT count(*) FROM posts").fetchone() == (1,)
    assert made["created"]


@pytest.mark.parametrize("more", [0, 1, 2, 5])
def test_a_reader_ahead_of_a_restored_backup_is_told_even_after_newer_events(tmp_path: Path, more: int) -> None:
    def now(op: httpx2.Client) -> str:
        return str(op.get("/changes").json()["now"]["id"])

    with running_board(tmp_path) as first:
        op, path = first.client("op"), first.settings.database_path
        topic = op.post("/topics", json=TOPIC).json()["topic"]["id"]
        before = now(op)
        with closing(sqlite3.connect(str(path))) as running, closing(sqlite3.connect(tmp_path / "copy")) as copy:
            running.backup(copy)
        for n in range(2):
            op.post(f"/topics/{topic}/posts", json={"body": f"undone {n}"})
        undone = now(op)
    shutil.copy(tmp_path / "copy", str(path))  # the server that ended left no write-ahead log
    with running_board(tmp_path) as second:
        op = second.client("op")
        for n in range(more):
            op.post(f"/topics/{topic}/posts", json={"body": f"anew {n}"})
        answers = [op.get(f"/{way}", params={"after": undone}) for way in ("changes", "events")]
        assert [(a.status_code, a.json()["code"]) for a in answers] == [(404, "no_such_event")] * 2
        items = op.get("/changes", params={"after": before}).json()["items"]
        assert [e["post"]["raw"] for e in items] == [f"anew {n}" for n in range(more)]


# -------------------------------------------------------------------- migrations and administration
def test_migrations_build_exactly_the_tables_of_the_schema(settings: BoardSettings) -> None:
    migrate(settings)
    engine = open_engine(settings, writes=False)
    with engine.connect() as connection:
        found = compare_metadata(MigrationContext.configure(connection), [schema.metadata, embeddings.derived])
    # The full-text index is a virtual table of SQLite, which SQLAlchemy cannot describe.
    tables = {d[1].name for d in found if isinstance(d, tuple) and d[0] == "remove_table"}
    assert len(tables) == len(found)
    assert all(name.startswith("post_words") for name in tables)
    engine.dispose()


def test_bootstrap_is_idempotent_and_thread_safe(settings: BoardSettings) -> None:
    patient = replace(settings, busy_timeout_s=LIMIT_S)
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda _: local_admin.bootstrap(patient), range(4)))
    engine = open_engine(settings, writes=False)
    with engine.connect() as connection:
        assert connection.execute(text("SELECT id FROM boards ORDER BY position")).scalars().all() == ["robots", "talk"]
    engine.dispose()


def test_accounts_can_be_changed_while_the_server_runs(board: RunningBoard) -> None:
    made = local_admin.create_account(
        board.settings, "Watcher", kind=AccountKind.MONITORING_AGENT, display_name="Watch dog"
    )
    assert (made.name, made.kind, made.display_name) == ("watcher", AccountKind.MONITORING_AGENT, "Watch dog")
    local_admin.change_account(board.settings, made, role=Role.OPERATOR)
    seen = board.client("op").get("/accounts/watcher").json()
    assert (seen["role"], seen["display_name"]) == ("operator", "Watch dog")
    with pytest.raises(BoardError, match="no account 'nobody'"):
        local_admin.find_account(board.settings, "nobody")


@pytest.mark.parametrize("password", ["short", "x" * 201])
def test_an_invalid_password_creates_no_account(settings: BoardSettings, password: str) -> None:
    local_admin.bootstrap(settings)
    with pytest.raises(BoardError) as caught:
        local_admin.create_account(settings, "somebody", password=password)
    assert caught.value.code == "bad_password"
    with pytest.raises(BoardError):
        local_admin.find_account(settings, "somebody")


def test_an_error_creating_the_database_names_its_path(settings: BoardSettings, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    bad = replace(settings, database=f"sqlite:///{tmp_path}/file/board.sqlite3")
    with pytest.raises(BoardError, match=r"file"):
        local_admin.bootstrap(bad)


def test_a_file_that_is_not_a_database_is_one_clear_error(settings: BoardSettings, tmp_path: Path) -> None:
    (tmp_path / "x.sqlite3").write_text("this is not a database, but long enough to look at" * 100)
    with pytest.raises(BoardError, match="not a database"):
        local_admin.bootstrap(replace(settings, database=f"sqlite:///{tmp_path}/x.sqlite3"))


# -------------------------------------------------------------------- the process
def test_a_taken_port_is_one_clear_error(board: RunningBoard, settings: BoardSettings) -> None:
    taken = replace(settings, port=board.settings.port)
    with pytest.raises(BoardError, match=f"cannot listen on 127.0.0.1:{board.settings.port}") as caught:
        server.serve(taken)
    assert "\n" not in str(caught.value)


SERVE = """
import sys
from pathlib import Path
from agentrob.board import server
from agentrob.board.settings import BoardSettings
from agentrob.config.board import BoardConfig
settings = BoardSettings.from_config(BoardConfig(listen="127.0.0.1:0"), Path(sys.argv[1]))
server.serve(settings, lambda s: print("ready", s.base_url, flush=True))
"""


@pytest.mark.parametrize("signal_name", ["SIGINT", "SIGTERM"])
def test_a_second_server_on_the_same_data_is_refused_and_the_first_ends_cleanly(
    settings: BoardSettings, tmp_path: Path, signal_name: str
) -> None:
    command = [sys.executable, "-c", SERVE, str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as first:
        assert first.stdout is not None
        assert next(line for line in first.stdout if line.startswith("ready"))
        with pytest.raises(BoardError) as caught:
            server.serve(settings)
        assert caught.value.code == "already_served"
        assert "PostgreSQL only" in str(caught.value)
        first.send_signal(getattr(signal, signal_name))
        assert first.wait(LIMIT_S) == 0
