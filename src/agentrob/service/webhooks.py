"""Verify the signatures of incoming webhooks.

Their content is not used: a webhook only causes the forum to be read.
"""

from __future__ import annotations

import hashlib
import hmac
from collections.abc import Mapping
from typing import Literal

from standardwebhooks import WebhookVerificationError

from agentrob.errors import ServiceError
from agentrob.process.webhooks import signer


def verify(kind: Literal["discourse", "standard"], body: bytes, headers: Mapping[str, str], secret: str) -> None:
    """Raise `ServiceError` 401 unless the body is signed with the secret, and if Standard Webhooks, in the last 5
    minutes.
    """
    if kind == "discourse":
        given = headers.get("x-discourse-event-signature", "")
        wanted = "sha256=" + hmac.new(secret.encode(), body, hashlib.sha256).hexdigest()
        if not secret or not hmac.compare_digest(given.encode(), wanted.encode()):
            raise ServiceError(401, "bad_signature", "the webhook is not signed with our secret")
        return
    try:
        signer(secret).verify(body, dict(headers), json_parse=False)
    except (WebhookVerificationError, ValueError):  # ValueError: a header or the body cannot be decoded
        message = "the webhook is not signed with our secret, or its timestamp is more than 5 minutes off"
        raise ServiceError(401, "bad_signature", message) from None
