"""The runs of a preview in two processes: the same as in one, and neither is left behind."""

from __future__ import annotations

import asyncio
import contextlib
import os
import subprocess
import sys
from itertools import count
from pathlib import Path

import pytest

from agentrob.errors import SimError
from agentrob.rehearsal import side_by_side
from agentrob.rehearsal.client import rehearse
from agentrob.rehearsal.preview import Run
from agentrob.rehearsal.runs import simulate
from agentrob.rehearsal.side_by_side import Budget, make_runs
from agentrob.robots.unitree.go2 import Go2
from tests.rehearsal.rehearsed import request, walk
from tests.waiting import until

#: Makes runs whose length is the number of the process that made them.
MAKES = """
import os, sys
from agentrob.errors import SimError
from agentrob.rehearsal.preview import Run
from agentrob.rehearsal.side_by_side import Budget, make_runs

def run(number):
    if number == {fails}:
        {how}
    return Run((), float(os.getpid()), ())

try:
    runs = make_runs(run, Budget(4, 4, 0.0), 2)
    print(len(runs), len({{r.seconds for r in runs}}), runs[0].seconds == runs[2].seconds == os.getpid())
except SimError as e:
    print(e)
"""


def made(fails: int = -1, how: str = "pass") -> str:
    code = MAKES.format(fails=fails, how=how)
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60).stdout


async def test_a_preview_is_the_same_from_two_processes_as_from_one() -> None:
    asked = request(walk(0.3), least_runs=4, most_runs=4)
    found = await rehearse(asked, Go2.describe(asked.settings))
    assert found == simulate(asked)
    assert found.hash == simulate(asked).hash


def test_every_second_run_is_made_by_another_process() -> None:
    assert made() == "4 2 True\n"


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("raise ValueError('it fell apart')", "a run ended with an error: ValueError: it fell apart\n"),
        ("os._exit(3)", "a process of the preview ended with 3\n"),
    ],
)
def test_a_run_that_fails_in_the_other_process_fails_the_preview(how: str, said: str) -> None:
    assert made(1, how) == said


def test_what_this_process_raises_is_raised() -> None:
    def run(number: int) -> Run:
        raise SimError("no world")

    with pytest.raises(SimError, match="no world"):
        make_runs(run, Budget(2, 2, 0.0), 1)


def test_each_process_makes_its_least_runs_and_more_while_there_is_time() -> None:
    slow, fast = count(0, 10), count(0, 0.1)
    for first, least, most in ((0, [0, 2], [0, 2, 4]), (1, [1], [1, 3])):
        assert list(Budget(3, 5, 3.5, lambda: float(next(slow))).numbers(first, 2)) == least
        assert list(Budget(3, 5, 3.5, lambda: float(next(fast))).numbers(first, 2)) == most


def test_no_more_processes_than_processors_are_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0})
    assert side_by_side.usable_processes() == 1


def in_group(group: int) -> list[str]:
    """The processes of a process group."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it has ended meanwhile
            state, _, of = (folder / "stat").read_text().rsplit(")", 1)[1].split()[:3]
            found += [folder.name] if int(of) == group and state != "Z" else []
    return found


async def test_a_cancelled_preview_ends_both_processes() -> None:
    asked = request(*[walk(0.5)] * 20, least_runs=5, most_runs=5)
    making = asyncio.ensure_future(rehearse(asked, Go2.describe(asked.settings)))
    groups = await until(lambda: [g for g in children() if len(in_group(g)) == 2])
    making.cancel()
    await asyncio.gather(making, return_exceptions=True)
    await until(lambda: not in_group(groups[0]))  # the kernel ends it


def children() -> list[int]:
    """The processes that this process has started."""
    return [int(word) for word in Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()]
