"""The board on PostgreSQL: the tests that SQLite passes, on a server that is started here; from one to the other."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from postgres_server import open_to_all, postgres_server
from running_board import POSTGRES, database_for, running_board
from sqlalchemy import select
from test_board_backup import fill, told

from agentrob.board import admin, backup, schema
from agentrob.board.database import migrate, open_engine
from agentrob.board.settings import BoardSettings
from agentrob.config_board import BoardConfig
from agentrob.errors import BoardError

pytestmark = pytest.mark.slow
HERE = Path(__file__).parent
SAME = ("posts", "access", "events", "robots", "rights", "limits", "backup", "hot", "tags")


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    with tempfile.TemporaryDirectory(prefix="pg-", dir="/tmp") as made:  # a socket's path must be short
        folder = Path(made)
        open_to_all(folder)
        with postgres_server(folder) as url:
            yield url


@pytest.mark.timeout(300)
def test_the_tests_of_the_board_pass_on_postgresql_too(server: str) -> None:
    files = [str(HERE / f"test_board_{name}.py") for name in SAME]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "not sqlite and not slow", *files]
    done = subprocess.run(
        command, env=os.environ | {POSTGRES: server}, cwd=HERE.parents[1], text=True, capture_output=True, check=False
    )
    assert done.returncode == 0, done.stdout[-6000:]
    assert " passed" in done.stdout


def settings(server: str, folder: Path) -> BoardSettings:
    made = BoardSettings.from_config(BoardConfig(), folder)
    return replace(made, database=database_for(server, folder))


def test_migrations_build_the_same_tables_there_and_lead_back(server: str, tmp_path: Path) -> None:
    there = settings(server, tmp_path)
    migrate(there)
    engine = open_engine(there, writes=False)
    with engine.connect() as connection:
        assert compare_metadata(MigrationContext.configure(connection), schema.metadata) == []
    engine.dispose()
    admin.bootstrap(there)
    admin.create_account(there, "somebody")
    migrate(there, "0001")
    migrate(there)
    assert admin.find_account(there, "somebody").name == "somebody"


def test_who_writes_waits_for_who_writes_so_events_come_in_order(server: str, tmp_path: Path) -> None:
    there = replace(settings(server, tmp_path), busy_timeout_s=0.2)
    admin.bootstrap(there)
    with admin.writing(there), pytest.raises(BoardError, match="busy"):
        admin.create_account(there, "second")
    assert admin.create_account(there, "second").name == "second"
    with backup._snapshot(there) as connection:
        connection.execute(select(schema.accounts)).all()
        assert admin.create_account(there, "meanwhile").name == "meanwhile", "a backup keeps nobody waiting"


def test_a_forum_moves_from_sqlite_to_postgresql_and_back_with_all_it_has(server: str, tmp_path: Path) -> None:
    with running_board(tmp_path / "here", database=f"sqlite:///{tmp_path}/here.sqlite3") as board:
        fill(board)
        before = told(board)
        backup.backup(board.settings, tmp_path / "one")
    there = settings(server, tmp_path / "there")
    backup.restore(there, tmp_path / "one")
    with running_board(tmp_path / "there", database=there.database) as board:
        assert told(board) == before
        assert (
            board.client("op").post("/topics", json={"board": "talk", "title": "t", "body": "new"}).status_code == 201
        )
        backup.backup(board.settings, tmp_path / "two")
    back = replace(BoardSettings.from_config(BoardConfig(), tmp_path / "back"))
    backup.restore(back, tmp_path / "two")
    with running_board(tmp_path / "back", database=back.database) as board:
        after = told(board)
        assert after[1].pop()[1] == "post.created", "the one that was written there"
        assert after == before
