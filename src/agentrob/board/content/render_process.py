"""Render long and complex texts in a separate process, so that the parser does not block the server's event loop.

Python's interpreter lock would let a long parse delay stops (law 15). Both ends exchange one JSON object per line: the
text, the names in it, which of them are accounts, and the result. The process gives up a text that takes more than
`LIMIT_S` of CPU time; a process that does not answer is killed and restarted for the next text. It exits when its
standard input closes, and so never outlives the server.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import threading
from collections.abc import Iterable
from contextlib import suppress
from typing import IO, Any

import structlog

from agentrob.board.content.rendered import Text

#: The limit of processor seconds for one text; prose of 64 KiB takes about 0.1 s.
LIMIT_S = 0.25
#: Seconds after which a process that does not answer is killed; this includes its start.
ANSWER_S = 15.0
#: Lower priority than other processes of the machine, above all those of robots.
NICE = 5
MAX_MEMORY = 1 << 30
_START = "from agentrob.board.content.render_process import serve; serve()"

log = structlog.get_logger(__name__)


class TooSlow(Exception):
    """The text takes too long, or its process ended."""


class RenderProcess:
    """The client of the process, which starts with the first text. Every call blocks: use a thread, one call at a
    time."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._closed = False

    def names_in(self, raw: str) -> list[str]:
        """Begin a text; return the names in it. Raises `TooSlow`."""
        found: list[str] = self._ask({"raw": raw})["names"]
        return found

    def made(self, known: Iterable[str]) -> dict[str, Any]:
        """Return the fields of the `Rendered` text that was begun, given the names that are accounts. Raises
        `TooSlow`."""
        return self._ask({"known": list(known)})

    def close(self) -> None:
        """End the process, even while another thread waits for it; that thread gets `TooSlow`."""
        self._closed = True
        self._end()

    def _ask(self, said: dict[str, Any]) -> dict[str, Any]:
        try:
            process = self._process = self._process or self._started()
        except OSError as e:
            log.error("board.no_rendering", error=str(e))
            raise TooSlow from e
        assert process.stdin is not None
        assert process.stdout is not None
        killing = threading.Timer(ANSWER_S, process.kill)
        killing.daemon = True
        killing.start()
        line = b""
        try:
            with suppress(OSError, ValueError):  # it ended, or was ended by `close`
                process.stdin.write(json.dumps(said).encode() + b"\n")
                process.stdin.flush()
                line = process.stdout.readline()
        finally:
            killing.cancel()
        if not line:
            self._end()
            raise TooSlow
        answer: dict[str, Any] = json.loads(line)
        if "slow" in answer:
            raise TooSlow
        return answer

    def _started(self) -> subprocess.Popen[bytes]:
        if self._closed:
            raise OSError("the forum is shutting down")
        return subprocess.Popen([sys.executable, "-c", _START], stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()


# -------------------------------------------------------------------- in the process
def serve() -> None:
    """Render texts from standard input until it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a Ctrl-C reaches the whole group; our input ends by itself
    signal.signal(signal.SIGPROF, _too_slow)
    resource.setrlimit(resource.RLIMIT_AS, (MAX_MEMORY, MAX_MEMORY))
    os.nice(NICE)
    # Render once, so that the first text's time does not include imports and compilation.
    Text("*first* @nobody").rendered(frozenset()).fields()
    while _one(sys.stdin.buffer, sys.stdout.buffer):
        pass


def _one(lines: IO[bytes], answers: IO[bytes]) -> bool:
    """Render one text; return False at the end of the input."""
    try:
        if not (line := lines.readline()):
            return False
        _limit(LIMIT_S)
        text = Text(json.loads(line)["raw"])
        names = list(text.names)
        _limit(0)
        _say(answers, {"names": names})
        if not (line := lines.readline()):
            return False
        _limit(LIMIT_S)
        made = text.rendered(frozenset(json.loads(line)["known"])).fields()
        _limit(0)
        _say(answers, made)
    except (TooSlow, MemoryError, RecursionError):
        _limit(0)
        _say(answers, {"slow": True})
    return True


def _say(answers: IO[bytes], said: dict[str, Any]) -> None:
    answers.write(json.dumps(said).encode() + b"\n")
    answers.flush()


def _limit(seconds: float) -> None:
    """Limit processor time from now on; 0 means no limit. The signal repeats, in case a callback swallows the first."""
    signal.setitimer(signal.ITIMER_PROF, seconds, 0.05 if seconds else 0.0)


def _too_slow(_signal: int, _frame: object) -> None:
    raise TooSlow
