"""The `[service]` table: the agent of one robot as an HTTP service; and `[mcp_robot]`: such services as MCP tools.

[service]
listen = "127.0.0.1:8089"

[service.tokens.planner]      # who may use it, for what, and who that is on the forum
token_env = "PLANNER_TOKEN"
scopes = ["look", "preview", "command", "stop"]
forum_token_env = "PLANNER_FORUM_TOKEN"

[service.hooks_in.forum]      # the forum says that something was written
kind = "discourse"
secret_env = "FORUM_HOOK_SECRET"

[service.hooks_out.planner]   # told when a command has ended
url = "https://planner.example.org/ended"
secret_env = "PLANNER_HOOK_SECRET"

[mcp_robot]                   # off until a service is named
submit = true

[mcp_robot.services.quadruped]
url = "http://127.0.0.1:8089"
token_env = "QUADRUPED_TOKEN"
"""

from __future__ import annotations

from typing import Annotated, Literal, Self
from urllib.parse import urlsplit

from pydantic import Field, field_validator, model_validator

from agentrob.config.section import Name, Section
from agentrob.process.listen import is_loopback, parse_listen

Scope = Literal["look", "preview", "command", "stop"]
_Variable = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]{0,63}$")]


class ServiceTokenConfig(Section):
    """One caller. Its token, of at least 16 characters, is in the variable that `token_env` names.

    `look` reads; `preview` asks what would be done; `command` posts and takes back; `stop` stops. What it posts is
    posted by the account whose forum token is in `forum_token_env`, and has the rights of that account.
    """

    token_env: _Variable
    scopes: tuple[Scope, ...]
    forum_token_env: Annotated[str, Field(pattern=r"^([A-Za-z_][A-Za-z0-9_]{0,63})?$")] = ""

    @model_validator(mode="after")
    def _is_somebody(self) -> Self:
        if {"preview", "command"} & set(self.scopes) and not self.forum_token_env:
            raise ValueError("the scopes preview and command need forum_token_env: whose rights count, and who posts")
        return self


class HookInConfig(Section):
    """A webhook that may call us. `discourse` is Discourse's own signature, `standard` that of Standard Webhooks."""

    kind: Literal["discourse", "standard"] = "standard"
    secret_env: _Variable


class HookOutConfig(Section):
    """Who is told when a command has ended, signed as Standard Webhooks are."""

    url: str
    secret_env: _Variable

    @field_validator("url")
    @classmethod
    def _is_address(cls, url: str) -> str:
        parts = urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname or parts.username:
            raise ValueError("must be http(s)://host[:port][/path]")
        return url


class ServiceConfig(Section):
    """Where it listens and who may use it.

    `listen` is on this machine only unless `allow_remote` is set (then put TLS in front of it); `hosts` are the names
    by which it may be called besides its address. `loop = false`: the forum is read only when `scan` or a webhook says
    so, and while the robot moves. `requests_per_minute` bounds each token; stops are exempt.
    """

    listen: str = "127.0.0.1:8089"
    allow_remote: bool = False
    hosts: tuple[str, ...] = ()
    loop: bool = True
    requests_per_minute: Annotated[int, Field(ge=1)] = 600
    tokens: dict[Name, ServiceTokenConfig] = Field(default_factory=dict)
    hooks_in: dict[Name, HookInConfig] = Field(default_factory=dict)
    hooks_out: dict[Name, HookOutConfig] = Field(default_factory=dict)

    @property
    def address(self) -> tuple[str, int]:
        """Host and port."""
        return parse_listen(self.listen)

    @model_validator(mode="after")
    def _is_on_this_machine(self) -> Self:
        _check_listen(self.listen, self.allow_remote)
        return self


class RobotServiceConfig(Section):
    """Where a robot's HTTP service is, and the variable with the token that it gave to the MCP server."""

    url: str
    token_env: _Variable

    @field_validator("url")
    @classmethod
    def _is_plain(cls, url: str) -> str:
        parts = urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname or parts.username or parts.query:
            raise ValueError("must be http(s)://host[:port][/path]")
        return url.rstrip("/")


class McpRobotConfig(Section):
    """The robots as tools for an MCP client: a client of their HTTP services, with tokens of its own. Off until a
    service is named. Looking and stopping are always there; `preview` and `submit` (which may also take back) are the
    owner's to allow. `pictures_per_minute` bounds what the client sees of each robot. Over HTTP it serves on `listen`
    whoever has the token that is in the variable `token_env`.
    """

    preview: bool = False
    submit: bool = False
    pictures_per_minute: Annotated[int, Field(ge=1, le=150)] = 20
    listen: str = "127.0.0.1:8091"
    allow_remote: bool = False
    token_env: Annotated[str, Field(pattern=r"^([A-Za-z_][A-Za-z0-9_]{0,63})?$")] = ""
    services: dict[Name, RobotServiceConfig] = Field(default_factory=dict)

    @property
    def address(self) -> tuple[str, int]:
        """Host and port."""
        return parse_listen(self.listen)

    @model_validator(mode="after")
    def _is_on_this_machine(self) -> Self:
        _check_listen(self.listen, self.allow_remote)
        return self


def _check_listen(listen: str, allow_remote: bool) -> None:
    host, _ = parse_listen(listen)
    if not allow_remote and not is_loopback(host):
        raise ValueError("listen is reachable from other machines; set allow_remote = true if that is meant")
