"""A worker imports what its agents need before it takes a robot, without the priority of those that serve."""

from __future__ import annotations

import os
import subprocess
import sys
import threading

import pytest

from agentrob.worker import preload


def test_the_modules_are_there_afterwards_and_the_process_keeps_its_priority() -> None:
    script = (
        "import os, sys; from agentrob.worker.preload import preload; before = os.nice(0); preload(); "
        "print({'agentrob.agent.agent', 'matplotlib.figure'} <= set(sys.modules), os.nice(0) == before)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=100, check=True)
    assert done.stdout.split() == ["True", "True"]


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has priorities of threads")
def test_the_imports_have_a_lower_priority_and_their_errors_are_raised() -> None:
    seen: list[int] = []
    preload._at_low_priority(lambda: seen.append(os.getpriority(os.PRIO_PROCESS, threading.get_native_id())))
    assert seen == [min(19, os.getpriority(os.PRIO_PROCESS, threading.get_native_id()) + preload.LOWER)]
    with pytest.raises(ImportError, match="nothing like it"):
        preload._at_low_priority(lambda: (_ for _ in ()).throw(ImportError("nothing like it")))
