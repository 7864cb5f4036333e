"""The objects that the endpoints use."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from agentrob.process.webhooks import Outbox
from agentrob.service.auth import TokenAuthenticator
from agentrob.service.commands import CommandService
from agentrob.service.metrics import ServiceMetrics


@dataclass(frozen=True, slots=True)
class Parts:
    """`hooks_in`: kind and secret of the webhooks that may call; `hosts`: names by which the service may be called."""

    commands: CommandService
    auth: TokenAuthenticator
    metrics: ServiceMetrics
    outbox: Outbox
    hooks_in: Mapping[str, tuple[Literal["discourse", "standard"], str]] = field(default_factory=dict)
    hosts: tuple[str, ...] = ()
