"""Uploaded pictures that wait for their post: in memory, bounded in number and time."""

from __future__ import annotations

import base64
import binascii
import secrets
import time
from collections.abc import Sequence

from agentrob.mcp.envelope import ToolError

MAX_BYTES = 8 * 1024 * 1024
MAX_WAITING = 16
KEEP_S = 600
_KINDS = ((b"\xff\xd8\xff", "image/jpeg"), (b"\x89PNG\r\n", "image/png"), (b"GIF8", "image/gif"))


class MediaStore:
    """The uploaded pictures of one account; beyond the limit the oldest are dropped."""

    def __init__(self) -> None:
        self._waiting: dict[str, tuple[float, bytes]] = {}

    def put(self, data: str) -> tuple[str, str, int]:
        """Store a picture given as base64; return its id, media type and size in bytes."""
        try:
            picture = base64.b64decode(data, validate=True)
        except (binascii.Error, ValueError):
            raise ToolError("invalid_arguments", "data is not base64", "standard base64 without line breaks") from None
        kind = media_type(picture)
        if kind is None or len(picture) > MAX_BYTES:
            wanted = f"a JPEG, PNG, WebP or GIF of at most {MAX_BYTES} bytes"
            raise ToolError("invalid_arguments", "data is not a picture that can be posted", wanted)
        self._forget()
        while len(self._waiting) >= MAX_WAITING:
            del self._waiting[next(iter(self._waiting))]
        media_id = "m_" + secrets.token_hex(8)
        self._waiting[media_id] = (time.monotonic() + KEEP_S, picture)
        return media_id, kind, len(picture)

    def get(self, ids: Sequence[str]) -> tuple[bytes, ...]:
        """The pictures of these ids. They stay until they expire, so that a write can be repeated."""
        self._forget()
        if missing := [i for i in ids if i not in self._waiting]:
            raise ToolError("not_found", f"there is no picture {missing[0][:40]!r} (any more)", "upload_media again")
        return tuple(self._waiting[i][1] for i in ids)

    def _forget(self) -> None:
        now = time.monotonic()
        self._waiting = {k: v for k, v in self._waiting.items() if v[0] > now}


def media_type(picture: bytes) -> str | None:
    """The media type of a picture, by its first bytes."""
    if picture[:4] == b"RIFF" and picture[8:12] == b"WEBP":
        return "image/webp"
    return next((kind for mark, kind in _KINDS if picture.startswith(mark)), None)
