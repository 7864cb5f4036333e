"""A process that waits for a signal ends at it, however many come; a delayed signal comes after its block."""

from __future__ import annotations

import signal
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


DELAYED = """
import os, signal, subprocess, sys
from agentrob.process.signals import delayed_signals, sigterm_interrupts

if {ignored}:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
with sigterm_interrupts():
    try:
        with delayed_signals():
            child = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
            for number in {numbers}:
                os.kill(os.getpid(), number)
            print("the block was done")
        print("not interrupted")
    except KeyboardInterrupt:
        print("interrupted")
    child.send_signal(signal.SIGTERM)
    print(child.wait())
"""


def delayed(*numbers: int, ignored: bool = False) -> list[str]:
    program = DELAYED.format(numbers=[int(number) for number in numbers], ignored=ignored)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True)
    return done.stdout.splitlines()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize("times", [1, 3])
def test_a_signal_interrupts_only_after_the_block_that_delays_it(number: int, times: int) -> None:
    said = delayed(*[number] * times)
    assert said == ["the block was done", "interrupted", "-15"], "and a process that it started hears signals"


def test_without_a_signal_or_with_one_that_is_ignored_nothing_is_interrupted() -> None:
    assert delayed() == delayed(signal.SIGINT, ignored=True) == ["the block was done", "not interrupted", "-15"]
