"""Verifies bearer tokens of HTTP clients: static tokens of the configuration, or JWTs of an OAuth server."""

from __future__ import annotations

import asyncio
import hashlib
import hmac
from collections.abc import Mapping
from typing import Any

import structlog
from mcp.server.auth.provider import AccessToken

from agentrob.mcp.forum.identity import Identity

log = structlog.get_logger(__name__)
SCOPE = "forum"
#: Asymmetric signatures only: HMAC and unsigned tokens are refused.
_ALGORITHMS = ["RS256", "RS384", "RS512", "PS256", "PS384", "PS512", "ES256", "ES384", "ES512", "EdDSA"]


class BearerTokenVerifier:
    """Verifies bearer tokens. `client_id` of the result is the user's name in the configuration.

    `users` gives for each name the identity, the static token (or "") and the OAuth subject (or "").
    """

    def __init__(
        self, users: Mapping[str, tuple[Identity, str, str]], resource: str, issuer: str = "", jwks_url: str = ""
    ) -> None:
        self.identities = {name: identity for name, (identity, _, _) in users.items()}
        self._tokens = [(_hash(token), name) for name, (_, token, _) in users.items() if token]
        self._subjects = {subject: name for name, (_, _, subject) in users.items() if subject}
        self._resource, self._issuer = resource, issuer
        self._keys: Any = None
        if issuer:
            from jwt import PyJWKClient

            self._keys = PyJWKClient(jwks_url or f"{issuer}/.well-known/jwks.json", timeout=5, cache_keys=True)

    async def verify_token(self, token: str) -> AccessToken | None:
        """The owner of the token, or None."""
        given, found = _hash(token), None
        for known, name in self._tokens:  # compare with every token, so that the time leaks nothing
            if hmac.compare_digest(known, given):
                found = name
        if found is not None:
            return AccessToken(token="", client_id=found, scopes=[SCOPE], resource=self._resource)
        return (
            await asyncio.to_thread(self._of_jwt, token) if self._keys is not None and token.count(".") == 2 else None
        )

    def _of_jwt(self, token: str) -> AccessToken | None:
        import jwt

        try:
            key = self._keys.get_signing_key_from_jwt(token)
            claims = jwt.decode(
                token,
                key.key,
                algorithms=_ALGORITHMS,
                audience=self._resource,
                issuer=self._issuer,
                options={"require": ["exp", "iss", "aud", "sub"]},
            )
        except jwt.PyJWTError as e:
            log.info("mcp.token_refused", error=type(e).__name__)
            return None
        name = self._subjects.get(str(claims["sub"]))
        scopes = str(claims.get("scope", "")).split()
        if name is None or SCOPE not in scopes:
            return None
        return AccessToken(
            token="",
            client_id=name,
            scopes=scopes,
            expires_at=int(claims["exp"]),
            resource=self._resource,
            subject=str(claims["sub"]),
            claims={"iss": self._issuer},
        )


def _hash(token: str) -> bytes:
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).digest()
