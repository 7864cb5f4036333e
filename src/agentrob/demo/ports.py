"""Choose the port of the demo's forum."""

from __future__ import annotations

import socket

from agentrob.demo.errors import DemoError

#: Taken by default, if it is free.
PORT = 8088


def free_port() -> int:
    """Return a port of this machine that nobody uses."""
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return int(s.getsockname()[1])


def is_free(port: int) -> bool:
    """Return whether a server can listen on this port of this machine."""
    with socket.socket() as s:
        s.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            s.bind(("127.0.0.1", port))
        except OSError:
            return False
    return True


def choose_port(wanted: int | None) -> int:
    """Return the wanted port, which must be free; for None the usual one if it is free, else any; for 0 any.

    Raises `DemoError`.
    """
    if wanted:
        if not is_free(wanted):
            raise DemoError(f"port {wanted} is in use; choose another with --port, or leave --port away for a free one")
        return wanted
    return PORT if wanted is None and is_free(PORT) else free_port()
