"""A process that can be ordered to die at a point and that reports its death."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from tests.forked_process import ForkedProcess
from tests.kill import kill_points

START_S = 100.0


def wait_for(what: str, condition: Callable[[], Any], limit_s: float) -> Any:
    """Poll `condition` until it returns something, and return that."""
    end_s = time.monotonic() + limit_s
    while not (found := condition()):
        assert time.monotonic() < end_s, f"not within {limit_s:.0f} s: {what}"
        time.sleep(0.02)
    return found


def agentrob(words: tuple[str, ...], plugins: Path) -> None:
    """Run `agentrob WORDS` in a process that can be killed and that finds the robots installed in a folder."""
    sys.path.insert(0, str(plugins))
    sys.argv = ["agentrob", *words]
    kill_points.main()


class KillableProcess:
    """A process that runs `target(*args)` and is ready after `ready()`. It ends with the tests."""

    def __init__(
        self, target: Callable[..., None], *args: Any, log: Path, env: Mapping[str, str] | None = None
    ) -> None:
        self.log = log
        self.lines: list[dict[str, Any]] = []
        self._changed = threading.Condition()
        self.process = ForkedProcess(target, *args, log=log, feed=True, env=env)
        threading.Thread(target=self._listen, daemon=True).start()

    def ready(self) -> KillableProcess:
        self.wait_for_line("ready", START_S)
        return self

    def _listen(self) -> None:
        for line in self.process.stdout:
            if line.startswith("{"):
                with self._changed:
                    self.lines.append(json.loads(line))
                    self._changed.notify_all()

    def wait_for_line(self, word: str, limit_s: float) -> dict[str, Any]:
        """Return the last output line that contains this word, once there is one."""

        def found() -> list[dict[str, Any]]:
            return [line for line in self.lines if word in line]

        with self._changed:
            assert self._changed.wait_for(found, limit_s), f"never said {word!r}; see {self.log}\n{self.last_lines()}"
            return found()[-1]

    def last_lines(self) -> str:
        return "\n".join(self.log.read_text(errors="replace").splitlines()[-15:])

    def arm(self, point: Mapping[str, Any]) -> None:
        """Order it to die at a point; return when the order is confirmed."""
        assert self.process.stdin is not None
        self.process.stdin.write((json.dumps(dict(point)) + "\n").encode())
        self.process.stdin.flush()
        answer = self.wait_for_line("armed", 10.0)
        assert answer["armed"], answer

    def wait_for_kill(self, limit_s: float) -> float:
        """Return when it died at its point (CLOCK_MONOTONIC). A point that is never reached fails the test."""
        at_s = float(self.wait_for_line("killed", limit_s)["at_s"])
        assert self.process.wait(60) == -signal.SIGKILL
        return at_s

    def kill(self) -> float:
        """Kill it now, whatever it is doing."""
        assert self.process.poll() is None, f"had ended by itself; see {self.log}\n{self.last_lines()}"
        self.process.kill()
        at_s = time.monotonic()
        self.process.wait(60)
        return at_s

    def freeze(self) -> None:
        """Suspend it with its memory until `thaw`."""
        self.process.send_signal(signal.SIGSTOP)

    def thaw(self) -> None:
        self.process.send_signal(signal.SIGCONT)

    def end(self) -> None:
        self.thaw()
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(60)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
