"""Answer questions in a child process, each within a limit of processor time.

The child exits when its standard input closes, and so never outlives its parent.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
from typing import Any

#: Lower priority than other processes of the machine, above all those of robots.
NICE = 5
MAX_MEMORY = 1 << 30


class TooSlow(Exception):
    """The answer takes too long, or the child ended."""


class LineServer:
    """Reads questions from standard input and answers on standard output. `limit_s`: processor time for each."""

    def __init__(self, limit_s: float) -> None:
        self._limit_s = limit_s
        self._lines, self._answers = sys.stdin.buffer, sys.stdout.buffer
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # a Ctrl-C reaches the whole group; our input ends by itself
        signal.signal(signal.SIGPROF, _too_slow)
        resource.setrlimit(resource.RLIMIT_AS, (MAX_MEMORY, MAX_MEMORY))
        os.nice(NICE)

    def question(self) -> dict[str, Any] | None:
        """The next question, whose time begins now; None at the end of the input."""
        if not (line := self._lines.readline()):
            return None
        _limit(self._limit_s)
        asked: dict[str, Any] = json.loads(line)
        return asked

    def answer(self, facts: dict[str, Any]) -> None:
        """Send the answer, whose time ends here."""
        _limit(0)
        self._answers.write(json.dumps(facts).encode() + b"\n")
        self._answers.flush()

    def give_up(self) -> None:
        """Answer that it takes too long."""
        self.answer({"slow": True})


def _limit(seconds: float) -> None:
    """Limit processor time from now on; 0 means no limit. The signal repeats, in case a callback swallows the first."""
    signal.setitimer(signal.ITIMER_PROF, seconds, 0.05 if seconds else 0.0)


def _too_slow(_signal: int, _frame: object) -> None:
    raise TooSlow
