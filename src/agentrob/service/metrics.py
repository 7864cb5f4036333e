"""The Prometheus metrics of the service."""

from __future__ import annotations

import math
from collections.abc import Callable

from prometheus_client import CollectorRegistry, Counter, Gauge, Histogram, generate_latest

from agentrob.model import Report, StopResult

_SECONDS = (0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300)
_STOP_SECONDS = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5)


class ServiceMetrics:
    """A registry of its own, so that several services in one process do not mix."""

    def __init__(self, robot: str) -> None:
        self.registry = CollectorRegistry()
        self._robot = robot
        self._commands = self._counter("agentrob_commands", "Commands that ended, by status.", "status")
        self._stops = self._counter("agentrob_stops", "Stops over HTTP, by whether the driver was reached.", "reached")
        self.requests = self._counter("agentrob_http_requests", "Requests answered.", "method", "status")
        self.hooks_in = self._counter("agentrob_hooks_in", "Webhooks received, by whether they were accepted.", "taken")
        self.hooks_out = self._counter(
            "agentrob_hooks_out", "Webhook deliveries, by outcome: told, failed, dropped.", "outcome"
        )
        self._took = self._histogram("agentrob_command_seconds", "From the post to the end of the motion.", _SECONDS)
        self._stopped = self._histogram(
            "agentrob_stop_seconds", "From the request to zero velocity commanded.", _STOP_SECONDS
        )

    def watch(self, waiting: Callable[[], float], moving: Callable[[], float], silent_s: Callable[[], float]) -> None:
        """Add gauges that are read at each scrape."""
        for name, help_text, read in (
            ("agentrob_queue_length", "Commands that wait or move.", waiting),
            ("agentrob_moving", "1 while a command moves the robot.", moving),
            ("agentrob_forum_silent_seconds", "Seconds since the forum last answered.", silent_s),
        ):
            gauge = Gauge(name, help_text, ["robot"], registry=self.registry)
            gauge.labels(self._robot).set_function(read)

    def ended(self, report: Report) -> None:
        self._commands.labels(self._robot, report.status).inc()
        if (took_ms := report.timings_ms.get("done")) is not None:
            self._took.labels(self._robot).observe(took_ms / 1000)

    def stopped(self, result: StopResult | None, latency_ms: float) -> None:
        self._stops.labels(self._robot, str(result is not None).lower()).inc()
        if result is not None and math.isfinite(latency_ms):
            self._stopped.labels(self._robot).observe(latency_ms / 1000)

    def count(self, counter: Counter, *labels: str) -> None:
        counter.labels(self._robot, *labels).inc()

    def webhook_delivered(self, outcome: str) -> None:
        """Count a webhook delivery by its outcome: told, failed or dropped."""
        self.count(self.hooks_out, outcome)

    def text(self) -> bytes:
        return generate_latest(self.registry)

    def _counter(self, name: str, help_text: str, *labels: str) -> Counter:
        return Counter(name, help_text, ["robot", *labels], registry=self.registry)

    def _histogram(self, name: str, help_text: str, buckets: tuple[float, ...]) -> Histogram:
        return Histogram(name, help_text, ["robot"], buckets=buckets, registry=self.registry)
