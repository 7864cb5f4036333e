"""The `[service]` table (an agent as an HTTP service) and the `[mcp_robot]` table (such services as MCP tools).

[service]
listen = "127.0.0.1:8089"

[service.tokens.planner]      # a client, its scopes, and its account on the forum
token_env = "PLANNER_TOKEN"
scopes = ["look", "preview", "command", "stop"]
forum_token_env = "PLANNER_FORUM_TOKEN"

[service.hooks_in.forum]      # the forum reports new posts
kind = "discourse"
secret_env = "FORUM_HOOK_SECRET"

[service.hooks_out.planner]   # receives a webhook when a command has ended
url = "https://planner.example.org/ended"
secret_env = "PLANNER_HOOK_SECRET"

[mcp_robot]                   # off until a service is configured
submit = true

[mcp_robot.services.quadruped]
url = "http://127.0.0.1:8089"
token_env = "QUADRUPED_TOKEN"
"""

from __future__ import annotations

from typing import Annotated, Literal, Self
from urllib.parse import urlsplit

from pydantic import Field, field_validator, model_validator

from agentrob.config.section import Listening, Name, Section, ServerAddress, Variable

Scope = Literal["look", "preview", "command", "stop"]
_Variable = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]{0,63}$")]


class ServiceTokenConfig(Section):
    """One client. The variable that `token_env` names holds its token of at least 16 characters.

    `scopes` say what it may do: `look` allows reads, `preview` a plan without execution, `command` to submit and
    cancel commands, `stop` to stop the robot. Commands are posted by the account of the token in `forum_token_env`,
    with that account's rights.
    """

    token_env: _Variable
    scopes: tuple[Scope, ...]
    forum_token_env: Variable = ""

    @model_validator(mode="after")
    def _has_account(self) -> Self:
        if {"preview", "command"} & set(self.scopes) and not self.forum_token_env:
            raise ValueError("the scopes preview and command need forum_token_env, the account that posts the command")
        return self


class HookInConfig(Section):
    """An incoming webhook. `kind` is its signature: `discourse`, or `standard` for Standard Webhooks.

    The variable that `secret_env` names holds the secret.
    """

    kind: Literal["discourse", "standard"] = "standard"
    secret_env: _Variable


class HookOutConfig(Section):
    """A receiver of webhooks at `url`, signed as Standard Webhooks with the secret in the variable `secret_env`."""

    url: str
    secret_env: _Variable

    @field_validator("url")
    @classmethod
    def _is_address(cls, url: str) -> str:
        parts = urlsplit(url)
        if parts.scheme not in ("http", "https") or not parts.hostname or parts.username:
            raise ValueError("must be http(s)://host[:port][/path]")
        return url


class ServiceConfig(Listening):
    """The address and the clients of an agent's HTTP service.

    `listen` must be on this machine unless `allow_remote` is set (then put TLS in front of it). `hosts` are host names
    that requests may use in addition to the listen address. With `loop = false` the agent reads the forum only on
    `scan`, on a webhook, and while the robot moves. `requests_per_minute` limits each token; stops are exempt.
    """

    listen: str = "127.0.0.1:8089"
    hosts: tuple[str, ...] = ()
    loop: bool = True
    requests_per_minute: Annotated[int, Field(ge=1)] = 600
    tokens: dict[Name, ServiceTokenConfig] = Field(default_factory=dict)
    hooks_in: dict[Name, HookInConfig] = Field(default_factory=dict)
    hooks_out: dict[Name, HookOutConfig] = Field(default_factory=dict)


class RobotServiceConfig(Section):
    """The `url` of a robot's HTTP service. The variable that `token_env` names holds the MCP server's token for it."""

    url: ServerAddress
    token_env: _Variable


class McpRobotConfig(Listening):
    """The MCP server of robots, a client of their HTTP services with its own tokens. Off until a service is configured.

    The tools to look and to stop are always available; the owner allows `preview` and `submit` (which includes
    cancelling). `pictures_per_minute` limits the pictures of each robot. Over HTTP it listens on `listen` and accepts
    the token in the variable that `token_env` names.
    """

    preview: bool = False
    submit: bool = False
    pictures_per_minute: Annotated[int, Field(ge=1, le=150)] = 20
    listen: str = "127.0.0.1:8091"
    token_env: Variable = ""
    services: dict[Name, RobotServiceConfig] = Field(default_factory=dict)
