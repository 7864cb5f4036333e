"""Drain the workers and agents of this machine: each listens on a socket of its own in the runtime folder.

A process says who it is in one line of JSON, `{worker, robots}`, and drains when it reads the line `drain`. It keeps
the connection until it ends.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import secrets
import socket
from collections.abc import AsyncIterator, Callable, Collection, Iterator, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import structlog

from agentrob.config.load import runtime_dir

#: How long a process may take to say who it is.
ANSWER_S = 5.0
_log = structlog.get_logger()


def _folder() -> Path:
    folder = runtime_dir() / "agents"
    folder.mkdir(mode=0o700, exist_ok=True)
    return folder


@asynccontextmanager
async def draining_on_request(name: str, robots: Collection[str], drain: Callable[[], None]) -> AsyncIterator[None]:
    """Call `drain` when somebody asks this process for it, while the block runs. `robots` is read at each request."""

    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        # Who asks may go away, or send no line; the loop cancels the rest when this process ends.
        with contextlib.suppress(OSError, ValueError, asyncio.CancelledError):
            writer.write(json.dumps({"worker": name, "robots": sorted(robots)}).encode() + b"\n")
            await writer.drain()
            if await reader.readline() == b"drain\n":
                drain()
            await reader.read()
        writer.close()

    # Containers that share the folder may have processes of the same number.
    path = _folder() / f"{os.getpid()}-{secrets.token_hex(4)}.sock"
    server = None
    try:
        server = await asyncio.start_unix_server(answer, path)
    except OSError as e:  # robots are served all the same
        _log.warning("cannot be drained", path=str(path), error=str(e))
    try:
        yield
    finally:
        if server is not None:
            server.close()
            path.unlink(missing_ok=True)


@dataclass(frozen=True, slots=True)
class Draining:
    """A process that drains. `robots` are those that it served when it was asked."""

    worker: str
    robots: tuple[str, ...]
    connection: socket.socket

    def wait(self) -> None:
        """Wait until the process has ended."""
        with self.connection, contextlib.suppress(OSError):
            self.connection.settimeout(None)
            while self.connection.recv(1024):
                pass


def drain(names: Sequence[str]) -> list[Draining]:
    """Ask the workers of these names, and those that serve these robots, to drain; without names, all."""
    found = []
    for connection in _connections():
        try:
            with connection.makefile("r", encoding="utf-8") as lines:
                hello = json.loads(lines.readline())
            worker, robots = str(hello["worker"]), tuple(map(str, hello["robots"]))
            if names and not {worker, *robots} & set(names):
                connection.close()
                continue
            connection.sendall(b"drain\n")
        except (OSError, ValueError, KeyError, TypeError):  # it ends just now
            connection.close()
            continue
        found.append(Draining(worker, robots, connection))
    return found


def serving() -> dict[str, str]:
    """The worker or agent of this machine that serves each robot, by the robot's name."""
    found = dict[str, str]()
    for connection in _connections():
        with connection, contextlib.suppress(OSError, ValueError, KeyError, TypeError):  # it ends just now
            with connection.makefile("r", encoding="utf-8") as lines:
                hello = json.loads(lines.readline())
            found |= {str(robot): str(hello["worker"]) for robot in hello["robots"]}
    return found


def _connections() -> Iterator[socket.socket]:
    for path in sorted(_folder().glob("*.sock")):
        connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        connection.settimeout(ANSWER_S)
        try:
            connection.connect(str(path))
        except ConnectionRefusedError:
            connection.close()
            path.unlink(missing_ok=True)  # its process was killed
        except OSError:
            connection.close()
        else:
            yield connection
