"""Starts the simulated world as a separate process, on a DDS domain that no other test uses."""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

DOMAINS = range(150, 171)
READY_LIMIT_S = 60.0


@dataclass
class ServedWorld:
    """A world served by another process."""

    process: subprocess.Popen[str]
    domain: int
    ready: Mapping[str, Any]
    cpu_until_ready_s: float
    event_log: Path

    @property
    def url(self) -> str:
        return str(self.ready["http"])

    def cpu_seconds(self) -> float:
        """Return the processor time that it and its ended children have used."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return sum(int(f) for f in fields[11:15]) / os.sysconf("SC_CLK_TCK")

    def end(self, number: int = signal.SIGTERM) -> float:
        """Return the seconds from the signal to the end."""
        began = time.monotonic()
        self.process.send_signal(number)
        self.process.wait(60)
        return time.monotonic() - began


def start_world(
    folder: Path, *options: str, environment: Mapping[str, str] | None = None, domains: Sequence[int] = DOMAINS
) -> ServedWorld:
    """Serve on the first free one of the domains."""
    event_log = folder / "ledger.jsonl"
    for domain in domains:
        command = [sys.executable, "-m", "agentrob.sim.server", "--domain", str(domain), "--event-log", str(event_log)]
        process = subprocess.Popen(
            [*command, *options],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, **(environment or {})},
        )
        assert process.stdout is not None
        assert process.stderr is not None
        readable, _, _ = select.select([process.stdout], [], [], READY_LIMIT_S)
        line = process.stdout.readline() if readable else ""
        if line:
            world = ServedWorld(process, domain, json.loads(line), 0.0, event_log)
            world.cpu_until_ready_s = world.cpu_seconds()
            return world
        process.kill()
        trouble = process.communicate()[1]
        assert "already held" in trouble, trouble
    raise AssertionError(f"every one of the domains {domains} is taken")
