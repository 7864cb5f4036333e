"""Our own processes, started at once: a fork server has imported what drivers, boards, agents and commands need.

A child is a process of its own, with signals, sockets, locks and files as any other. It only does not import and
prepare everything again, which takes 0.6 s of CPU for a driver, 2 to 3 s for a board or a command that asks it, and 4 s
for an agent.
At least one test of each command starts it from nothing.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, BinaryIO, TextIO

from tests.in_process import Said

_context = multiprocessing.get_context("forkserver")
_context.set_forkserver_preload(
    [
        "__main__",
        "agentrob.robots.driver.process",
        "agentrob.robots.driver.api",
        "agentrob.robots.fake",
        "agentrob.cli.main",
        "agentrob.wiring.app",
        "agentrob.agent.agent",
        "agentrob.agent.media.plot",
        "agentrob.board.server",
        "agentrob.forums.agentrob.forum",
        "agentrob.mcp.forum.http",
        "agentrob.mcp.forum.run",
        "agentrob.minds.rules",
        "tests.warm",
    ]
)


class ForkedProcess:
    """Runs `target(*args)`, with the interface of `subprocess.Popen` with text and pipes.

    Without `keep_stderr` its standard error is that of the test process; with `log` it is appended to that file. With
    `feed` its standard input is a pipe, otherwise it is empty.
    """

    def __init__(
        self,
        target: Callable[..., None],
        *args: Any,
        keep_stderr: bool = True,
        log: Path | None = None,
        feed: bool = False,
        folder: Path | None = None,
        env: Mapping[str, str] | None = None,
    ) -> None:
        pipes = {1: _pipe(), **({2: _pipe()} if keep_stderr and log is None else {})}
        self.stdout = pipes[1][0]
        self.stderr = pipes[2][0] if 2 in pipes else None
        self._readers = [reader for reader, _ in pipes.values()]
        ends = {number: end for number, (_, end) in pipes.items()}
        self.stdin: BinaryIO | None = None
        if feed:
            ends[0], into = _context.Pipe(duplex=False)
            with into:
                self.stdin = os.fdopen(os.dup(into.fileno()), "wb")
        surroundings = {**os.environ, **(env or {})}, ends, log, folder
        # Daemons end with the test process at the latest.
        self._process = _context.Process(target=_child, args=(*surroundings, target, args), daemon=True)
        self._process.start()
        for end in ends.values():
            end.close()

    @property
    def pid(self) -> int:
        assert self._process.pid is not None
        return self._process.pid

    @property
    def returncode(self) -> int | None:
        return self._process.exitcode

    def poll(self) -> int | None:
        return self._process.exitcode

    def send_signal(self, number: signal.Signals) -> None:
        if self._process.is_alive():
            os.kill(self.pid, number)

    def terminate(self) -> None:
        self._process.terminate()

    def kill(self) -> None:
        self._process.kill()

    def wait(self, timeout: float | None = None) -> int:
        self._process.join(timeout)
        if self._process.exitcode is None:
            raise subprocess.TimeoutExpired(str(self._process), timeout or 0.0)
        return self._process.exitcode

    def communicate(self, timeout: float | None = None) -> tuple[str, str]:
        """Wait for its end and return the rest of both streams. After `timeout` seconds it is killed."""
        watch = threading.Timer(timeout, self.kill) if timeout else None
        if watch:
            watch.start()
        with ThreadPoolExecutor(2) as threads:
            out, err, *_ = *threads.map(_rest, self._readers), ""
        self._process.join()
        if watch:
            watch.cancel()
        self.close()
        return out, err

    def close(self) -> None:
        """Close the streams."""
        for stream in (*self._readers, *([self.stdin] if self.stdin else [])):
            stream.close()


class ForkedCommand(ForkedProcess):
    """`agentrob WORDS` in a separate process; for a command that serves, `ready` is its ready line."""

    def __init__(self, folder: Path, *words: str, log: Path | None = None, feed: bool = False, **env: str) -> None:
        super().__init__(_command, words, log=log, feed=feed, folder=folder, env=env)
        self.log, self.words = log, words
        self._ready: dict[str, Any] = {}

    @property
    def ready(self) -> dict[str, Any]:
        """The ready line; waits for it."""
        while not self._ready:
            line = self.stdout.readline()
            said = self.log.read_text(errors="replace")[-3000:] if self.log and not line else ""
            assert line, f"agentrob {' '.join(self.words)} ended before it was ready: {said}"
            if line.startswith("{") and (facts := json.loads(line)).get("ready"):
                self._ready = facts
        return self._ready

    @property
    def alive(self) -> bool:
        return self.poll() is None


def end_all(processes: Sequence[ForkedProcess]) -> None:
    """Send SIGTERM to all, and wait for all."""
    for process in processes:
        process.terminate()
    for process in processes:
        process.wait(60)
        process.close()


def agentrob(folder: Path, *words: str, **env: str) -> Said:
    """Run a command in a folder; return its output and exit code."""
    command = ForkedCommand(folder, *words, **env)
    out, errors = command.communicate(timeout=60)
    assert command.returncode is not None
    return Said(command.returncode, out, errors)


def _pipe() -> tuple[TextIO, Connection]:
    """Return a text reader of a child's stream, and the end of the pipe that the child writes to."""
    reader, writer = _context.Pipe(duplex=False)
    with reader:
        return os.fdopen(os.dup(reader.fileno()), "r", encoding="utf-8"), writer


def _rest(stream: TextIO) -> str:
    return "" if stream.closed else stream.read()


def _child(
    environ: dict[str, str],
    streams: dict[int, Connection],
    log: Path | None,
    folder: Path | None,
    target: Callable[..., None],
    args: tuple[Any, ...],
) -> None:
    os.environ.clear()
    os.environ.update(environ)
    for number, stream in streams.items():
        os.dup2(stream.fileno(), number)
        stream.close()
    if log is not None:
        with log.open("ab") as file:
            os.dup2(file.fileno(), 2)
    if 0 in streams:
        sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115 (as long as the process)
    if folder is not None:
        os.chdir(folder)
    target(*args)


def _command(words: Sequence[str]) -> None:
    from agentrob.cli.main import main

    sys.argv = ["agentrob", *words]
    main()
