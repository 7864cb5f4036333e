"""Start child processes, wait for their ready line, log their output to a file and end them.

A child prints one line of JSON with `"ready": true` on standard output when it can be used; one that serves several
robots prints one for each. The kernel sends it SIGTERM when its parent dies (`end_with_parent`), so that a killed demo
leaves no simulator or driver running.
"""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from agentrob.errors import AgentRobError
from agentrob.process.interpreter import freeze_objects

_PARENT = "AGENTROB_PARENT"
_PR_SET_PDEATHSIG = 1


class ChildError(AgentRobError):
    """A child process did not start, or has ended."""


class Child:
    """`python -m agentrob <args>` in a session of its own, so that Ctrl-C reaches only the parent, which ends it.

    It is ready when it has printed this number of `ready_lines`.
    """

    def __init__(
        self, name: str, args: Sequence[str], log: Path, env: Mapping[str, str] | None = None, ready_lines: int = 1
    ) -> None:
        self.name = name
        self.log = log
        self._ready_lines = ready_lines
        self._ready: list[dict[str, Any]] = []
        self._ended = False
        self._changed = threading.Condition()
        log.parent.mkdir(parents=True, exist_ok=True)
        with log.open("ab") as errors:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "agentrob", *args],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=errors,
                env={**os.environ, **(env or {}), _PARENT: str(os.getpid())},
                start_new_session=True,
            )
        threading.Thread(target=self._listen, name=f"{name}-output", daemon=True).start()

    def _listen(self) -> None:
        assert self.process.stdout is not None
        with self.log.open("ab") as log:
            for line in self.process.stdout:
                log.write(line)
                log.flush()
                if line.startswith(b"{"):
                    with contextlib.suppress(ValueError):
                        facts = json.loads(line)
                        if facts.get("ready"):
                            with self._changed:
                                self._ready.append(facts)
                                self._changed.notify_all()
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    @property
    def ready(self) -> dict[str, Any] | None:
        """The contents of the first ready line."""
        return self._ready[0] if self._ready else None

    def wait_ready(self, limit_s: float = 60.0) -> dict[str, Any]:
        """The contents of the first ready line; `ChildError` with the child's last log line if it ends before all of
        them or is late."""
        with self._changed:
            self._changed.wait_for(lambda: self._ended or len(self._ready) >= self._ready_lines, limit_s)
        if len(self._ready) >= self._ready_lines:
            return self._ready[0]
        if self.process.poll() is None and self._ended:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(2)
        state = "ended" if self.process.poll() is not None else f"was not ready after {limit_s:.0f} s"
        raise ChildError(f"{self.name} {state}: {self.last_line()} (log: {self.log})")

    def last_line(self) -> str:
        """The last line that it wrote."""
        lines = self.log.read_text(errors="replace").strip().splitlines() if self.log.exists() else []
        return lines[-1].strip() if lines else "it logged nothing"

    @property
    def alive(self) -> bool:
        return self.process.poll() is None

    def end(self) -> None:
        """Send SIGTERM; `terminate_all` also waits."""
        if self.alive:
            with contextlib.suppress(ProcessLookupError):
                self.process.send_signal(signal.SIGTERM)


def terminate_all(children: Sequence[Child], limit_s: float = 2.5) -> None:
    """Send SIGTERM to all, and SIGKILL to those that still run after `limit_s`."""
    for child in children:
        child.end()
    deadline = time.monotonic() + limit_s
    for child in children:
        try:
            child.process.wait(max(0.01, deadline - time.monotonic()))
        except subprocess.TimeoutExpired:
            child.process.kill()
            child.process.wait()


def end_with_parent() -> None:
    """Called by a child at its start: have the kernel send SIGTERM to it when its parent dies."""
    if parent := os.environ.pop(_PARENT, None):
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
        if os.getppid() != int(parent):
            sys.exit(0)


def print_ready(**facts: Any) -> None:
    """Print the ready line, after `freeze_objects`."""
    freeze_objects()
    print_line(ready=True, **facts)


def print_line(**facts: Any) -> None:
    """Print one line of JSON for the parent process."""
    sys.stdout.write(json.dumps(facts) + "\n")
    sys.stdout.flush()
