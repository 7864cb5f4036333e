"""What the endpoints stand on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from agentrob.process.webhooks import Outbox
from agentrob.service.auth import Callers
from agentrob.service.commands import Desk
from agentrob.service.metrics import Figures


@dataclass(frozen=True, slots=True)
class Parts:
    """`hooks_in`: kind and secret of the webhooks that may call; `hosts`: names by which the service may be called."""

    desk: Desk
    callers: Callers
    figures: Figures
    outbox: Outbox
    hooks_in: Mapping[str, tuple[Literal["discourse", "standard"], str]] = field(default_factory=dict)
    hosts: tuple[str, ...] = ()
