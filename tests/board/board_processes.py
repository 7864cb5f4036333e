"""Several `agentrob board serve` on one PostgreSQL database, as real processes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx2
from sqlalchemy import create_engine, text

from agentrob.board.admin import local_admin
from agentrob.board.auth import accounts
from agentrob.board.settings import BoardSettings
from agentrob.config.board import BoardConfig
from agentrob.model import AccountKind, Role
from tests.board.db.postgres_server import open_to_all, postgres_server
from tests.board.running_board import LIMIT_S, database_for
from tests.host_numbers import free_port

#: The public address; in production a proxy would be there.
PUBLIC_URL = "http://forum.example.org"
PEOPLE = {"op": Role.OPERATOR, "member": Role.MEMBER, "admin": Role.ADMIN}


@contextmanager
def fresh_postgres(address: str = "") -> Iterator[str]:
    """Run a separate PostgreSQL server; yield its URL. With an IP `address` it listens there too."""
    with tempfile.TemporaryDirectory(prefix="pg-", dir="/tmp") as made:  # socket paths must be short
        folder = Path(made)
        open_to_all(folder)
        with postgres_server(folder, address) as url:
            yield url


class BoardProcess:
    """One `agentrob board serve`. The constructor starts it and does not wait; `wait` returns when it serves."""

    def __init__(self, config: Path, port: int, environment: Mapping[str, str]) -> None:
        self.port, self.log = port, config.with_suffix(".log")
        self._clients: list[httpx2.Client] = []
        with self.log.open("ab") as log:
            command = [sys.executable, "-m", "agentrob", "board", "serve", "--config", str(config)]
            env = os.environ | dict(environment)
            self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True, env=env)

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    @property
    def logged(self) -> str:
        return self.log.read_text(errors="replace")

    def wait(self) -> None:
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert line, self.logged[-3000:]
        assert json.loads(line)["url"] == PUBLIC_URL

    def client(self, token: str | None = None) -> httpx2.Client:
        """Return a client whose paths are below `/api/v1`."""
        headers = {"Authorization": f"Bearer {token}"} if token else {}
        made = httpx2.Client(base_url=self.url + "/api/v1", headers=headers, timeout=LIMIT_S)
        self._clients.append(made)
        return made

    def kill(self) -> None:
        """Kill the process with SIGKILL."""
        self.process.kill()
        self.process.wait(LIMIT_S)

    def end(self) -> None:
        for client in self._clients:
            client.close()
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(LIMIT_S)
            except subprocess.TimeoutExpired:
                self.kill()
        if self.process.stdout:
            self.process.stdout.close()


class Forum:
    """A forum served by several processes; `a` and `b` are the first two of them."""

    def __init__(self, folder: Path, server_url: str, stack: ExitStack) -> None:
        self.folder, self._stack, self._server_url = folder, stack, server_url
        config = BoardConfig(base_url=PUBLIC_URL, database=database_for(server_url, folder))
        self.settings = replace(BoardSettings.from_config(config, folder), busy_timeout_s=2.0)
        self.tokens: dict[str, str] = {}
        self.processes: list[BoardProcess] = []

    def begin(self, hooks: Mapping[str, tuple[str, str]] | None = None) -> BoardProcess:
        """Start one more process, without waiting until it serves."""
        number, port = len(self.processes), free_port()
        config = self.folder / f"board-{number}.toml"
        lines = [
            f'data = "{self.folder}"',
            "[board]",
            *(f'listen = "127.0.0.1:{port}"', f'base_url = "{PUBLIC_URL}"', f'database = "{self.settings.database}"'),
            *("[board.limits]", "posts = 0", "commands = 0", "uploads = 0", "sign_ups = 5"),
        ]
        secrets = {}
        for name, (url, secret) in (hooks or {}).items():
            lines += [f"[board.hooks.{name}]", f'url = "{url}"', 'secret_env = "HOOK_SECRET"']
            secrets["HOOK_SECRET"] = secret
        config.write_text("\n".join(lines) + "\n")
        made = BoardProcess(config, port, secrets)
        self._stack.callback(made.end)
        self.processes.append(made)
        return made

    @property
    def a(self) -> BoardProcess:
        return self.processes[0]

    @property
    def b(self) -> BoardProcess:
        return self.processes[1]

    def people(self) -> None:
        """Create `op`, `member`, `admin` and the robot agent `quadruped`."""
        for name, role in PEOPLE.items():
            self.add(name, role=role)
        self.add("quadruped", kind=AccountKind.ROBOT_AGENT)

    def add(self, name: str, **options: Any) -> str:
        account = local_admin.create_account(self.settings, name, **options)
        scopes = accounts.SCOPES if account.role is Role.ADMIN else ("read", "write")
        self.tokens[name] = local_admin.issue_token(self.settings, account, scopes=scopes)
        return self.tokens[name]

    def as_(self, name: str, on: BoardProcess) -> httpx2.Client:
        return on.client(self.tokens[name])

    @contextmanager
    def database_blocked(self) -> Iterator[None]:
        """Block all access to the forum's database, like a failed server or network."""
        name = self.settings.database.partition("?")[0].rsplit("/", 1)[1]
        engine = create_engine(self._server_url, isolation_level="AUTOCOMMIT")
        with engine.connect() as connection:
            connection.execute(text(f"ALTER DATABASE {name} ALLOW_CONNECTIONS false"))
            try:
                end = "SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity WHERE datname = :n"
                connection.execute(text(end), {"n": name})
                yield
            finally:
                connection.execute(text(f"ALTER DATABASE {name} ALLOW_CONNECTIONS true"))
        engine.dispose()


@contextmanager
def forum_of(server_url: str, folder: Path, processes: int = 2, **options: Any) -> Iterator[Forum]:
    """Serve a forum on an empty database; all processes start at the same time."""
    folder.mkdir(parents=True, exist_ok=True)
    with ExitStack() as stack:
        forum = Forum(folder, server_url, stack)
        for _ in range(processes):
            forum.begin(**options)
        for process in forum.processes:
            process.wait()
        forum.people()
        yield forum
