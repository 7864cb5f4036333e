"""Verifies the signatures of incoming webhooks.

Their content is not used: a webhook only causes the forum to be read.
"""

from __future__ import annotations

import hashlib
import hmac
import time
from collections.abc import Mapping
from typing import Literal

from agentrob.errors import ServiceError
from agentrob.process.webhooks import signature

#: How far the timestamp of a Standard Webhooks delivery may be from now.
TOLERANCE_S = 300.0


def verify(kind: Literal["discourse", "standard"], body: bytes, headers: Mapping[str, str], secret: str) -> None:
    """Raise `ServiceError` 401 unless the body is signed with the secret."""
    if kind == "discourse":
        given = [headers.get("x-discourse-event-signature", "")]
        wanted = "sha256=" + hmac.new(secret.encode(), body, hashlib.sha256).hexdigest()
    else:
        sent, identity = headers.get("webhook-timestamp", ""), headers.get("webhook-id", "")
        if not sent.isascii() or not sent.isdigit() or abs(time.time() - int(sent[:12])) > TOLERANCE_S:
            raise ServiceError(401, "bad_signature", "the webhook's timestamp is missing or more than 5 minutes off")
        given, wanted = headers.get("webhook-signature", "").split(" "), signature(identity, sent, body, secret)
    if not secret or not any(hmac.compare_digest(g.encode(), wanted.encode()) for g in given[:10]):
        raise ServiceError(401, "bad_signature", "the webhook is not signed with our secret")
