"""Ask a child process questions; one that does not answer is killed and started again for the next question."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from contextlib import suppress
from typing import Any

from agentrob.process.answering.server import TooSlow

#: A child is killed if it does not answer within `ANSWER_S`, or within `START_S` if it was started for this question:
#: its imports take seconds, and longer on a busy machine.
ANSWER_S, START_S = 15.0, 60.0


class LineProcess:
    """The child runs the Python statement `start`, which serves with `server.LineServer`, from the first question on.

    Every call blocks: use a thread, one call at a time.
    """

    def __init__(self, start: str) -> None:
        self._start = start
        self._child: subprocess.Popen[bytes] | None = None
        self._closed = False

    def ask(self, question: dict[str, Any]) -> dict[str, Any]:
        """Raises `TooSlow`, also if the child says so, and `OSError` if it cannot be started."""
        limit_s = START_S if self._child is None else ANSWER_S
        child = self._child = self._child or self._started()
        assert child.stdin is not None
        assert child.stdout is not None
        killing = threading.Timer(limit_s, child.kill)
        killing.daemon = True
        killing.start()
        line = b""
        try:
            with suppress(OSError, ValueError):  # it ended, or was ended by `close`
                child.stdin.write(json.dumps(question).encode() + b"\n")
                child.stdin.flush()
                line = child.stdout.readline()
        finally:
            killing.cancel()
        if not line:
            self._end()
            raise TooSlow
        answer: dict[str, Any] = json.loads(line)
        if "slow" in answer:
            raise TooSlow
        return answer

    def close(self) -> None:
        """End the child, even while another thread waits for it; that thread gets `TooSlow`."""
        self._closed = True
        self._end()

    def _started(self) -> subprocess.Popen[bytes]:
        if self._closed:
            raise OSError("the process that asks is shutting down")
        return subprocess.Popen([sys.executable, "-c", self._start], stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def _end(self) -> None:
        child, self._child = self._child, None
        if child is not None:
            child.kill()
            child.wait()
