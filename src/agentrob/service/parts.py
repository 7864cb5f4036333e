"""What the endpoints stand on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from agentrob.service.callers import Callers
from agentrob.service.desk import Desk
from agentrob.service.figures import Figures
from agentrob.webhook import Outbox


@dataclass(frozen=True, slots=True)
class Parts:
    """`hooks_in`: kind and secret of the webhooks that may call; `hosts`: names by which the service may be called."""

    desk: Desk
    callers: Callers
    figures: Figures
    outbox: Outbox
    hooks_in: Mapping[str, tuple[Literal["discourse", "standard"], str]] = field(default_factory=dict)
    hosts: tuple[str, ...] = ()
