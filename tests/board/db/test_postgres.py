"""The board on PostgreSQL: it passes the tests of the board on SQLite, and a forum moves between the two."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import select, text

from agentrob.board.admin import backup, local_admin
from agentrob.board.db import schema
from agentrob.board.db.database import migrate, open_engine
from agentrob.board.search import embeddings, search
from agentrob.board.settings import BoardSettings
from agentrob.config.board import BoardConfig
from agentrob.errors import BoardError
from tests.board.admin.test_backup import contents, fill
from tests.board.board_processes import fresh_postgres
from tests.board.running_board import POSTGRES, database_for, running_board

pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[3]
BOARD = (
    "api/test_posts", "test_access", "events/test_streams", "robots/test_robots", "auth/test_rights",
    "auth/test_limits", "admin/test_backup", "test_response_cache", "content/test_tags", "admin/test_retention",
)  # fmt: skip
SEARCH = ("search/test_semantic", "web/test_search")


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    with fresh_postgres() as url:
        yield url


@pytest.mark.timeout(600)
@pytest.mark.parametrize("names", [BOARD, SEARCH], ids=["board", "search"])
def test_the_boards_tests_pass_on_postgresql(server: str, names: tuple[str, ...]) -> None:
    files = [f"tests/board/{name}.py" for name in names]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "not sqlite and not slow", *files]
    done = subprocess.run(
        command, env=os.environ | {POSTGRES: server}, cwd=ROOT, text=True, capture_output=True, check=False
    )
    assert done.returncode == 0, done.stdout[-6000:]
    assert " passed" in done.stdout


def settings(server: str, folder: Path) -> BoardSettings:
    made = BoardSettings.from_config(BoardConfig(), folder)
    return replace(made, database=database_for(server, folder))


def test_migrations_on_postgresql_build_the_same_tables_and_can_be_undone(server: str, tmp_path: Path) -> None:
    there = settings(server, tmp_path)
    migrate(there)
    engine = open_engine(there, writes=False)
    with engine.connect() as connection:
        found = compare_metadata(MigrationContext.configure(connection), [schema.metadata, embeddings.derived])
        # The full-text index is an expression index, a feature of PostgreSQL.
        assert [d[1].name for d in found if d[0] != "remove_index"] == ["post_words"]
        assert {d[1].table.name for d in found if d[0] == "remove_index"} <= {"post_words"}
    engine.dispose()
    local_admin.bootstrap(there)
    local_admin.create_account(there, "somebody")
    migrate(there, "0001")
    migrate(there)
    assert local_admin.find_account(there, "somebody").name == "somebody"


def test_a_slow_search_is_aborted(server: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    there = settings(server, tmp_path)
    local_admin.bootstrap(there)
    monkeypatch.setattr(search, "MOST_S", 0.05)
    engine = open_engine(there, writes=False)
    with engine.connect() as connection:
        reader = search.finder(connection)
        with pytest.raises(BoardError) as refused, search.given_up(reader):
            reader.rows(text("SELECT pg_sleep(60)"))
        assert (refused.value.status, refused.value.code) == (503, "too_broad")
        assert search.find(reader, "anything").items == ()
    engine.dispose()


def test_writes_are_serialised_so_events_stay_in_order(server: str, tmp_path: Path) -> None:
    there = replace(settings(server, tmp_path), busy_timeout_s=0.2)
    local_admin.bootstrap(there)
    with local_admin.writing(there), pytest.raises(BoardError, match="busy"):
        local_admin.create_account(there, "second")
    assert local_admin.create_account(there, "second").name == "second"
    with backup._snapshot(there) as connection:
        connection.execute(select(schema.accounts)).all()
        assert local_admin.create_account(there, "meanwhile").name == "meanwhile", "a backup keeps nobody waiting"


def test_a_forum_moves_between_sqlite_and_postgresql_without_loss(server: str, tmp_path: Path) -> None:
    with running_board(tmp_path / "here", database=f"sqlite:///{tmp_path}/here.sqlite3") as board:
        fill(board)
        before = contents(board)
        backup.backup(board.settings, tmp_path / "one")
    there = settings(server, tmp_path / "there")
    backup.restore(there, tmp_path / "one")
    with running_board(tmp_path / "there", database=there.database) as board:
        assert contents(board) == before
        assert (
            board.client("op").post("/topics", json={"board_id": "talk", "title": "t", "body": "new"}).status_code
            == 201
        )
        backup.backup(board.settings, tmp_path / "two")
    back = replace(BoardSettings.from_config(BoardConfig(), tmp_path / "back"))
    backup.restore(back, tmp_path / "two")
    with running_board(tmp_path / "back", database=back.database) as board:
        after = contents(board)
        assert after[1].pop()[1] == "post.created", "the one that was written there"
        assert after == before
