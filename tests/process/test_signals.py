"""A process that waits for a signal ends at it, however many come."""

from __future__ import annotations

import subprocess
import sys

import pytest

#: Other processes send the signals, so that some come while a handler runs.
PROGRAM = """
import os, subprocess, sys
from agentrob.process.signals import event_at_termination

ended = event_at_termination()
send = "import os, signal\\nfor n in range({signals}): os.kill(os.getppid(), (signal.SIGTERM, signal.SIGINT)[n % 2])"
senders = [subprocess.Popen([sys.executable, "-c", send]) for _ in range(2)]
ended.wait()
for sender in senders:
    sender.wait()
print("ended")
"""


@pytest.mark.parametrize("signals", [1, 20_000])
def test_signals_that_come_within_each_others_handlers_set_the_event(signals: int) -> None:
    program = [sys.executable, "-c", PROGRAM.format(signals=signals)]
    done = subprocess.run(program, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "ended\n", "")
