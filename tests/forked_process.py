"""Driver processes that start at once: a fork server has imported the driver.

A child is a process of its own, with signals, sockets and locks as any other; it only does not import the driver again,
which takes 0.6 s of CPU. That the driver starts from nothing too is tested with `agentrob driver` (tests/cli).
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from typing import Any, TextIO

_context = multiprocessing.get_context("forkserver")
_context.set_forkserver_preload(
    ["__main__", "agentrob.robots.driver.process", "agentrob.robots.driver.api", "agentrob.robots.fake"]
)


class ForkedProcess:
    """Runs `target(*args)`, with the interface of `subprocess.Popen` with text and pipes.

    Without `keep_stderr` its standard error is that of the test process.
    """

    def __init__(self, target: Callable[..., None], *args: Any, keep_stderr: bool = True) -> None:
        pipes = {1: _pipe(), **({2: _pipe()} if keep_stderr else {})}
        self.stdout = pipes[1][0]
        self._readers = [reader for reader, _ in pipes.values()]
        writers = {number: writer for number, (_, writer) in pipes.items()}
        # Daemons end with the test process at the latest.
        self._process = _context.Process(target=_child, args=(dict(os.environ), writers, target, args), daemon=True)
        self._process.start()
        for writer in writers.values():
            writer.close()

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
        """What it still wrote on both streams, at its end. After `timeout` seconds it is killed."""
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
        for reader in self._readers:
            reader.close()


def _pipe() -> tuple[TextIO, Connection]:
    """What reads a child's stream as text, and the end that the child writes to."""
    reader, writer = _context.Pipe(duplex=False)
    with reader:
        return os.fdopen(os.dup(reader.fileno()), "r", encoding="utf-8"), writer


def _rest(stream: TextIO) -> str:
    return "" if stream.closed else stream.read()


def _child(
    environ: dict[str, str], streams: dict[int, Connection], target: Callable[..., None], args: tuple[Any, ...]
) -> None:
    os.environ.clear()
    os.environ.update(environ)
    for number, stream in streams.items():
        os.dup2(stream.fileno(), number)
        stream.close()
    target(*args)
