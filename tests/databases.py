"""Fixtures for tests that run on SQLite and on PostgreSQL: `database` is for the journals of agents."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

#: The URL of a PostgreSQL server for the journals of agents; if not set, they are SQLite files.
JOURNAL_SERVER = "AGENTROB_TEST_JOURNAL"
#: Parameters of a fixture that gives a test one database after the other.
BOTH = ("sqlite", pytest.param("postgresql", marks=pytest.mark.slow))


@pytest.fixture(scope="session")
def postgres() -> Iterator[str]:
    """Return the URL of a PostgreSQL server for the whole run."""
    from tests.board.board_processes import fresh_postgres

    with fresh_postgres() as url:
        yield url


@pytest.fixture(params=BOTH)
def database(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Keep the journals of this test in this database, and return its name."""
    if request.param == "postgresql":
        monkeypatch.setenv(JOURNAL_SERVER, request.getfixturevalue("postgres"))
        # The processes of a test may be busy for longer than a worker's.
        for name in ("ANSWER_S", "SILENT_S"):
            monkeypatch.setattr(f"agentrob.agent.store.session_locks.{name}", 60)
    else:
        monkeypatch.delenv(JOURNAL_SERVER, raising=False)
    return str(request.param)
