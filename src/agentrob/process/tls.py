"""The TLS context of all outgoing connections."""

from __future__ import annotations

import ssl
from functools import cache

import httpx2


@cache
def tls() -> ssl.SSLContext:
    """Trusts the certificates of SSL_CERT_FILE or SSL_CERT_DIR, else httpx2's own. Cached, since loading takes time."""
    return httpx2.create_ssl_context()
