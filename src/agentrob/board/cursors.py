"""Where the next page begins, as it is given to whoever asked for this one."""

from __future__ import annotations

from typing import Final

from agentrob.errors import BoardError

#: Of any row.
LARGEST_ID: Final = 2**63 - 1


def to_cursor(number: int) -> str:
    return format(number, "x")


def from_cursor(cursor: str) -> int:
    """The id after which a page begins; 422 for what was never given out as a cursor."""
    try:
        number = int(cursor, 16)
    except ValueError:
        number = -1
    if not 0 <= number <= LARGEST_ID:
        raise BoardError(422, "bad_cursor", "that is not a cursor", "send `next` of the page before, as it was given")
    return number
