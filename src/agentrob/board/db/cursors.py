"""Where the next page begins, as it is given to whoever asked for this one."""

from __future__ import annotations

import re
from typing import Final

from agentrob.errors import BoardError

#: Of any row.
LARGEST_ID: Final = 2**63 - 1


def to_cursor(number: int) -> str:
    return format(number, "x")


def from_cursor(cursor: str) -> int:
    """The id after which a page begins; 422 for what was never given out as a cursor."""
    # As `to_cursor` writes them and no longer: cursors are part of what answers are kept by.
    number = int(cursor, 16) if re.fullmatch(r"[0-9a-f]{1,16}", cursor) else -1
    if not 0 <= number <= LARGEST_ID:
        raise BoardError(422, "bad_cursor", "that is not a cursor", "send `next` of the page before, as it was given")
    return number
