"""Webhooks that come in: whether they are signed with our secret.

What comes in is never believed: it only says that the forum should be asked now.
"""

from __future__ import annotations

import hashlib
import hmac
import time
from collections.abc import Mapping
from typing import Literal

from agentrob.errors import ServiceError
from agentrob.process.webhooks import signature

#: A Standard Webhooks delivery may be so old, in seconds.
TOLERANCE_S = 300.0


def verify(kind: Literal["discourse", "standard"], body: bytes, headers: Mapping[str, str], secret: str) -> None:
    """Nothing when the body is signed with the secret; else `ServiceError` 401."""
    if kind == "discourse":
        given = [headers.get("x-discourse-event-signature", "")]
        wanted = "sha256=" + hmac.new(secret.encode(), body, hashlib.sha256).hexdigest()
    else:
        sent, identity = headers.get("webhook-timestamp", ""), headers.get("webhook-id", "")
        if not sent.isascii() or not sent.isdigit() or abs(time.time() - int(sent[:12])) > TOLERANCE_S:
            raise ServiceError(401, "bad_signature", "the webhook has no timestamp of these minutes")
        given, wanted = headers.get("webhook-signature", "").split(" "), signature(identity, sent, body, secret)
    if not secret or not any(hmac.compare_digest(g.encode(), wanted.encode()) for g in given[:10]):
        raise ServiceError(401, "bad_signature", "the webhook is not signed with our secret")
