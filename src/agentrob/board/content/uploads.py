"""Accept uploaded pictures: check the account's rights, check the file, store it."""

from __future__ import annotations

import asyncio
import os
from pathlib import Path

import structlog
from sqlalchemy import select

from agentrob.board.content import images
from agentrob.board.content.store import Store
from agentrob.board.db import schema as db
from agentrob.board.db.records import Image
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, Role

#: Attempts to store a picture whose file is deleted meanwhile, because an identical one was deleted.
TRIES = 5

log = structlog.get_logger(__name__)


def check_folder(store: Store) -> None:
    """Log an error if the newest picture is not in the folder, which processes on several hosts must share."""
    i, folder = db.images.c, store.images_dir
    newest = select(i.sha256).where(i.gone_us.is_(None)).order_by(i.id.desc()).limit(1)
    row = store.everything.first(newest)
    if row is not None and not images.path_of(folder, row.sha256).exists():
        hint = "all processes that serve a forum need the same folder"
        log.error("board.pictures_missing", folder=str(folder), hint=hint)


def may(by: Account | None) -> bool:
    """Whether an account may upload: robot agents, operators and those above."""
    if by is None or by.suspended:
        return False
    return by.kind is AccountKind.ROBOT_AGENT or by.role.rank >= Role.OPERATOR.rank


async def take(store: Store, by: Account, data: bytes, key: str | None = None) -> tuple[Image, bool]:
    """Store a picture; return it and whether it is new. 403, 413, 415, 429, 503."""
    if not may(by):
        raise BoardError(403, "no_uploads", "only robot agents, operators and admins may upload", "ask an admin")
    image, data = await asyncio.to_thread(images.check, data)
    for _ in range(TRIES):
        path = await asyncio.to_thread(images.keep, store.images_dir, data)
        if (taken := await store.add_image(by, path, image, key)) is not None:
            return taken
    raise BoardError(503, "storage", "the picture was deleted during each attempt", "try again in a moment", 1.0)


async def file_of(store: Store, image: Image, digest: str) -> tuple[Path, os.stat_result]:
    """The path and status of the file of a picture. 404 if it is missing, 503 if it cannot be read."""
    path = images.path_of(store.images_dir, digest)
    try:
        return path, await asyncio.to_thread(path.stat)
    except FileNotFoundError:
        log.warning("board.picture_missing", image=image.id, file=str(path))
        raise images.gone() from None
    except OSError as e:
        raise BoardError(503, "storage", f"the picture cannot be read now: {e.strerror}", "try again later") from e
