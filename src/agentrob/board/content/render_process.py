"""Render long and complex texts in a separate process, so that the parser does not block the server's event loop.

Python's interpreter lock would let a long parse delay stops (law 15). The process is asked twice for each text: for the
names in it, and for the result once it is known which of them are accounts. It gives up a text that takes more than
`LIMIT_S` of processor time.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import structlog

from agentrob.board.content.rendered import Text
from agentrob.process.answering.client import LineProcess
from agentrob.process.answering.server import LineServer, TooSlow

#: The limit of processor seconds for one text; prose of 64 KiB takes about 0.1 s.
LIMIT_S = 0.25
_START = "from agentrob.board.content.render_process import serve; serve()"

log = structlog.get_logger(__name__)


class RenderProcess:
    """The client of the process, which starts with the first text. Every call blocks: use a thread, one call at a
    time."""

    def __init__(self) -> None:
        self._process = LineProcess(_START)

    def names_in(self, raw: str) -> list[str]:
        """Begin a text; return the names in it. Raises `TooSlow`."""
        found: list[str] = self._ask({"raw": raw})["names"]
        return found

    def made(self, known: Iterable[str]) -> dict[str, Any]:
        """Return the fields of the `Rendered` text that was begun, given the names that are accounts. Raises
        `TooSlow`."""
        return self._ask({"known": list(known)})

    def close(self) -> None:
        """End the process, even while another thread waits for it; that thread gets `TooSlow`."""
        self._process.close()

    def _ask(self, said: dict[str, Any]) -> dict[str, Any]:
        try:
            return self._process.ask(said)
        except OSError as e:
            log.error("board.no_rendering", error=str(e))
            raise TooSlow from e


# -------------------------------------------------------------------- in the process
def serve() -> None:
    """Render texts from standard input until it ends."""
    server = LineServer(LIMIT_S)
    # Render once, so that the first text's time does not include imports and compilation.
    Text("*first* @nobody").rendered(frozenset()).fields()
    while _one(server):
        pass


def _one(server: LineServer) -> bool:
    """Render one text; return False at the end of the input."""
    try:
        if (asked := server.question()) is None:
            return False
        text = Text(asked["raw"])
        server.answer({"names": list(text.names)})
        if (asked := server.question()) is None:
            return False
        server.answer(text.rendered(frozenset(asked["known"])).fields())
    except (TooSlow, MemoryError, RecursionError):
        server.give_up()
    return True
