"""The base model of all tables: it rejects unknown keys, and instances are immutable."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from agentrob.process.listen import is_loopback, parse_listen

DEFAULT_LISTEN = "127.0.0.1:8088"
Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_-]{1,31}$")]


class Section(BaseModel):
    """One table. Its validator is built on first use, because most commands read few tables."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


class WithMetrics(Section):
    """A process that offers Prometheus metrics at `http://METRICS/metrics`; empty: none.

    `metrics` is `host:port`, on this machine unless `allow_remote_metrics` is set: everybody who can reach the address
    can read them.
    """

    metrics: str = ""
    allow_remote_metrics: bool = False

    @model_validator(mode="after")
    def _offers_metrics_on_this_machine(self) -> Self:
        if self.metrics:
            check_listen(self.metrics, self.allow_remote_metrics, "metrics", "allow_remote_metrics")
        return self


def check_listen(listen: str, allow_remote: bool, key: str = "listen", consent: str = "allow_remote") -> None:
    """Raise `ValueError` unless the address is on this machine or `allow_remote`."""
    host, _ = parse_listen(listen)
    if not allow_remote and not is_loopback(host):
        raise ValueError(f"{key} is reachable from other machines; set {consent} = true if this is intended")
