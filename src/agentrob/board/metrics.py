"""The Prometheus metrics of the board, offered on an address of their own: never with names or texts."""

from __future__ import annotations

from collections.abc import Callable

from prometheus_client import Counter, Gauge

from agentrob.board.events.hub import Hub
from agentrob.process.metrics import new_registry


class BoardMetrics:
    """The counters of one board process. `RequestMetrics` counts requests in the same registry."""

    def __init__(self) -> None:
        self.registry = new_registry()
        self._events = Counter(
            "agentrob_board_events",
            "Events delivered by this process, by kind, also those that other processes wrote; posts are post.created.",
            ["kind"],
            registry=self.registry,
        )
        self._writes = Counter("agentrob_board_writes", "Changes written by this process.", registry=self.registry)
        self._listeners = Gauge("agentrob_board_listeners", "Open event streams.", registry=self.registry)

    def watch(self, hub: Hub) -> None:
        """Count the events and listeners of this process."""
        hub.count = lambda event: self._events.labels(event.kind).inc()
        self._listeners.set_function(lambda: hub.listeners)

    def counted(self, published: Callable[[list[int]], None]) -> Callable[[list[int]], None]:
        """`published`, which also counts what was written."""

        def publish(event_ids: list[int]) -> None:
            self._writes.inc(len(event_ids))
            published(event_ids)

        return publish
