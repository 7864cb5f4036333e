"""Choose the port of the demo's forum."""

from __future__ import annotations

import socket

from agentrob.demo.errors import DemoError
from agentrob.process.listen import is_free

#: Taken by default, if it is free.
HOST, PORT = "127.0.0.1", 8088


def free_port() -> int:
    """Return a port of this machine that nobody uses."""
    with socket.socket() as s:
        s.bind((HOST, 0))
        return int(s.getsockname()[1])


def choose_port(wanted: int | None) -> int:
    """Return the wanted port, which must be free; for None the usual one if it is free, else any; for 0 any.

    Raises `DemoError`.
    """
    if wanted:
        if not is_free(HOST, wanted):
            raise DemoError(f"port {wanted} is in use; choose another with --port, or leave --port away for a free one")
        return wanted
    return PORT if wanted is None and is_free(HOST, PORT) else free_port()
