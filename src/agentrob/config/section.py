"""The base model of all tables: it rejects unknown keys, and instances are immutable."""

from __future__ import annotations

from typing import Annotated, Self
from urllib.parse import urlsplit

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from agentrob.process.listen import is_loopback, parse_listen

DEFAULT_LISTEN = "127.0.0.1:8088"
Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_-]{1,31}$")]
#: The name of an environment variable, or empty.
Variable = Annotated[str, Field(pattern=r"^([A-Za-z_][A-Za-z0-9_]{0,63})?$")]


def _plain(url: str) -> str:
    try:
        parts = urlsplit(url)
        _ = parts.port
        plain = parts.scheme in ("http", "https") and parts.hostname and not (parts.username or parts.query)
    except ValueError:
        plain = False
    if url and not plain:
        raise ValueError("must be http(s)://host[:port][/path] without a user, key or query")
    return url.rstrip("/")


#: The address of a server without a user, password or query, which may be secrets, and without a last "/"; or empty.
Address = Annotated[str, AfterValidator(_plain)]
#: The same, and not empty.
ServerAddress = Annotated[str, Field(min_length=1), AfterValidator(_plain)]


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


class Listening(Section):
    """A server at `listen` (`host:port`), which is on this machine unless `allow_remote` is set."""

    listen: str
    allow_remote: bool = False

    @property
    def address(self) -> tuple[str, int]:
        """Host and port."""
        return parse_listen(self.listen)

    @model_validator(mode="after")
    def _is_on_this_machine(self) -> Self:
        check_listen(self.listen, self.allow_remote)
        return self


def check_listen(listen: str, allow_remote: bool, key: str = "listen", consent: str = "allow_remote") -> None:
    """Raise `ValueError` unless the address is on this machine or `allow_remote`."""
    host, _ = parse_listen(listen)
    if not allow_remote and not is_loopback(host):
        raise ValueError(f"{key} is reachable from other machines; set {consent} = true if this is intended")
