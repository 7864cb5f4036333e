"""Where the log goes, and what a line of it looks like."""

from __future__ import annotations

import contextlib
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from structlog.typing import Processor

#: One list for good: loggers keep the one that they began with, and who captures the log changes it in place.
_PROCESSORS: list[Processor] = []


def log_to_stderr() -> None:
    """Standard output belongs to ready lines and results; people read the log."""
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
    """Standard error as it is now; its full disk costs lines, and never the process that writes them."""

    def write(self, text: str) -> None:
        with contextlib.suppress(OSError):
            sys.stderr.write(text)

    def flush(self) -> None:
        with contextlib.suppress(OSError):
            sys.stderr.flush()
