"""Run a streaming response until it ends, or until its viewer leaves or loses the right to see it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from contextlib import suppress

from starlette.types import Receive, Send

#: Seconds between two checks that the viewer of a stream may still see it.
RECHECK_S = 10.0
#: Seconds that the end of a stream waits for a client that does not read.
ENDING_S = 0.5


async def run(
    sending: Coroutine[None, None, None],
    receive: Receive,
    send: Send,
    allowed: Callable[[], bool],
    ended: asyncio.Event,
) -> None:
    """Send until all is sent, the viewer is gone, `ended` is set or the viewer is no longer `allowed`.

    The sender is always cancelled, even while it waits for a client that does not read. Raises what it raised, except
    that the client is gone (`OSError`).
    """
    sender = asyncio.ensure_future(sending)
    tasks = (sender, asyncio.ensure_future(_gone(receive)), asyncio.ensure_future(ended.wait()))
    try:
        while not (await asyncio.wait(tasks, timeout=RECHECK_S, return_when=asyncio.FIRST_COMPLETED))[0]:
            if not allowed():
                break
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
    with suppress(OSError):
        if not sender.cancelled():
            sender.result()
    with suppress(OSError):  # TimeoutError is one
        async with asyncio.timeout(ENDING_S):
            await send({"type": "http.response.body", "body": b"", "more_body": False})


async def part(send: Send, body: bytes) -> None:
    """Send a piece of a stream."""
    await send({"type": "http.response.body", "body": body, "more_body": True})


async def _gone(receive: Receive) -> None:
    while (await receive())["type"] != "http.disconnect":
        pass
