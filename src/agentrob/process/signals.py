"""Turns signals that end a process into an event or into KeyboardInterrupt, or delays them."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Iterator


@contextlib.contextmanager
def sigterm_interrupts() -> Iterator[None]:
    """Within this, SIGTERM and a closed terminal raise `KeyboardInterrupt`, as Ctrl-C does."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    before = {number: signal.signal(number, interrupt) for number in (signal.SIGTERM, signal.SIGHUP)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextlib.contextmanager
def delayed_signals() -> Iterator[None]:
    """Call the handlers of Ctrl-C, SIGTERM and SIGHUP only after this block.

    An interrupt within `Popen` would leave a process that nobody ends. That process would inherit a mask of blocked
    signals, so the handlers are replaced for the time of the block. Only the main thread runs handlers, so in other
    threads this does nothing.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    handlers = {number: handler for number in numbers if callable(handler := signal.getsignal(number))}
    pending: list[int] = []
    try:
        for number in handlers:
            signal.signal(number, lambda number, _: pending.append(number))
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for late in pending:
            signal.raise_signal(late)


def event_at_termination() -> threading.Event:
    """Return an event that SIGTERM and SIGINT set from now on. Call it from the main thread only.

    The handler only writes into a pipe, from which a thread sets the event. If it set the event itself, a second signal
    that comes within the first one's handler would wait for the lock of the event for ever.
    """
    ended = threading.Event()
    read, write = os.pipe()
    os.set_blocking(write, False)

    def note(*_: object) -> None:
        with contextlib.suppress(BlockingIOError):  # many signals are noted already
            os.write(write, b"s")

    def wait() -> None:
        os.read(read, 1)
        ended.set()

    threading.Thread(target=wait, name="signals", daemon=True).start()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, note)
    return ended
