"""A board reads cached accounts, tokens, boards and rights again after every change, by whatever process."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy import event, text

from agentrob.board.admin import local_admin
from agentrob.board.auth import accounts, rights
from agentrob.board.content.store import Store
from agentrob.board.settings import BoardSettings
from agentrob.config.board import BoardConfig
from agentrob.model import Role
from tests.board.board_processes import fresh_postgres
from tests.board.running_board import database_for


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.slow)])
def there(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[BoardSettings]:
    made = BoardSettings.from_config(BoardConfig(), tmp_path)
    if request.param == "sqlite":
        local_admin.bootstrap(made)
        yield made
        return
    with fresh_postgres() as server:
        made = replace(made, database=database_for(server, tmp_path))
        local_admin.bootstrap(made)
        yield made


async def next_request() -> None:
    """Whether something has changed is asked once in each run of the event loop."""
    await asyncio.sleep(0)


async def test_every_change_by_another_process_is_seen_at_once(there: BoardSettings) -> None:
    ada = local_admin.create_account(there, "ada")
    store = Store(there)
    try:
        with local_admin.writing(there) as connection:
            token, session = accounts.new_token(connection, ada), accounts.new_session(connection, int(ada.id))
        seen = accounts.by_token(store.reader, token)
        assert seen is not None
        assert seen.role is Role.MEMBER
        assert accounts.by_session(store.reader, session) == seen
        boards = store.everything.all_boards()
        assert rights.settings_of(store.everything, "ada").owner == ""
        changes = {
            "a role": f"UPDATE accounts SET role = 'operator' WHERE id = {ada.id}",
            "a board": f"UPDATE boards SET name = 'Renamed' WHERE id = '{boards[0].id}'",
            "rights": "INSERT INTO robots (account_id, owner_id, rights, camera_role, camera_days, closed) VALUES "
            f'({ada.id}, {ada.id}, \'{{"command": {{}}, "approve": "admin", "release": "owner", "approval": []}}\','
            " 'guest', 7, '[]')",
        }
        for change in changes.values():
            with local_admin.writing(there) as connection:
                connection.execute(text(change))
        await next_request()
        found = accounts.by_token(store.reader, token)
        assert found is not None
        assert found.role is Role.OPERATOR
        assert store.everything.all_boards()[0].name == "Renamed"
        assert rights.settings_of(store.everything, "ada").owner == "ada"
        with local_admin.writing(there) as connection:
            accounts.revoke_tokens(connection, ada)
            accounts.end_sessions(connection, ada)
        await next_request()
        assert accounts.by_token(store.reader, token) is None
        assert accounts.by_session(store.reader, session) is None
        with local_admin.writing(there) as connection:
            again = accounts.new_token(connection, ada)
        await next_request()
        assert accounts.by_token(store.reader, again) is not None
    finally:
        store.close()


async def test_what_did_not_change_is_read_once(there: BoardSettings) -> None:
    ada = local_admin.create_account(there, "ada")
    store = Store(there)
    statements: list[str] = []
    try:
        with local_admin.writing(there) as connection:
            token = accounts.new_token(connection, ada)
        for _ in range(2):
            assert accounts.by_token(store.reader, token) is not None
        event.listen(store.reader.connection.engine, "before_cursor_execute", lambda *told: statements.append(told[2]))
        for _ in range(10):
            await next_request()
            assert accounts.by_token(store.reader, token) is not None
            assert store.everything.all_boards()
        assert len(statements) <= 1  # the boards
    finally:
        store.close()
