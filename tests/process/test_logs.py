"""Logging of our processes."""

from __future__ import annotations

import subprocess
import sys

LOGS = """
import structlog
from agentrob.process.logs import log_to_stderr
log_to_stderr()
for _ in range(100):
    structlog.get_logger().error("a line", why="a reason of some length" * 20)
print("still there", flush=True)
"""


def test_an_unwritable_log_does_not_end_the_process() -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-c", LOGS], check=False, stdout=subprocess.PIPE, stderr=full, text=True, timeout=60
        )
    assert done.stdout == "still there\n"
