"""A network namespace in which cyclonedds 11 and 0.10 discover each other, and the processes in it.

On the host's loopback 0.10 uses no multicast, so the two would not discover each other. The namespace also isolates the
test from other robots, simulations and tests.
"""

from __future__ import annotations

import os
import select
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

ROOT = Path(__file__).parents[2]
HERE = Path(__file__).parent
OURS = Path(sys.executable)
PEER = ROOT / ".venv-peer/bin/python"
SHIM = ROOT / ".venv-peer/their_server.so"
READY_LIMIT_S, RUN_LIMIT_S = 60.0, 100.0
LOOPBACK = "ip link set lo up && ip link set lo multicast on && echo up && exec cat"


class Network:
    """A network namespace with only a multicast loopback; raises `OSError` if the kernel does not permit one."""

    def __init__(self) -> None:
        mine = ["--user", "--map-root-user"] if os.getuid() else []
        self._keeper = subprocess.Popen(
            ["unshare", *mine, "--net", "sh", "-c", LOOPBACK],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self._keeper.stdout is not None
        assert self._keeper.stderr is not None
        if self._keeper.stdout.readline() != "up\n":
            raise OSError(f"no network namespace with multicast could be made: {self._keeper.stderr.read().strip()}")
        into = ["--user", "--preserve-credentials"] if mine else []
        self._enter = ["nsenter", "--target", str(self._keeper.pid), *into, "--net", "--"]
        self._running: list[subprocess.Popen[str]] = []

    def start(self, *command: str | Path, log: Path, env: Mapping[str, str] | None = None) -> str:
        """Start a process that keeps running; return its first line of output, which reports that it is ready."""
        with log.open("w") as errors:
            process = self._popen(command, env, errors)
        self._running.append(process)
        assert process.stdout is not None
        while select.select([process.stdout], [], [], READY_LIMIT_S)[0]:
            line = process.stdout.readline()
            assert line, f"{command} ended: {log.read_text()}"
            if "ready" in line:
                return line
        raise AssertionError(f"{command} was not ready after {READY_LIMIT_S:.0f} s: {log.read_text()}")

    def run(self, *command: str | Path, env: Mapping[str, str] | None = None) -> str:
        """Run a process that must end with exit code 0; return its output."""
        process = self._popen(command, env, subprocess.PIPE)
        try:
            said, errors = process.communicate(timeout=RUN_LIMIT_S)
        finally:
            process.kill()
        assert process.returncode == 0, f"{command} ended with {process.returncode}: {said}{errors}"
        return said

    def _popen(
        self, command: Sequence[str | Path], env: Mapping[str, str] | None, errors: object
    ) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [*self._enter, *command],
            stdout=subprocess.PIPE,
            stderr=errors,  # type: ignore[call-overload]
            text=True,
            env={**os.environ, "PYTHONPATH": str(ROOT), **(env or {})},
        )

    def close(self) -> None:
        for process in self._running:
            process.terminate()
        for process in self._running:
            try:
                process.wait(60)
            except subprocess.TimeoutExpired:
                process.kill()
        assert self._keeper.stdin is not None
        self._keeper.stdin.close()
        self._keeper.wait(60)
