"""Whose certificates are believed, for every connection to a server."""

from __future__ import annotations

import ssl
from functools import cache

import httpx2


@cache
def tls() -> ssl.SSLContext:
    """Those that SSL_CERT_FILE or SSL_CERT_DIR name, else the library's own. Reading them takes a moment, so once will
    do."""
    return httpx2.create_ssl_context()
