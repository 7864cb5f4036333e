"""The `[mcp]` table: the forum as tools for MCP clients.

[mcp]                         # read-only unless writes are allowed
write = true
toolsets = ["core", "social"]

[mcp.users.planner]           # who may connect by HTTP, and who that is on the forum
token_env = "PLANNER_MCP_TOKEN"
forum_token_env = "PLANNER_FORUM_TOKEN"
write = true
"""

from __future__ import annotations

from typing import Annotated, Literal
from urllib.parse import urlsplit

from pydantic import Field, field_validator

from agentrob.config.section import Name, Section

Toolset = Literal["core", "social", "admin"]
_Variable = Annotated[str, Field(pattern=r"^([A-Za-z_][A-Za-z0-9_]{0,63})?$")]


class McpUserConfig(Section):
    """One account of the forum that the MCP server may act as.

    `forum_token_env` names the variable with its forum token: then `login_account` may choose it over stdio. With
    `token_env` (a static token of at least 16 characters) or `subject` (who the OAuth server says it is) it may
    connect by HTTP, with `write` and `toolsets` of its own.
    """

    forum_token_env: Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]{0,63}$")]
    token_env: _Variable = ""
    subject: str = ""
    write: bool = False
    toolsets: tuple[Toolset, ...] = ("core", "social")


class McpConfig(Section):
    """The MCP servers. `write` and `toolsets` are for stdio, where the account is that of `[forum]`.

    `listen` is where `--http` serves, `public_url` the address that clients use when it is another (behind a proxy).
    `issuer` is an OAuth authorization server whose JWTs for this server's address are taken; `jwks_url` its keys.
    """

    write: bool = False
    toolsets: tuple[Toolset, ...] = ("core", "social")
    listen: str = "127.0.0.1:8090"
    public_url: str = ""
    issuer: str = ""
    jwks_url: str = ""
    users: dict[Name, McpUserConfig] = Field(default_factory=dict)

    @field_validator("public_url", "issuer", "jwks_url")
    @classmethod
    def _is_address(cls, url: str) -> str:
        parts = urlsplit(url)
        if url and (parts.scheme not in ("http", "https") or not parts.hostname or parts.username or parts.query):
            raise ValueError("must be http(s)://host[:port][/path]")
        return url.rstrip("/")
