"""Configures the log: structlog lines on standard error."""

from __future__ import annotations

import contextlib
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from structlog.typing import Processor

#: One list that is changed in place: loggers keep the list that they were created with, as log-capturing tests do.
_PROCESSORS: list[Processor] = []


def log_to_stderr() -> None:
    """Log to standard error; standard output is for ready lines and results."""
    import structlog

    renderer = structlog.dev.ConsoleRenderer(
        colors=sys.stderr.isatty(), exception_formatter=structlog.dev.plain_traceback
    )
    _PROCESSORS[:] = [
        structlog.contextvars.merge_contextvars,
        structlog.processors.add_log_level,
        structlog.processors.TimeStamper(fmt="iso"),
        renderer,
    ]
    structlog.configure(
        processors=_PROCESSORS,
        logger_factory=structlog.WriteLoggerFactory(_Lossy()),  # type: ignore[arg-type]  # a line is written at once
        cache_logger_on_first_use=True,
    )


class _Lossy:
    """The current standard error. Lines that cannot be written, on a full disk, are lost without an error."""

    def write(self, text: str) -> None:
        with contextlib.suppress(OSError):
            sys.stderr.write(text)

    def flush(self) -> None:
        with contextlib.suppress(OSError):
            sys.stderr.flush()
