"""Run a command at a terminal of its own, as a person does."""

from __future__ import annotations

import os
import pty
import select
import time


class Terminal:
    """A command at a terminal of its own; `said` is its output so far."""

    def __init__(self, *command: str, **environment: str) -> None:
        self.said = ""
        self.pid, self._master = pty.fork()
        if self.pid == 0:
            os.execve(command[0], command, environment)

    def read_until(self, words: str, limit_s: float) -> None:
        """Read until the words were printed or the command ended."""
        end_s = time.monotonic() + limit_s
        while words not in self.said:
            readable, _, _ = select.select([self._master], [], [], max(0.0, end_s - time.monotonic()))
            assert readable, f"no {words!r} within {limit_s} s: {self.said}"
            try:
                self.said += os.read(self._master, 65536).decode(errors="replace")
            except OSError:  # the command has ended
                assert words in self.said, self.said
                return

    def press(self, keys: bytes) -> None:
        os.write(self._master, keys)

    def wait(self) -> int:
        """Return the exit code."""
        return os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])
