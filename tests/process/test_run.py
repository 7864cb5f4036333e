"""A process that is run for its output gets no secrets, and nothing of it is left."""

from __future__ import annotations

import asyncio
import os
import sys
from pathlib import Path

import pytest

from agentrob.process.run import Completed, run_process
from tests.waiting import until

#: Starts another process, says both ids, and waits.
FAMILY = """
import os, subprocess, sys
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
sys.stderr.write(f"{os.getpid()} {child.pid}")
open(sys.argv[1], "w").write(f"{os.getpid()} {child.pid}")
os.rename(sys.argv[1], sys.argv[2])
if sys.argv[3] == "waits":
    child.wait()
"""


def python(source: str, *arguments: object) -> list[str]:
    return [sys.executable, "-c", source, *map(str, arguments)]


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


async def test_it_returns_what_the_process_wrote_and_how_it_ended() -> None:
    source = "import sys; sys.stdout.write(input()[::-1]); sys.stderr.write('first\\nlast words\\n'); sys.exit(3)"
    assert await run_process(python(source), b"walk\n") == Completed(3, b"klaw", "last words")


async def test_a_large_input_and_output_do_not_block_each_other() -> None:
    source = "import sys; sys.stdout.buffer.write(sys.stdin.buffer.read() * 2)"
    done = await run_process(python(source), b"x" * 3_000_000)
    assert (done.returncode, len(done.stdout), done.last_error_line) == (0, 6_000_000, "")


async def test_it_gets_no_secrets(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AGENTROB_TOKEN", "secret")
    source = "import os; print(os.environ.get('AGENTROB_TOKEN'), os.environ['PATH'], os.environ['MUJOCO_GL'])"
    done = await run_process(python(source), env={"MUJOCO_GL": "disable"})
    assert done.stdout.decode().split() == ["None", os.environ["PATH"], "disable"]


@pytest.mark.parametrize("how", ["cancelled", "too long"])
@pytest.mark.parametrize("parent", ["waits", "ends"])
async def test_nothing_outlives_the_call(tmp_path: Path, how: str, parent: str) -> None:
    said = tmp_path / "said"
    running = asyncio.create_task(
        run_process(python(FAMILY, tmp_path / "new", said, parent), limit_s=4.0 if how == "too long" else None)
    )
    async with asyncio.timeout(60):
        if how == "cancelled":
            await until(said.exists)
            running.cancel()
        with pytest.raises(asyncio.CancelledError if how == "cancelled" else TimeoutError):
            await running
        pids = [int(pid) for pid in said.read_text().split()]
        assert len(pids) == 2
        await until(lambda: not any(map(alive, pids)))  # the grandchild's parent is gone; the system reaps it


async def test_a_program_that_does_not_exist_is_an_os_error() -> None:
    with pytest.raises(FileNotFoundError):
        await run_process(["/nonexistent"])
