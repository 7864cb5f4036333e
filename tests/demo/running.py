"""Runs the demo as a user does: a process of its own, on free ports, in a folder of its own."""

from __future__ import annotations

import os
import re
import shlex
import signal
import subprocess
import sys
import threading
from dataclasses import dataclass, field
from pathlib import Path

START_S = 100.0
#: Every demo that was started; `end_left` ends those that a failed test left behind.
RUNNING: list[RunningDemo] = []
ROOT = Path(__file__).parents[2]
AGENTROB = str(Path(sys.executable).with_name("agentrob"))


@dataclass
class RunningDemo:
    """`said` is what it printed so far; `link` the one-time link of its welcome."""

    process: subprocess.Popen[str]
    data: Path
    said: list[str] = field(default_factory=list)
    ready: threading.Event = field(default_factory=threading.Event)

    @property
    def link(self) -> str:
        return re.search(r"http://\S+/enter/\S+", "".join(self.said))[0]  # type: ignore[index]

    @property
    def url(self) -> str:
        return self.link.split("/enter/")[0]

    def listen(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.said.append(line)
            if "Ctrl-C" in line:
                self.ready.set()
        self.ready.set()

    def agentrob(self, *args: str) -> subprocess.CompletedProcess[str]:
        env = {**os.environ, "AGENTROB_DATA": str(self.data.parent)}
        return subprocess.run(
            [AGENTROB, *args], env=env, capture_output=True, text=True, timeout=100, check=False, cwd=self.data.parent
        )


def start_demo(data: Path, *, through_make: bool = False) -> RunningDemo:
    """Start and wait for the welcome; the caller ends it."""
    arguments = ["--port", "0", "--data", str(data)]
    make = ["make", "--silent", "-C", str(ROOT), "demo", f"ARGS={shlex.join(arguments)}"]
    process = subprocess.Popen(
        make if through_make else [AGENTROB, "demo", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    demo = RunningDemo(process, data)
    RUNNING.append(demo)
    threading.Thread(target=demo.listen, daemon=True).start()
    assert demo.ready.wait(START_S), "".join(demo.said)
    assert process.poll() is None, "".join(demo.said)
    return demo


def end_left(since: int = 0) -> None:
    """End the demos that were started after the first `since` ones and still run."""
    for demo in RUNNING[since:]:
        if demo.process.poll() is None:
            os.killpg(demo.process.pid, signal.SIGTERM)  # a Ctrl-C is ignored by what a shell began in the background
            demo.process.wait(60)
