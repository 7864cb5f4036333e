"""Ask a classifier whether a command may be dangerous, without ever waiting long for it.

The classifier blocks, so it runs in a thread of its own. If it does not answer in time or fails, the rules decide
alone; the log says so once, and says when it answers again.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

import structlog

from agentrob.model import Language

#: Says whether a text is suspected of harm. Blocks, and may raise anything.
Classify = Callable[[str, Language], bool]
#: An assessment waits at most this long for the answer, once the model is loaded.
LIMIT_S = 2.0
#: While the model is being loaded: at most this long, counted from its start.
LOAD_S = 15.0
_log = structlog.get_logger()


class SecondOpinion:
    """A classifier that is asked about commands that the rules allow. `close` ends what it runs on."""

    def __init__(
        self, classify: Classify, close: Callable[[], None] = lambda: None, *, limit_s: float = LIMIT_S,
        load_s: float = LOAD_S,
    ) -> None:  # fmt: skip
        self._classify = classify
        self._close = close
        self._limit_s = limit_s
        self._load_s = load_s
        self._thread = ThreadPoolExecutor(1, "second-opinion")
        self._loaded_by = 0.0
        self._silent = False
        #: A call that took too long; until it ends, nothing else is asked.
        self._late: Future[bool] | None = None

    async def warm(self) -> None:
        """Load the model, so that the first command does not wait for it. Never raises."""
        self._loaded_by = time.monotonic() + self._load_s
        await self.suspects("walk forward 1 m", "en")
        self._loaded_by = 0.0

    async def suspects(self, text: str, language: Language) -> bool | None:
        """Return whether harm is suspected in a text, or None if the classifier does not answer in time."""
        if self._late is not None and not self._late.done():
            return None
        limit_s = max(self._limit_s, self._loaded_by - time.monotonic())
        self._late = None
        try:
            answer = self._thread.submit(self._classify, text, language)
            async with asyncio.timeout(limit_s):
                suspected = await asyncio.wrap_future(answer)
        except Exception as e:  # whatever it is, the rules decide
            if isinstance(e, TimeoutError):
                self._late = answer
            if not self._silent:
                why = f"no answer within {limit_s:.0f} s" if isinstance(e, TimeoutError) else str(e)
                _log.warning("the harm classifier does not answer; the rules decide alone", error=why)
            self._silent = True
            return None
        if self._silent:
            _log.info("the harm classifier answers again")
        self._silent = False
        return suspected

    def close(self) -> None:
        """End the classifier, also while it is asked. Calling again does nothing."""
        self._close()
        self._thread.shutdown(wait=False, cancel_futures=True)
