"""Deliver webhooks, signed as in Standard Webhooks, with retries.

A failed delivery is retried a few times, then dropped. Each receiver has a bounded queue in memory.
"""

from __future__ import annotations

import asyncio
import json
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Any
from uuid import uuid4

import httpx2
import structlog
from standardwebhooks import Webhook
from standardwebhooks.webhooks import EmptyWebhookSecretError

from agentrob.errors import ConfigError
from agentrob.process.tls import tls

#: Pauses between the attempts of a delivery, and the size of a receiver's queue.
PAUSES_S = (1.0, 5.0, 30.0, 120.0, 300.0)
MOST_WAITING = 500
TIMEOUT_S = 10.0
_log = structlog.get_logger()


def signer(secret: str) -> Webhook:
    """Return what signs and verifies with a secret: used as it is, or as base64 after `whsec_`.

    Raises `ValueError` if it is empty or cannot be decoded.
    """
    try:
        return Webhook(secret if secret.startswith("whsec_") else secret.encode())
    except EmptyWebhookSecretError:
        raise ValueError("the secret is empty") from None


def read_secret(variable: str) -> str:
    """Return a secret from the environment; it is never in the configuration. Raises `ConfigError`."""
    secret = os.environ.get(variable, "")
    if not secret:
        raise ConfigError(f"the environment variable {variable} must hold a secret")
    try:
        signer(secret)
    except ValueError:
        raise ConfigError(f"the secret in {variable} begins with whsec_, so the rest must be base64") from None
    return secret


@dataclass
class Receiver:
    """A receiver of webhooks. It has its own queue, so that a slow one does not delay others."""

    name: str
    url: str
    secret: str = field(repr=False)
    waiting: asyncio.Queue[tuple[str, bytes]] = field(default_factory=lambda: asyncio.Queue(MOST_WAITING))


class Outbox:
    """Queues webhooks in memory and delivers them with retries."""

    def __init__(
        self,
        receivers: Sequence[Receiver],
        count: Callable[[str], None] = lambda _: None,
        pauses_s: Sequence[float] | None = None,
    ) -> None:
        """`count` is called with the outcome of each delivery: `delivered`, `failed` or `dropped`."""
        self._receivers = receivers
        self._count = count
        self._pauses_s = PAUSES_S if pauses_s is None else pauses_s

    def send(self, kind: str, data: dict[str, Any]) -> None:
        """Queue a webhook for every receiver without waiting; drop it for one whose queue is full."""
        event = {"type": kind, "timestamp": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()), "data": data}
        body = json.dumps(event, ensure_ascii=False, separators=(",", ":")).encode("utf-8", "replace")
        for receiver in self._receivers:
            try:
                receiver.waiting.put_nowait((f"msg_{uuid4().hex}", body))
            except asyncio.QueueFull:
                self._count("dropped")
                _log.error("webhook dropped: queue full", receiver=receiver.name)

    async def run(self) -> None:
        """Deliver until cancelled."""
        if not self._receivers:
            return
        http = httpx2.AsyncClient(timeout=TIMEOUT_S, trust_env=False, follow_redirects=False, verify=tls())
        async with http, asyncio.TaskGroup() as group:
            for receiver in self._receivers:
                group.create_task(self._serve(http, receiver))

    async def _serve(self, http: httpx2.AsyncClient, receiver: Receiver) -> None:
        while True:
            identity, body = await receiver.waiting.get()
            try:
                outcome = "delivered" if await self._deliver(http, receiver, identity, body) else "failed"
            except Exception as e:  # continue with the next webhook
                outcome = "failed"
                _log.error("webhook not delivered", receiver=receiver.name, why=type(e).__name__)
            self._count(outcome)
            receiver.waiting.task_done()

    async def _deliver(self, http: httpx2.AsyncClient, receiver: Receiver, identity: str, body: bytes) -> bool:
        for pause_s in (*self._pauses_s, None):
            now = datetime.now(UTC)
            headers = {
                "Content-Type": "application/json", "webhook-id": identity,
                "webhook-timestamp": str(int(now.timestamp())),
                "webhook-signature": signer(receiver.secret).sign(identity, now, body.decode()),
            }  # fmt: skip
            try:
                status = (await http.post(receiver.url, content=body, headers=headers)).status_code
            except (httpx2.HTTPError, httpx2.InvalidURL, OSError) as e:
                status, why = 0, type(e).__name__
            else:
                why = f"status {status}"
            if 200 <= status < 300:
                return True
            again = status == 0 or status >= 500 or status in (408, 425, 429)
            _log.warning("webhook refused", receiver=receiver.name, why=why, again=again and pause_s is not None)
            if not again or pause_s is None:
                return False
            await asyncio.sleep(pause_s)
        return False
