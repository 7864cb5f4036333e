"""The Prometheus metrics of a worker."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from prometheus_client import Counter, Gauge

from agentrob.agent.reporting.metrics import AgentMetrics
from agentrob.model import StopResult
from agentrob.process.metrics import new_registry
from agentrob.worker.worker import WorkerObserver

if TYPE_CHECKING:
    from agentrob.agent.agent import RobotAgent


class WorkerMetrics(WorkerObserver):
    """The counters of a worker and its agents."""

    def __init__(self) -> None:
        self.registry = new_registry()
        self.agents = AgentMetrics(self.registry)
        self._serving: set[str] = set()
        served = Gauge("agentrob_robots_served", "Robots whose posts are answered.", registry=self.registry)
        served.set_function(lambda: len(self._serving))
        self._restarts = self._counter("agentrob_agent_restarts", "Agents that ended by an error and started again.")
        self._takeovers = self._counter("agentrob_takeovers", "Robots taken over from another worker.")
        self._journal = self._counter("agentrob_journal_errors", "Journals that could not be opened or were lost.")

    def serve(self, agent: RobotAgent) -> None:
        """Watch an agent that is ready. Its counters are 0 from now on, where they were absent."""
        self._serving.add(agent.name)
        queue = agent.queue
        self.agents.watch(
            agent.name,
            lambda: len(queue),
            lambda: float(queue.moving is not None),
            lambda: agent.event_stream.silent_s,
        )
        for counter in (self._restarts, self._takeovers, self._journal):
            counter.labels(agent.name)

    def stopped(self, robot: str, result: StopResult | None) -> None:
        """Count a stop."""
        self.agents.stopped(robot, result, result.latency_ms if result is not None else 0.0)

    def restarted(self, robot: str) -> None:
        self._restarts.labels(robot).inc()

    def taken_over(self, robot: str) -> None:
        self._takeovers.labels(robot).inc()

    def journal_failed(self, robot: str) -> None:
        self._journal.labels(robot).inc()

    def left(self, robot: str) -> None:
        if robot in self._serving:
            self._serving.discard(robot)
            self.agents.forget(robot)

    def hooks(self, robot: str) -> dict[str, Any]:
        """The arguments of `RobotAgent` that count its commands and stops."""
        return {"on_end": self.agents.ended, "on_stop": partial(self.stopped, robot)}

    def _counter(self, name: str, text: str) -> Counter:
        return Counter(name, text, ["robot"], registry=self.registry)
