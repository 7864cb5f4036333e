"""The `[worker]` table: the process that runs the agents of robots.

[worker]
name = "lab-1"               # shown on the robots' cards; default: hostname-pid
metrics = "127.0.0.1:9470"   # for Prometheus
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from agentrob.config.section import WithMetrics


class WorkerConfig(WithMetrics):
    """`name` is what the robots' cards call this worker; empty: `hostname-pid`."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9._-]{0,64}$")] = ""
