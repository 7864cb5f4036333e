"""JWTs of an OAuth server: audience, issuer, expiry, scope and subject must all be valid."""

from __future__ import annotations

import functools
import json
import socket
import time
from collections.abc import Iterator
from typing import Any

import httpx2
import jwt
import pytest
from cryptography.hazmat.primitives.asymmetric import rsa
from starlette.applications import Starlette
from starlette.responses import JSONResponse
from starlette.routing import Route

from agentrob.config.mcp import McpConfig
from agentrob.mcp.client import ForumClient
from agentrob.mcp.forum.http import make_app
from agentrob.mcp.forum.identity import Identity, Rights
from tests.mcp.forum.inside import memory_world
from tests.mcp.serving import serving

LIST = {"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": {
    "protocolVersion": "2025-11-25", "capabilities": {}, "clientInfo": {"name": "t", "version": "1"}}}  # fmt: skip


@functools.cache
def private_key(name: str) -> rsa.RSAPrivateKey:
    """The key of this name; made at the first use, since every worker of a run imports this module."""
    return rsa.generate_private_key(public_exponent=65537, key_size=2048)


class Served:
    """An MCP server at `url` that trusts the issuer at `issuer`."""

    def __init__(self, url: str, issuer: str) -> None:
        self.url, self.issuer = url, issuer

    def token(self, key: str | None = "", algorithm: str = "RS256", **changes: Any) -> str:
        now = int(time.time())
        claims = {"iss": self.issuer, "aud": self.url, "sub": "user-1", "exp": now + 300, "scope": "forum profile"}
        claims = {k: v for k, v in (claims | changes).items() if v is not None}
        signed_with = private_key(key or "") if algorithm == "RS256" else key
        return jwt.encode(claims, signed_with, algorithm=algorithm, headers={"kid": "k1"})

    def status(self, token: str) -> int:
        headers = {"Accept": "application/json, text/event-stream", "Authorization": f"Bearer {token}"}
        return httpx2.post(self.url, json=LIST, headers=headers, timeout=60).status_code


@pytest.fixture(scope="module")
def served() -> Iterator[Served]:
    def jwks(_: Any) -> JSONResponse:
        public = json.loads(jwt.algorithms.RSAAlgorithm.to_jwk(private_key("").public_key()))
        return JSONResponse({"keys": [public | {"kid": "k1", "use": "sig", "alg": "RS256"}]})

    keys, listener = socket.create_server(("127.0.0.1", 0)), socket.create_server(("127.0.0.1", 0))
    issuer = f"http://127.0.0.1:{keys.getsockname()[1]}"
    port = listener.getsockname()[1]
    users = {"alice": (Identity("alice", memory_world().sign_in("alice"), Rights(True)), "", "user-1")}
    app, _ = make_app(McpConfig(listen=f"127.0.0.1:{port}", issuer=issuer), users, port)
    with serving(Starlette(routes=[Route("/.well-known/jwks.json", jwks)]), keys), serving(app, listener):
        yield Served(f"http://127.0.0.1:{port}/mcp", issuer)


async def test_an_oauth_token_signs_its_subject_in(served: Served) -> None:
    async with ForumClient.connect(served.url, served.token()) as client:
        assert (await client.create_topic("robots", "A title", "hello")).post.author.name == "alice"


@pytest.mark.parametrize(
    "changes",
    [
        {"aud": "http://127.0.0.1:1/mcp"}, {"aud": None}, {"iss": "http://127.0.0.1:1"}, {"sub": "user-2"},
        {"sub": None}, {"exp": 1}, {"exp": None}, {"scope": "profile"}, {"scope": None}, {"key": "other"},
        {"key": "a-shared-secret-of-enough-length-for-hmac", "algorithm": "HS256"}, {"key": None, "algorithm": "none"},
    ],
    ids=lambda changes: "-".join(f"{k}={v}" for k, v in changes.items()),
)  # fmt: skip
def test_law_1_any_other_token_is_refused(served: Served, changes: dict[str, Any]) -> None:
    assert served.status(served.token(**changes)) == 401


def test_a_request_without_a_token_is_told_where_to_get_one(served: Served) -> None:
    refused = httpx2.post(served.url, json=LIST, headers={"Accept": "application/json, text/event-stream"}, timeout=60)
    assert refused.status_code == 401
    where = refused.headers["www-authenticate"].partition('resource_metadata="')[2].partition('"')[0]
    told = httpx2.get(where, timeout=60).json()
    assert (told["resource"], [u.rstrip("/") for u in told["authorization_servers"]]) == (served.url, [served.issuer])
