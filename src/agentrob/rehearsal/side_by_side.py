"""Make the runs of a preview in this process and, at the same time, in one that it forks."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection

from agentrob.errors import SimError
from agentrob.rehearsal.preview import Run

#: More processes than this would take the processors of robots, and of people who wait.
MOST_PROCESSES = 2


@dataclass(frozen=True)
class Budget:
    """How many runs are made: at least `least`, and up to `most` while they take no longer than `seconds` in total."""

    least: int
    most: int
    seconds: float
    clock: Callable[[], float] = time.monotonic

    def numbers(self, first: int, every: int) -> Iterator[int]:
        """Yield the numbers of the runs that one process makes, each when it is due: every `every`-th one."""
        began_s = self.clock()
        for made, number in enumerate(range(first, self.most, every)):
            spent_s = self.clock() - began_s
            if number >= self.least and spent_s * (made + 1) > self.seconds * max(1, made):
                return
            yield number


def usable_processes() -> int:
    """Return how many processes may make runs at the same time."""
    return min(MOST_PROCESSES, len(os.sched_getaffinity(0)))


def make_runs(run: Callable[[int], Run], budget: Budget, processes: int) -> list[Run]:
    """Return the runs in the order of their numbers, which are also their seeds: the same whichever process made them.

    With `processes` 2 this process must have no other thread. Raises what `run` raises, and `SimError` if the other
    process fails.
    """
    if processes < MOST_PROCESSES or budget.most < MOST_PROCESSES:
        return [run(number) for number in budget.numbers(0, 1)]
    with _other_process(run, budget) as found:
        made = {number: run(number) for number in budget.numbers(0, MOST_PROCESSES)}
        made |= found()
    return [made[number] for number in sorted(made)]


@contextlib.contextmanager
def _other_process(run: Callable[[int], Run], budget: Budget) -> Iterator[Callable[[], dict[int, Run]]]:
    """Fork a process that makes every second run; yield a function that waits for them. The process ends with the
    block."""
    context = multiprocessing.get_context("fork")
    receives, sends = context.Pipe(duplex=False)
    process = context.Process(target=_make_others, args=(run, budget, receives, sends), daemon=True)
    process.start()
    sends.close()

    def found() -> dict[int, Run]:
        made = dict[int, Run]()
        with contextlib.suppress(EOFError):
            while True:
                number, result = receives.recv()
                if isinstance(result, str):
                    raise SimError(f"a run ended with an error: {result}")
                made[number] = result
        process.join()
        if process.exitcode:
            raise SimError(f"a process of the preview ended with {process.exitcode}")
        return made

    try:
        yield found
    finally:
        if process.is_alive():
            process.kill()
        receives.close()


def _make_others(run: Callable[[int], Run], budget: Budget, receives: Connection, sends: Connection) -> None:
    """The other process. It cannot outlive its parent for long: then nobody reads what it sends."""
    receives.close()
    with open(os.devnull, "wb") as nothing:  # the answer is written by the first process alone
        os.dup2(nothing.fileno(), sys.__stdout__.fileno() if sys.__stdout__ is not None else 1)
    for number in budget.numbers(1, MOST_PROCESSES):
        try:
            result: Run | str = run(number)
        except Exception:
            result = traceback.format_exc().strip().splitlines()[-1]
        sends.send((number, result))
