"""The `[mcp]` table: the forum as tools for MCP clients.

[mcp]                         # read-only by default
write = true
toolsets = ["core", "social"]

[mcp.users.planner]           # a user over HTTP, and its account on the forum
token_env = "PLANNER_MCP_TOKEN"
forum_token_env = "PLANNER_FORUM_TOKEN"
write = true
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from agentrob.config.section import Address, Name, Section, Variable

Toolset = Literal["core", "social", "admin"]


class McpUserConfig(Section):
    """A forum account that the MCP server may act as.

    `forum_token_env` names the variable of its forum token, with which a stdio client may choose it (`login_account`).
    To connect over HTTP it needs `token_env` (the variable of a static token of at least 16 characters) or `subject`
    (its subject at the OAuth server); `write` and `toolsets` then apply to it.
    """

    forum_token_env: Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]{0,63}$")]
    token_env: Variable = ""
    subject: str = ""
    write: bool = False
    toolsets: tuple[Toolset, ...] = ("core", "social")


class McpConfig(Section):
    """The forum's MCP server. `write` and `toolsets` apply to stdio, which uses the account of `[forum]`.

    `listen` is the address for `--http`; `public_url` is the URL that clients use, if it differs (behind a proxy).
    `issuer` is an OAuth authorization server; its JWTs for this server's URL are accepted. `jwks_url` has its keys.
    """

    write: bool = False
    toolsets: tuple[Toolset, ...] = ("core", "social")
    listen: str = "127.0.0.1:8090"
    public_url: Address = ""
    issuer: Address = ""
    jwks_url: Address = ""
    users: dict[Name, McpUserConfig] = Field(default_factory=dict)
