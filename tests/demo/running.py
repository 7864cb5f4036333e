"""Run the demo as a user does: a separate process, on free ports, with its own data folder."""

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
#: All demos that were started; `end_leftovers` ends those that a failed test left running.
RUNNING: list[RunningDemo] = []
ROOT = Path(__file__).parents[2]
AGENTROB = str(Path(sys.executable).with_name("agentrob"))


@dataclass
class RunningDemo:
    """A demo process. `said` is its output so far, `link` the one-time link in its welcome."""

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
    """Start a demo and wait for its welcome; the caller must end it."""
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


def end_leftovers(since: int = 0) -> None:
    """End all demos but the first `since` ones that are still running."""
    for demo in RUNNING[since:]:
        if demo.process.poll() is None:
            os.killpg(demo.process.pid, signal.SIGTERM)  # processes that a shell starts in the background ignore Ctrl-C
            demo.process.wait(60)
