"""Encode and decode the opaque cursors of paged results."""

from __future__ import annotations

import re
from typing import Final

from agentrob.errors import BoardError

#: The largest row id.
LARGEST_ID: Final = 2**63 - 1


def to_cursor(number: int) -> str:
    return format(number, "x")


def from_cursor(cursor: str) -> int:
    """Return the id after which the page begins. Raises 422 if the cursor is malformed."""
    # Only the canonical form: cursors are part of cache keys.
    number = int(cursor, 16) if re.fullmatch(r"[0-9a-f]{1,16}", cursor) else -1
    if not 0 <= number <= LARGEST_ID:
        raise BoardError(
            422, "bad_cursor", f"{cursor[:40]!r} is not a cursor", "send `next` of the previous page unchanged"
        )
    return number
