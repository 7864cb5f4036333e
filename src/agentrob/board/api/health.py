"""`GET /healthz`: whether the board can serve, for load balancers and monitoring."""

from __future__ import annotations

from typing import Literal

from fastapi import APIRouter
from pydantic import BaseModel

from agentrob.board.services import AppServices
from agentrob.errors import BoardError

router = APIRouter()


class Health(BaseModel):
    status: Literal["ok"]


@router.get("/healthz", include_in_schema=False)
async def get_health(services: AppServices) -> Health:
    """200 while the database can be read and a stop would be written and delivered; else 503. Needs no sign-in."""
    services.store.everything.newest_event_id()  # raises `BoardError` 503 when the database cannot be read
    if not services.hub.delivers_stops:
        raise BoardError(503, "not_ready", "a stop could not be delivered now", "try again in a moment", 1.0)
    return Health(status="ok")
