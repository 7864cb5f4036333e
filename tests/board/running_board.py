"""A real board for tests: real sockets, real SQLite, served from a thread of the test process."""

from __future__ import annotations

import asyncio
import hashlib
import os
import socket
import threading
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeVar

import httpx2
from argon2 import PasswordHasher
from sqlalchemy import create_engine, make_url, text

from agentrob.board.admin import local_admin
from agentrob.board.auth import accounts
from agentrob.board.command_reading import CommandReader
from agentrob.board.db.database import open_engine
from agentrob.board.server import create_app, make_server
from agentrob.board.services import Services
from agentrob.board.settings import BoardSettings
from agentrob.config.board import BoardConfig
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, Role
from agentrob.process.http_server import HttpServer

T = TypeVar("T")
#: The timeout of every wait in these tests.
LIMIT_S = 60.0


#: Passwords in tests protect nothing, so hashing them is as cheap as possible.
accounts._hasher = PasswordHasher(time_cost=1, memory_cost=8, parallelism=1)
#: The accounts that every board has from the beginning.
FIRST: dict[str, dict[str, Any]] = {
    "op": {"role": Role.OPERATOR},
    "member": {"role": Role.MEMBER},
    "admin": {"role": Role.ADMIN},
    "quadruped": {"kind": AccountKind.ROBOT_AGENT},
}

#: The URL of a PostgreSQL server; if set, every board of these tests has its own database there.
POSTGRES = "AGENTROB_TEST_POSTGRES"


def database_for(server_url: str, folder: Path) -> str:
    """Return the URL of the database for this folder; create it if it does not exist."""
    name = "board_" + hashlib.sha256(str(folder).encode()).hexdigest()[:16]
    server = create_engine(server_url, isolation_level="AUTOCOMMIT")
    with server.connect() as connection:
        if not connection.execute(text("SELECT 1 FROM pg_database WHERE datname = :n"), {"n": name}).first():
            connection.execute(text(f"CREATE DATABASE {name}"))
    server.dispose()
    return make_url(server_url).set(database=name).render_as_string(hide_password=False)


@cache
def fresh_database() -> tuple[bytes, dict[str, str]]:
    """Return a database with the first boards and accounts, and the tokens; created once for each test process."""
    with TemporaryDirectory() as folder:
        settings = BoardSettings.from_config(BoardConfig(), Path(folder))
        local_admin.bootstrap(settings)
        tokens = {name: token_of(settings, name, **options) for name, options in FIRST.items()}
        assert settings.database_path is not None
        return settings.database_path.read_bytes(), tokens


def token_of(settings: BoardSettings, name: str, **options: Any) -> str:
    """Create an account if it does not exist; return a new token of it."""
    try:
        account = local_admin.find_account(settings, name)
    except BoardError:
        account = local_admin.create_account(settings, name, **options)
    scopes = accounts.SCOPES if account.role is Role.ADMIN else ("read", "write")
    return local_admin.issue_token(settings, account, scopes=scopes)


def first_tokens(settings: BoardSettings) -> dict[str, str]:
    """Create a board with its first accounts if it does not exist; return their tokens."""
    path = settings.database_path
    if path is not None and not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        content, tokens = fresh_database()
        path.write_bytes(content)
        return dict(tokens)
    local_admin.bootstrap(settings)
    return {name: token_of(settings, name, **options) for name, options in FIRST.items()}


class RunningBoard:
    """A served board with the accounts `op`, `member` and `admin` and the robot agent `quadruped`."""

    def __init__(
        self, settings: BoardSettings, server: HttpServer, loop: asyncio.AbstractEventLoop, tokens: dict[str, str]
    ) -> None:
        self.settings = settings
        self.server = server
        self.loop = loop
        self.tokens = tokens
        self._clients: list[httpx2.Client] = []

    @property
    def url(self) -> str:
        return self.settings.base_url

    @property
    def app(self) -> Any:
        """The server's ASGI app."""
        return self.server.config.app

    @property
    def services(self) -> Services:
        """The server's own services; use them only on its event loop (see `run`)."""
        parts: Services = self.app.state.services
        return parts

    def add(self, name: str, **options: Any) -> Account:
        account = local_admin.create_account(self.settings, name, **options)
        self.tokens[name] = local_admin.issue_token(self.settings, account)
        return account

    def have(self, name: str, **options: Any) -> None:
        """Create an account, or only a new token if it exists (when a board is served again)."""
        self.tokens[name] = token_of(self.settings, name, **options)

    def client(self, name: str | None = None) -> httpx2.Client:
        """Return an API client that is signed in by token, or an anonymous one; paths are below `/api/v1`."""
        headers = {"Authorization": f"Bearer {self.tokens[name]}"} if name else {}
        client = httpx2.Client(base_url=self.url + "/api/v1", headers=headers, timeout=LIMIT_S)
        self._clients.append(client)
        return client

    def browser(self, name: str | None = None) -> httpx2.Client:
        """Return a browser that is signed in by a one-time link, or an anonymous one; paths are below `/`."""
        client = httpx2.Client(base_url=self.url, timeout=LIMIT_S)
        self._clients.append(client)
        if name is not None:
            account = local_admin.find_account(self.settings, name)
            engine = open_engine(self.settings, writes=True)
            with engine.begin() as connection:
                session = accounts.new_session(connection, int(account.id))
            engine.dispose()
            client.cookies.set(self.settings.cookie, session, domain="127.0.0.1")
        return client

    def run(self, coroutine: Coroutine[Any, Any, T]) -> T:
        """Run a function on the server's own event loop."""
        return asyncio.run_coroutine_threadsafe(coroutine, self.loop).result(LIMIT_S)

    def close(self) -> None:
        for client in self._clients:
            client.close()


@contextmanager
def running_board(
    folder: Path, *, reader: Callable[[], CommandReader] | None = None, **options: Any
) -> Iterator[RunningBoard]:
    """Serve a board in a folder; `options` replace fields of its settings. `reader` reads commands while they are
    written.

    Ends the server and its thread afterwards.
    """
    listener = socket.create_server(("127.0.0.1", 0))
    config = BoardConfig(listen=f"127.0.0.1:{listener.getsockname()[1]}")
    settings = replace(BoardSettings.from_config(config, folder), **options)
    if (server_url := os.environ.get(POSTGRES)) and "database" not in options:
        settings = replace(settings, database=database_for(server_url, folder))
    tokens = first_tokens(settings)
    ready = threading.Event()
    loops: list[asyncio.AbstractEventLoop] = []

    def on_ready(_: BoardSettings) -> None:
        loops.append(asyncio.get_running_loop())
        ready.set()

    server = make_server(create_app(settings, reader=reader), settings, on_ready)
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]}, daemon=True)
    thread.start()
    try:
        assert ready.wait(LIMIT_S), "the board did not start"
        board = RunningBoard(settings, server, loops[0], tokens)
        try:
            yield board
        finally:
            board.close()
    finally:
        server.should_exit = True
        thread.join(LIMIT_S)
        listener.close()
    assert not thread.is_alive(), "the board did not end"
