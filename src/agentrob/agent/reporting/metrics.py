"""The Prometheus metrics of agents, by robot: never with names of people or texts of posts."""

from __future__ import annotations

import math
from collections.abc import Callable

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram

from agentrob.model import Report, StopResult
from agentrob.process.metrics import FAST_S

_COMMAND_S = (0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300)


class AgentMetrics:
    """The counters of the agents of one process, in its registry."""

    def __init__(self, registry: CollectorRegistry) -> None:
        def histogram(name: str, text: str, buckets: tuple[float, ...] = FAST_S) -> Histogram:
            return Histogram(name, text, ["robot"], buckets=buckets, registry=registry)

        def gauge(name: str, text: str) -> Gauge:
            return Gauge(name, text, ["robot"], registry=registry)

        self._commands = Counter(
            "agentrob_commands", "Commands that ended, by status.", ["robot", "status"], registry=registry
        )
        self._stops = Counter(
            "agentrob_stops", "Stops, by whether the driver was reached.", ["robot", "reached"], registry=registry
        )
        self._times = {
            "seen": histogram("agentrob_command_seen_seconds", "From the post to the first status."),
            "first_motion": histogram("agentrob_command_first_motion_seconds", "From the post to the first motion."),
            "done": histogram("agentrob_command_seconds", "From the post to the end of the motion.", _COMMAND_S),
        }
        self._stopped = histogram("agentrob_stop_seconds", "From the request to zero velocity commanded.")
        self._waiting = gauge("agentrob_queue_length", "Commands that wait or move.")
        self._moving = gauge("agentrob_moving", "1 while a command moves the robot.")
        self._silent = gauge("agentrob_forum_silent_seconds", "Seconds since the forum last answered.")

    def watch(
        self, robot: str, waiting: Callable[[], float], moving: Callable[[], float], silent_s: Callable[[], float]
    ) -> None:
        """Read these at each scrape, instead of those given earlier for this robot."""
        for gauge, read in ((self._waiting, waiting), (self._moving, moving), (self._silent, silent_s)):
            gauge.labels(robot).set_function(read)

    def forget(self, robot: str) -> None:
        """End `watch`: this process no longer serves the robot. Its counters stay."""
        for gauge in (self._waiting, self._moving, self._silent):
            gauge.remove(robot)

    def ended(self, report: Report) -> None:
        """Count a command whose final reply was posted."""
        robot = report.command.robot
        self._commands.labels(robot, report.status).inc()
        for name, histogram in self._times.items():
            if (took_ms := report.timings_ms.get(name)) is not None:
                histogram.labels(robot).observe(took_ms / 1000)

    def stopped(self, robot: str, result: StopResult | None, latency_ms: float) -> None:
        """Count a stop; `result` is None if no driver was reached."""
        self._stops.labels(robot, str(result is not None).lower()).inc()
        if result is not None and math.isfinite(latency_ms):
            self._stopped.labels(robot).observe(latency_ms / 1000)
