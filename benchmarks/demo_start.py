"""Measure the time from `make demo` until the page answers, and until the welcome is printed.

    .venv/bin/python benchmarks/demo_start.py [RUNS]

Packages are cached; each run uses a new data folder.
"""

from __future__ import annotations

import contextlib
import os
import shlex
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from pathlib import Path

ROOT = Path(__file__).parents[1]
LIMIT_S = 90.0


def free_port() -> int:
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return int(s.getsockname()[1])


def answers(url: str) -> bool:
    try:
        with urllib.request.urlopen(url, timeout=1) as response:
            return response.status == 200
    except urllib.error.HTTPError as e:
        return e.code < 500
    except OSError:
        return False


def one(data: Path) -> tuple[float, float]:
    """Seconds until the page answers and until the welcome is printed."""
    port = free_port()
    began = time.monotonic()
    process = subprocess.Popen(
        ["make", "--silent", "-C", str(ROOT), "demo", f"ARGS={shlex.join(['--port', str(port), '--data', str(data)])}"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    )
    try:
        while not answers(f"http://127.0.0.1:{port}/"):
            if process.poll() is not None or time.monotonic() - began > LIMIT_S:
                raise SystemExit("the demo did not start")
            time.sleep(0.02)
        page_s = time.monotonic() - began
        assert process.stdout is not None
        for line in process.stdout:
            if "Ctrl-C" in line:
                return page_s, time.monotonic() - began
        raise SystemExit("the demo ended without its welcome")
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGINT)
        process.wait(10)


def main() -> None:
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    with tempfile.TemporaryDirectory() as folder:
        times = [one(Path(folder) / str(n)) for n in range(runs)]
    for name, values in zip(("page answers", "welcome (all ready)"), zip(*times, strict=True), strict=True):
        low, middle, high = min(values), statistics.median(values), max(values)
        print(f"{name:20} min {low:5.1f} s  median {middle:5.1f} s  max {high:5.1f} s  n={runs}")


if __name__ == "__main__":
    main()
