"""The boards that the viewer of the current request may read: set once per request, used by every read of the store.

Until a request sets them they are empty, so an endpoint that forgets to identify its viewer shows no post.
"""

from __future__ import annotations

from collections.abc import Iterable
from contextvars import ContextVar

from agentrob.board.db.records import Board
from agentrob.model import Account, Role

_readable: ContextVar[frozenset[str]] = ContextVar("readable", default=frozenset())


def boards_readable_by(boards: Iterable[Board], account: Account | None, public_read: bool) -> frozenset[str]:
    """The ids of the boards that an account may read; without an account, those for guests if the forum is public."""
    if (account is None and not public_read) or (account is not None and account.suspended):
        return frozenset()
    rank = account.role.rank if account else Role.GUEST.rank
    return frozenset(b.id for b in boards if rank >= b.read_role.rank)


def set_readable_boards(boards: frozenset[str]) -> None:
    """Let the current request read these boards."""
    _readable.set(boards)


def readable_boards() -> frozenset[str]:
    """The boards that the current request may read."""
    return _readable.get()
