"""What every endpoint of the embedded forum reaches through `services(request)`: settings, store, events, robots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

from starlette.requests import HTTPConnection

from agentrob.board.settings import BoardSettings

if TYPE_CHECKING:
    from agentrob.board.store import Store


@dataclass(frozen=True, slots=True)
class Services:
    """Made once by `server.create_app`."""

    settings: BoardSettings
    store: Store


def services(request: HTTPConnection) -> Services:
    """The services of the app that handles this request."""
    return cast(Services, request.app.state.services)
