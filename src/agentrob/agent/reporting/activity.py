"""Count what an agent did since it began to serve, for the robot's card."""

from __future__ import annotations

import os
import socket
from collections import Counter, deque
from dataclasses import dataclass, field
from datetime import UTC, datetime
from statistics import median
from typing import Any

from agentrob import __version__
from agentrob.model import CommandState, Report, StopResult

#: The final states that count as failures.
FAILURES = frozenset({CommandState.FAILED, CommandState.INTERRUPTED, CommandState.EXPIRED, CommandState.REFUSED})
#: The number of commands whose median latency is shown.
LATEST = 20


def process_name() -> str:
    """The name of this process among the workers of a fleet: `hostname-pid`."""
    return f"{socket.gethostname()[:64]}-{os.getpid()}"


@dataclass
class AgentActivity:
    """The ended commands and the stops of one agent. `worker` names the process that runs it."""

    worker: str
    since: datetime = field(default_factory=lambda: datetime.now(UTC))
    failures: Counter[str] = field(default_factory=Counter)
    stop_ms: float | None = None
    stop_at: datetime | None = None
    _seen_ms: deque[float] = field(default_factory=lambda: deque(maxlen=LATEST))

    def ended(self, report: Report) -> None:
        """Count a command whose final reply was posted."""
        if report.status in FAILURES:
            self.failures[str(report.status)] += 1
        if (seen_ms := report.timings_ms.get("seen")) is not None:
            self._seen_ms.append(seen_ms)

    def stopped(self, result: StopResult | None) -> None:
        """Note the last stop; None if no driver was reached."""
        self.stop_ms = None if result is None else result.latency_ms
        self.stop_at = datetime.now(UTC)

    def card(self) -> dict[str, Any]:
        """The fields of the robot's card (`docs/reference/interfaces.md`)."""
        return {
            "worker": self.worker,
            "version": __version__,
            "since": self.since.isoformat(),
            "failures": dict(sorted(self.failures.items())),
            "lag_ms": round(median(self._seen_ms)) if self._seen_ms else None,
            "stop_ms": None if self.stop_ms is None else round(self.stop_ms, 1),
            "stop_at": self.stop_at.isoformat() if self.stop_at else None,
        }
