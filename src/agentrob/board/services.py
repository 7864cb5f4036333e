"""The objects that every endpoint of the embedded forum shares: settings, store, event hub, robots, caches."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import Annotated, cast

from fastapi import Depends
from starlette.requests import HTTPConnection

from agentrob.board.command_reading import ReadingQueue
from agentrob.board.content.store import Store
from agentrob.board.content.unread import ReadPositions
from agentrob.board.events.hub import Hub
from agentrob.board.events.presence import PresenceTracker
from agentrob.board.response_cache import TopicCache
from agentrob.board.settings import BoardSettings


@dataclass(frozen=True, slots=True)
class Services:
    """Made once by `server.create_app`. `hashing` lets only one password be hashed at a time (64 MiB and a core).
    `reading` reads commands while they are written, if the forum does that."""

    settings: BoardSettings
    store: Store
    hub: Hub
    presence: PresenceTracker
    topic_cache: TopicCache = field(default_factory=TopicCache)
    marks: ReadPositions = field(default_factory=ReadPositions)
    reading: ReadingQueue | None = None
    hashing: asyncio.Semaphore = field(default_factory=lambda: asyncio.Semaphore(1))


def get_services(request: HTTPConnection) -> Services:
    """The services of the app that handles this request."""
    return cast(Services, request.app.state.services)


async def _services(request: HTTPConnection) -> Services:
    """As `get_services`; FastAPI would call a function that is not async on another thread, for each request."""
    return get_services(request)


#: Declares the services as a parameter of an endpoint.
AppServices = Annotated[Services, Depends(_services)]
