"""A robot's journal on PostgreSQL is lost and taken over: nothing moves twice, and its old holder moves nothing."""

from __future__ import annotations

import asyncio
import os
import socket
import tempfile
import threading
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path
from typing import Any

import psycopg
import pytest
from sqlalchemy import Connection, create_engine, event, make_url, text

from agentrob.agent.store import session_locks
from agentrob.agent.store.journal import Journal
from agentrob.agent.store.journals import PostgresJournals
from agentrob.errors import JournalError, JournalHeld
from agentrob.model import CommandState, EndReason
from tests.agent.store.test_journal import command, says
from tests.board.board_processes import fresh_postgres
from tests.board.db import postgres_server
from tests.board.running_board import database_for

pytestmark = pytest.mark.slow
REX, MAX = "rex", "max"
#: By when another worker holds the robots of one that is gone; by when that one knows.
TAKEN_S, LOST_S = 15.0, 5.0


@pytest.fixture
def url(postgres: str, tmp_path: Path) -> str:
    return database_for(postgres, tmp_path)


@asynccontextmanager
async def worker(url: str, data: Path) -> AsyncIterator[PostgresJournals]:
    journals = PostgresJournals(url, data)
    try:
        yield journals
    finally:
        await journals.close()


async def taken(journals: PostgresJournals, robot: str) -> Journal:
    """Try as a standby does until the robot is free."""
    async with asyncio.timeout(TAKEN_S):
        while True:
            try:
                return await journals.open(robot)
            except JournalHeld:
                await asyncio.sleep(0.1)


def execute(url: str, query: str, **values: Any) -> list[Any]:
    engine = create_engine(url, isolation_level="AUTOCOMMIT")
    try:
        with engine.connect() as db:
            return list(db.execute(text(query), values))
    finally:
        engine.dispose()


def terminate_locks(url: str) -> None:
    """End the connections of this database that hold robots."""
    query = (
        "SELECT pg_terminate_backend(pid) FROM pg_locks "
        "WHERE locktype = 'advisory' AND database = (SELECT oid FROM pg_database WHERE datname = current_database())"
    )
    assert execute(url, query)


def fence_of(journal: Journal) -> int:
    assert journal.fence is not None
    return journal.fence.number


async def test_law_11_of_two_workers_one_gets_the_robot(url: str, tmp_path: Path) -> None:
    async with worker(url, tmp_path / "a") as a, worker(url, tmp_path / "b") as b:
        for _ in range(5):
            results = await asyncio.gather(a.open(REX), b.open(REX), return_exceptions=True)
            (journal,) = [r for r in results if isinstance(r, Journal)]
            (refused,) = [r for r in results if not isinstance(r, Journal)]
            assert isinstance(refused, JournalHeld), refused
            await journal.close()
        journal, other = await a.open(REX), await b.open(MAX)
        assert journal.fence is not None
        assert other.fence is not None
        assert journal.fence.store == other.fence.store, "they are of the same database"
        with pytest.raises(JournalHeld, match="already runs"):
            await a.open(REX)
        await journal.close()
        await other.close()


async def test_workers_that_start_at_once_create_the_tables_once(url: str, tmp_path: Path) -> None:
    workers = [PostgresJournals(url, tmp_path) for _ in range(5)]
    journals = await asyncio.gather(*(w.open(f"robot-{n}") for n, w in enumerate(workers)))
    assert len({journal.fence.store for journal in journals if journal.fence}) == 1
    for journal, each in zip(journals, workers, strict=True):
        await journal.close()
        await each.close()


async def test_law_6_a_robot_whose_holder_was_cut_off_is_taken_and_the_old_holder_begins_nothing(
    url: str, tmp_path: Path
) -> None:
    async with worker(url, tmp_path / "a") as a, worker(url, tmp_path / "b") as b:
        old, sibling = await a.open(REX), await a.open(MAX)
        await old.claim(command("1"))
        begun, go_on = asyncio.Event(), asyncio.Event()

        async def moving() -> str:
            begun.set()
            await go_on.wait()
            return "moved"

        motion = asyncio.create_task(old.move("1", moving))
        await begun.wait()
        cut_s = time.monotonic()
        terminate_locks(url)
        new = await taken(b, REX)
        assert time.monotonic() - cut_s < TAKEN_S
        assert fence_of(new) > fence_of(old)
        # The old holder may not know yet. It can neither begin, nor claim, nor end.
        for call in (
            old.move("2", says("moved")),
            old.claim(command("2")),
            old.end(["1"], EndReason.STOP),
            old.finish("1", CommandState.INTERRUPTED),
            old.put("cursor", "0"),
        ):
            with pytest.raises(JournalHeld):
                await call
        go_on.set()
        with pytest.raises(JournalHeld):
            await motion
        for journal in (old, sibling):
            await asyncio.wait_for(journal.until_lost(), LOST_S - (time.monotonic() - cut_s))
        # What had begun is interrupted, and nothing else was begun.
        assert await new.move("1", says("again")) == CommandState.INTERRUPTED
        assert await new.move("2", says("moved")) == "moved"
        assert [claim.command.post_id for claim in await new.open_claims()] == ["1"]
        # The same process can take back what nobody took.
        again = await taken(a, MAX)
        assert fence_of(again) > fence_of(sibling)
        for journal in (old, sibling, again, new):
            await journal.close()


async def test_law_6_a_lost_journal_begins_nothing_although_nobody_has_taken_the_robot(
    url: str, tmp_path: Path
) -> None:
    async with worker(url, tmp_path) as a:
        journal = await a.open(REX)
        begun, go_on = asyncio.Event(), asyncio.Event()

        async def moving() -> str:
            begun.set()
            await go_on.wait()
            return "moved"

        motion = asyncio.create_task(journal.move("1", moving))
        await begun.wait()
        terminate_locks(url)
        await asyncio.wait_for(journal.until_lost(), LOST_S)
        with pytest.raises(JournalHeld, match="lost"):
            await journal.move("2", says("moved"))
        with pytest.raises(JournalHeld, match="lost"):
            await journal.claim(command("2"))
        go_on.set()
        assert await motion == "moved", "what ended is told truly as long as nobody else holds the robot"
        assert await journal.motion_result("1") == "moved"
        await journal.close()


async def test_a_holder_whose_process_hangs_loses_its_robots(
    url: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(session_locks, "BEAT_S", 3600.0)  # as if it hung
    async with worker(url, tmp_path / "a") as a, worker(url, tmp_path / "b") as b:
        old = await a.open(REX)
        silent_s = time.monotonic()
        new = await taken(b, REX)
        assert time.monotonic() - silent_s < TAKEN_S
        with pytest.raises(JournalHeld):
            await old.move("1", says("moved"))
        for journal in (old, new):
            await journal.close()


class SilentProxy:
    """A socket of the server's whose other end falls silent, and keeps its connections open, once `silent` is set."""

    def __init__(self, url: str, folder: Path) -> None:
        self._to, self._here = (Path(str(p)) / ".s.PGSQL.5432" for p in (make_url(url).query["host"], folder))
        self.url = make_url(url).set(query={"host": str(folder)}).render_as_string(hide_password=False)
        self.silent = asyncio.Event()

    async def __aenter__(self) -> SilentProxy:
        self._server = await asyncio.start_unix_server(self._join, self._here)
        return self

    async def __aexit__(self, *_: object) -> None:
        self._server.close()

    async def _join(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        there, thither = await asyncio.open_unix_connection(self._to)
        async with asyncio.TaskGroup() as group:
            group.create_task(self._pass_on(reader, thither))
            group.create_task(self._pass_on(there, writer))

    async def _pass_on(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while data := await reader.read(4096):
            if self.silent.is_set():
                await asyncio.Event().wait()
            writer.write(data)
        writer.close()


async def test_law_6_a_network_that_falls_silent_costs_the_holder_its_robots_before_another_has_them(
    url: str, tmp_path: Path
) -> None:
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:  # socket paths must be short
        async with SilentProxy(url, Path(folder)) as proxy, worker(url, tmp_path / "b") as b:
            a = PostgresJournals(proxy.url, tmp_path / "a")
            old = await a.open(REX)
            silent_s = time.monotonic()
            proxy.silent.set()
            taking = asyncio.create_task(taken(b, REX))
            await asyncio.wait_for(old.until_lost(), LOST_S)
            assert not taking.done(), "the old holder knows before there is a new one"
            new = await taking
            assert time.monotonic() - silent_s < TAKEN_S
            with pytest.raises(JournalHeld, match="lost"):
                await old.move("1", says("moved"))
            assert await new.move("1", says("moved")) == "moved"
            await new.close()
            await a.close()


# -------------------------------------------------------------------- the server is started again
class Server:
    """A PostgreSQL server that can be started again."""

    def __init__(self, url: str) -> None:
        self.url = url
        self._user = "nobody" if os.getuid() == 0 else None  # as `postgres_server` started it
        self._control = [postgres_server.tool("pg_ctl"), "-D", str(make_url(url).query["host"]), "-w", "-t", "60"]

    def restart(self, how: str) -> None:
        self.stop(how)
        self.start()

    def stop(self, how: str) -> None:
        postgres_server.run(self._user, [*self._control, "-m", how, "stop"])

    def start(self) -> None:
        data = make_url(self.url).query["host"]
        flags = f"{postgres_server.FLAGS} -c unix_socket_directories={data}"
        postgres_server.run(self._user, [*self._control, "-l", f"{data}/log", "-o", flags, "start"])


@pytest.fixture
def server() -> Iterator[Server]:
    with fresh_postgres() as url:
        yield Server(url)


@pytest.mark.parametrize("how", ["fast", "immediate"])
async def test_law_6_the_server_is_started_again_between_begin_and_end(
    server: Server, tmp_path: Path, how: str
) -> None:
    async with worker(server.url, tmp_path) as a:
        journal = await a.open(REX)
        await journal.claim(command("1"))

        async def moving() -> str:
            await asyncio.to_thread(server.stop, how)
            starting = asyncio.get_running_loop().run_in_executor(None, server.start)
            background.append(starting)
            return "moved"

        background: list[asyncio.Future[None]] = []
        assert await journal.move("1", moving) == "moved", "its end is written once the server is back"
        await asyncio.wait_for(journal.until_lost(), LOST_S)
        await journal.close()
        await background[0]
        journal = await taken(a, REX)
        assert await journal.motion_result("1") == "moved"
        assert await journal.move("1", says("again")) == "moved"
        await journal.close()


async def test_a_server_that_stays_away_is_an_error(
    server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agentrob.agent.store.transactions.RETRY_S", 0.5)
    async with worker(server.url, tmp_path) as a:
        journal = await a.open(REX)
        await asyncio.to_thread(server.stop, "fast")
        with pytest.raises(JournalError):
            await journal.move("1", says("moved"))
        with pytest.raises(JournalError):
            await journal.claimed("1")
        await asyncio.wait_for(journal.until_lost(), LOST_S)
        with pytest.raises(JournalError):
            await a.open(REX)
        await asyncio.to_thread(server.start)
        await journal.close()
        journal = await taken(a, REX)
        assert await journal.move("1", says("moved")) == "moved"
        await journal.close()


# -------------------------------------------------------------------- a commit whose answer is lost
def writes(connection: Connection) -> bool:
    return connection.get_execution_options().get("isolation_level") != "AUTOCOMMIT"


def cut(connection: Connection) -> None:
    with socket.socket(fileno=os.dup(connection.connection.driver_connection.fileno())) as link:  # type: ignore[union-attr]
        link.shutdown(socket.SHUT_RDWR)


@contextmanager
def commit_answer_lost(journals: PostgresJournals, committed: bool) -> Iterator[Callable[[], int]]:
    """Break the connection in the next commit: before it reaches the server, or after, when its answer is lost."""
    engine, broken = journals._engine, 0

    def breaks(connection: Connection) -> None:
        nonlocal broken
        if broken or not writes(connection):
            return
        broken += 1
        if committed:
            connection.connection.commit()
            connection.connection.cursor().execute("SELECT 1")  # so that the commit to come needs an answer, too
        cut(connection)

    event.listen(engine, "commit", breaks)
    try:
        yield lambda: broken
    finally:
        event.remove(engine, "commit", breaks)


@pytest.mark.parametrize("committed", [True, False], ids=["answer lost", "commit lost"])
async def test_law_6_a_motion_whose_commit_was_not_answered_begins_once(
    url: str, tmp_path: Path, committed: bool
) -> None:
    async with worker(url, tmp_path) as a:
        journal = await a.open(REX)
        moved: list[str] = []

        async def moving() -> str:
            moved.append("moved")
            return "moved"

        with commit_answer_lost(a, committed) as broken:
            claim = await journal.claim(command("1"))
        assert broken()
        assert claim.new, "it was claimed by this call"
        with commit_answer_lost(a, committed) as broken:
            assert await journal.move("1", moving) == "moved"
        assert broken()
        with commit_answer_lost(a, committed) as broken:
            assert not await journal.cancel("1")
            assert await journal.cancel("2"), "this call cancelled it"
        assert moved == ["moved"]
        assert await journal.move("1", moving) == "moved"
        assert moved == ["moved"]
        await journal.close()


async def test_law_6_a_commit_that_is_still_under_way_is_waited_for(url: str, tmp_path: Path) -> None:
    """The connection breaks, and the server still commits: the next try must not take it for not committed."""
    async with worker(url, tmp_path) as a:
        journal = await a.open(REX)
        zombie = psycopg.connect(make_url(url).set(drivername="postgresql").render_as_string(hide_password=False))
        late: list[threading.Timer] = []

        def breaks(connection: Connection) -> None:
            if late or not writes(connection):
                return
            mark = connection.execute(text("SELECT written FROM holder")).scalar_one()
            cut(connection)
            # Another connection stands for the old one's server process.
            zombie.execute("UPDATE holder SET written = %s", (mark,))
            zombie.execute("INSERT INTO motion (robot, post, state, at) VALUES (%s, '1', 'begun', 0)", (REX,))
            late.append(threading.Timer(0.5, zombie.commit))
            late[0].start()

        event.listen(a._engine, "commit", breaks)
        moved: list[str] = []

        async def moving() -> str:
            moved.append("moved")
            return "moved"

        assert await journal.move("1", moving) == "moved", "its own row is not taken for an earlier one"
        assert moved == ["moved"]
        assert late
        zombie.close()
        await journal.close()


async def test_a_pool_serves_many_robots(url: str, tmp_path: Path) -> None:
    async with worker(url, tmp_path) as a:
        journals = await asyncio.gather(*(a.open(f"robot-{n}") for n in range(40)))
        before = threading.active_count()
        moved = [journal.move(str(n), says("moved")) for n in range(5) for journal in journals]
        assert await asyncio.gather(*moved) == ["moved"] * 200
        assert threading.active_count() - before <= 8
        others = "WHERE datname = current_database() AND pid <> pg_backend_pid()"
        assert execute(url, f"SELECT count(*) FROM pg_stat_activity {others}")[0][0] <= 8 + 1
        for journal in journals:
            await journal.close()
