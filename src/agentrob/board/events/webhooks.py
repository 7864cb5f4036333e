"""Notify other programs of board events by signed webhooks, so that an agent need not poll.

Webhooks carry ids only: receivers read the content from the board with their own rights.
"""

from __future__ import annotations

import asyncio
from collections.abc import Sequence

from agentrob.board.events.hub import EncodedEvent, Hub
from agentrob.board.settings import BoardSettings
from agentrob.errors import BoardError
from agentrob.process.webhooks import Outbox, Receiver, read_secret

#: The account id of our own listener; no account has it.
LISTENER = "(webhooks)"
AGAIN_S = 1.0


def receivers(settings: BoardSettings) -> Sequence[Receiver]:
    """The receivers in `[board.hooks]`. Raises `ConfigError` for missing secrets."""
    return [Receiver(name, hook.url, read_secret(hook.secret_env)) for name, hook in settings.hooks.items()]


async def run(hub: Hub, to: Sequence[Receiver], taken_over: bool = False) -> None:
    """Send every event to each receiver, signed and with retries, until the hub is closed.

    `taken_over`: another process did this before, and may have ended before it sent all.
    """
    if not to:
        return
    outbox = Outbox(to)
    if taken_over:
        outbox.send("board.changed", {})
    delivering = asyncio.create_task(outbox.run())
    try:
        while not hub.closed:
            try:
                await _forward(hub, outbox)
            except BoardError:  # too many streams for now
                await asyncio.sleep(AGAIN_S)
    finally:
        delivering.cancel()


async def _forward(hub: Hub, outbox: Outbox) -> None:
    """Until the hub closes the listener; then events may have been missed, so receivers are asked to look."""
    listener = hub.listen(account_id=LISTENER, role=None)
    try:
        while not listener.closed:
            if (encoded := await listener.next(60.0)) is not None:
                outbox.send(str(encoded.event.kind), _ids(encoded))
    finally:
        hub.leave(listener)
    outbox.send("board.changed", {})


def _ids(encoded: EncodedEvent) -> dict[str, str]:
    event = encoded.event
    found = {"event": event.id, "robot": event.robot or ""}
    if event.post is not None:
        found |= {"post": event.post.id, "topic": event.post.topic_id, "board": event.post.board_id}
    return {name: value for name, value in found.items() if value}
