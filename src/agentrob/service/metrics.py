"""The Prometheus metrics of the service."""

from __future__ import annotations

from collections.abc import Callable

from prometheus_client import CollectorRegistry, Counter, generate_latest

from agentrob.agent.reporting.metrics import AgentMetrics
from agentrob.model import Report, StopResult


class ServiceMetrics:
    """A registry of its own, so that several services in one process do not mix."""

    def __init__(self, robot: str) -> None:
        self.registry = CollectorRegistry()
        self._robot = robot
        self._agent = AgentMetrics(self.registry)
        self.requests = self._counter("agentrob_http_requests", "Requests answered.", "method", "status")
        self.hooks_in = self._counter("agentrob_hooks_in", "Webhooks received, by whether they were accepted.", "taken")
        self.hooks_out = self._counter(
            "agentrob_hooks_out", "Webhook deliveries, by outcome: delivered, failed, dropped.", "outcome"
        )

    def watch(self, waiting: Callable[[], float], moving: Callable[[], float], silent_s: Callable[[], float]) -> None:
        """Add gauges that are read at each scrape."""
        self._agent.watch(self._robot, waiting, moving, silent_s)

    def ended(self, report: Report) -> None:
        self._agent.ended(report)

    def stopped(self, result: StopResult | None, latency_ms: float) -> None:
        """Count a stop over HTTP."""
        self._agent.stopped(self._robot, result, latency_ms)

    def count(self, counter: Counter, *labels: str) -> None:
        counter.labels(self._robot, *labels).inc()

    def webhook_delivered(self, outcome: str) -> None:
        """Count a webhook delivery by its outcome: delivered, failed or dropped."""
        self.count(self.hooks_out, outcome)

    def text(self) -> bytes:
        return generate_latest(self.registry)

    def _counter(self, name: str, help_text: str, *labels: str) -> Counter:
        return Counter(name, help_text, ["robot", *labels], registry=self.registry)
