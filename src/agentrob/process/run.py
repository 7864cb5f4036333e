"""Run a command in a process of its own, which gets no secrets and never outlives the call."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
from collections.abc import Mapping, Sequence
from typing import NamedTuple

#: What such a process gets of our environment: no token or key is among it.
_ENVIRONMENT = ("PATH", "PYTHONPATH", "VIRTUAL_ENV", "LANG", "HOME")


class Completed(NamedTuple):
    """The exit code of a process, its standard output, and the last line of its standard error."""

    returncode: int
    stdout: bytes
    last_error_line: str


async def run_process(
    command: Sequence[str], stdin: bytes = b"", *, limit_s: float | None = None, env: Mapping[str, str] | None = None
) -> Completed:
    """Run a command with this standard input until it ends; `env` is added to its environment.

    If this call is cancelled, or `limit_s` seconds are over, the process and those that it started are killed. Raises
    `TimeoutError`, and `OSError` if it cannot be started.
    """
    pipe = asyncio.subprocess.PIPE
    environment = {name: os.environ[name] for name in _ENVIRONMENT if name in os.environ}
    child = await asyncio.create_subprocess_exec(
        *command, stdin=pipe, stdout=pipe, stderr=pipe, env={**environment, **(env or {})}, process_group=0
    )
    try:
        async with asyncio.timeout(limit_s):
            stdout, stderr = await child.communicate(stdin)
    except BaseException:  # it may have ended, and its own children hold its pipes
        await asyncio.shield(_killed(child))
        raise
    assert child.returncode is not None
    lines = stderr.decode(errors="replace").strip().splitlines()
    return Completed(child.returncode, stdout, lines[-1] if lines else "")


async def _killed(child: asyncio.subprocess.Process) -> None:
    """End the process and those that it started, and close its pipes."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child.pid, signal.SIGKILL)
    assert child.stdin is not None
    child.stdin.close()
    await child.communicate()
    with contextlib.suppress(OSError):
        await child.stdin.wait_closed()
