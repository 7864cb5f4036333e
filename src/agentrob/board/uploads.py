"""Takes pictures that people and programs upload: whether they may, what it is, where it is kept."""

from __future__ import annotations

import asyncio

from agentrob.board import images
from agentrob.board.records import Image
from agentrob.board.services import Services
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, Role


def may(by: Account | None) -> bool:
    """Whether an account may upload: robot agents, operators and those above."""
    if by is None or by.suspended:
        return False
    return by.kind is AccountKind.ROBOT_AGENT or by.role.rank >= Role.OPERATOR.rank


async def take(services: Services, by: Account, data: bytes, key: str | None = None) -> tuple[Image, bool]:
    """Keep a picture; whether it is new. 403, 413, 415, 429, 503."""
    if not may(by):
        raise BoardError(403, "no_uploads", "only robot agents, operators and admins may upload", "ask an admin")
    image, data = await asyncio.to_thread(images.check, data)
    digest = await asyncio.to_thread(images.keep, services.settings.images_dir, data)
    return await services.store.add_image(by, digest, image, key)
