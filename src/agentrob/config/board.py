"""The `[board]` table: the embedded forum, when this machine runs it."""

from __future__ import annotations

import ipaddress
from typing import Annotated

from pydantic import Field, field_validator

from agentrob.config.section import DEFAULT_LISTEN, Name, Section
from agentrob.config.service import HookOutConfig
from agentrob.process.listen import parse_listen


class BoardLimitsConfig(Section):
    """How much one account may do in an hour; 0 means no such limit. Stops and robots' own posts are exempt.

    As often as it may write `posts` it may edit them or choose tags. `commands` are posts that mention a robot,
    `sign_ups` new accounts from one address.
    """

    posts: Annotated[int, Field(ge=0)] = 120
    commands: Annotated[int, Field(ge=0)] = 60
    uploads: Annotated[int, Field(ge=0)] = 60
    sign_ups: Annotated[int, Field(ge=0)] = 5


class BoardRetentionConfig(Section):
    """How long the forum keeps what only tells who listens that something happened.

    An event is let go of when it is older than `event_days` and not among the newest `events`. Whoever was away for
    longer than that begins anew. Posts, earlier texts, records of commands and the audit log are kept for ever.
    """

    event_days: Annotated[float, Field(ge=8, le=3650)] = 30.0
    events: Annotated[int, Field(ge=1)] = 10_000


class BoardConfig(Section):
    """The embedded forum. `base_url` is what browsers see; https there makes cookies Secure.

    Behind a reverse proxy it must be set: whoever comes through the proxy seems to come from this machine. Whose
    `X-Forwarded-For` is believed stands in `trusted_proxies`, as addresses or networks; without a list, that of this
    machine when `base_url` is https. `limits` hold unless the forum is for this machine only and none are given.
    `public_read`: guests read the boards that are open to them.
    `semantic`: posts are found by what they mean too; needs the extra `agentrob[semantic]`.
    `hooks` are told by webhook when something happens, so that nobody need poll.
    """

    listen: str = DEFAULT_LISTEN
    base_url: str = ""
    database: str = ""
    title: str = "AgentRob"
    hooks: dict[Name, HookOutConfig] = Field(default_factory=dict)
    sign_up: bool | None = None
    public_read: bool = False
    semantic: bool = False
    trusted_proxies: tuple[str, ...] | None = None
    limits: BoardLimitsConfig | None = None
    retention: BoardRetentionConfig = Field(default_factory=BoardRetentionConfig)

    @property
    def address(self) -> tuple[str, int]:
        """Host and port."""
        return parse_listen(self.listen)

    @field_validator("listen")
    @classmethod
    def _is_host_and_port(cls, listen: str) -> str:
        parse_listen(listen)
        return listen

    @field_validator("trusted_proxies")
    @classmethod
    def _are_networks(cls, proxies: tuple[str, ...] | None) -> tuple[str, ...] | None:
        for proxy in proxies or ():
            try:
                ipaddress.ip_network(proxy)
            except ValueError:
                raise ValueError("must be addresses or networks such as 10.0.0.2 or 10.0.0.0/24") from None
        return proxies
