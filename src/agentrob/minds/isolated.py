"""Run a mind that is not ours on a thread of its own, so that code that hangs delays no stop and no other robot."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import Callable, Coroutine, Sequence
from concurrent.futures import Future
from typing import Any, TypeVar

import structlog

from agentrob.errors import MindError
from agentrob.minds.protocol import Addressee, ManagedMind, Mind, Reading, read
from agentrob.minds.usage import Usage
from agentrob.model import Plan, Understanding

#: A mind that hangs is replaced this often; then it is not asked any more until the agent is started again.
MOST_HUNG = 4
#: How long a mind may take to answer after a call was given up, and to close.
ANSWER_S, CLOSE_S = 0.5, 2.0
T = TypeVar("T")
_log = structlog.get_logger()


class IsolatedMind:
    """A mind whose calls run in the event loop of another thread. If it hangs, the thread is abandoned, and the next
    call gets a new mind from `make`.

    Fulfils `MeteredMind` and `ManagedMind`. `read` raises `MindError` as the mind does, and when it has hung too often.
    """

    def __init__(self, make: Callable[[], Mind]) -> None:
        self._make = make
        self._mind = make()
        self.name = self._mind.name
        self._thread = _EventLoopThread(self.name)
        self._given_up = False
        self._hung = 0

    async def understand(self, text: str, addressee: Addressee, history: Sequence[Plan] = ()) -> Understanding:
        return (await self.read(text, addressee, history)).understanding

    async def read(
        self, text: str, addressee: Addressee, history: Sequence[Plan] = (), spent: Sequence[Usage] = ()
    ) -> Reading:
        if self._given_up:
            await self._replace_if_hung()
        try:
            return await self._thread.run(read(self._mind, text, addressee, history))
        except asyncio.CancelledError:
            self._given_up = True
            raise

    async def prepare(self) -> None:
        if isinstance(self._mind, ManagedMind):
            await self._thread.run(self._mind.prepare())

    async def close(self) -> None:
        if isinstance(self._mind, ManagedMind):
            await asyncio.wait({asyncio.ensure_future(self._thread.run(self._mind.close()))}, timeout=CLOSE_S)
        self._thread.end()

    async def _replace_if_hung(self) -> None:
        if await self._thread.answers():
            self._given_up = False
            return
        if self._hung >= MOST_HUNG:
            raise MindError(f"the mind {self.name} has hung {self._hung + 1} times and is not asked any more")
        self._hung += 1
        _log.error("mind hangs; its thread is abandoned", mind=self.name, times=self._hung)
        self._thread.end()
        self._thread = _EventLoopThread(self.name)
        self._mind = await self._thread.run(self._make_again())
        self._given_up = False
        await self.prepare()

    async def _make_again(self) -> Mind:
        return self._make()


class _EventLoopThread:
    """A daemon thread that runs an event loop, so that a call in it which never ends does not keep the process."""

    def __init__(self, name: str) -> None:
        self._loop = asyncio.new_event_loop()
        threading.Thread(target=self._serve, name=f"mind {name}", daemon=True).start()

    def _serve(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_forever()

    async def run(self, work: Coroutine[Any, Any, T]) -> T:
        """Run a coroutine in the thread's loop. When the caller is cancelled, it is cancelled there, if it lets that
        happen."""
        future: Future[T] = asyncio.run_coroutine_threadsafe(work, self._loop)
        return await asyncio.wrap_future(future)

    async def answers(self) -> bool:
        """Whether the loop does anything at all."""
        here = asyncio.get_running_loop()
        answered = asyncio.Event()

        def answer() -> None:
            with contextlib.suppress(RuntimeError):  # the loop that asked may be closed by then
                here.call_soon_threadsafe(answered.set)

        self._loop.call_soon_threadsafe(answer)
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(ANSWER_S):
                await answered.wait()
        return answered.is_set()

    def end(self) -> None:
        """End the loop, once it does anything again."""
        self._loop.call_soon_threadsafe(self._loop.stop)
