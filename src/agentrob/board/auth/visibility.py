"""Which boards whoever asks may see: set once per request, asked by every read of the store.

Reads of a request that said nothing see nothing, so an endpoint that forgets to ask who is there shows no post.
"""

from __future__ import annotations

from collections.abc import Iterable
from contextvars import ContextVar

from agentrob.board.db.records import Board
from agentrob.model import Account, Role

_readable: ContextVar[frozenset[str]] = ContextVar("readable", default=frozenset())


def boards_readable_by(boards: Iterable[Board], account: Account | None, public_read: bool) -> frozenset[str]:
    """The ids of the boards that an account may read; without one, those for guests where the forum is public."""
    if (account is None and not public_read) or (account is not None and account.suspended):
        return frozenset()
    rank = account.role.rank if account else Role.GUEST.rank
    return frozenset(b.id for b in boards if rank >= b.read_role.rank)


def set_readable_boards(boards: frozenset[str]) -> None:
    """From here on this request sees these boards."""
    _readable.set(boards)


def readable_boards() -> frozenset[str]:
    """What the request that runs now may see."""
    return _readable.get()
