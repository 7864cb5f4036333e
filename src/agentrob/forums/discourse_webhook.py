"""Whether a webhook was sent by the Discourse that shares a secret with us (pure)."""

from __future__ import annotations

import hashlib
import hmac
from collections.abc import Mapping
from dataclasses import dataclass

from agentrob.errors import ForumDenied

SIGNATURE = "X-Discourse-Event-Signature"


@dataclass(frozen=True, slots=True)
class Delivery:
    """A webhook's envelope. `id` is the same when Discourse tries again (up to four times): take each only once."""

    id: str
    type: str
    event: str


def verify(body: bytes, headers: Mapping[str, str], secret: str) -> Delivery:
    """The delivery, when `body` (the raw bytes, before any parsing) is signed with the secret; else `ForumDenied`.

    An empty secret verifies nothing: Discourse sends no signature then.
    """
    found = {name.lower(): value for name, value in headers.items()}
    signature = found.get(SIGNATURE.lower(), "")
    wanted = "sha256=" + hmac.new(secret.encode(), body, hashlib.sha256).hexdigest()
    if not secret or not hmac.compare_digest(signature.encode(), wanted.encode()):
        raise ForumDenied(f"the webhook's {SIGNATURE} is not that of our secret")
    prefix = "x-discourse-event"
    return Delivery(found.get(f"{prefix}-id", ""), found.get(f"{prefix}-type", ""), found.get(prefix, ""))
