"""The `[board]` table: the embedded forum, if this machine runs it.

[board]
listen = "127.0.0.1:8088"
"""

from __future__ import annotations

import ipaddress
from typing import Annotated

from pydantic import Field, field_validator

from agentrob.config.section import DEFAULT_LISTEN, Name, Section, WithMetrics
from agentrob.config.service import HookOutConfig
from agentrob.process.listen import parse_listen


class BoardLimitsConfig(Section):
    """Rate limits per account and hour; 0 disables a limit. Stops and posts by robots are exempt.

    `posts` also limits edits and changes of tags, counted separately. `commands` are posts that mention a robot,
    `uploads` are pictures, `sign_ups` are new accounts from one address.
    """

    posts: Annotated[int, Field(ge=0)] = 120
    commands: Annotated[int, Field(ge=0)] = 60
    uploads: Annotated[int, Field(ge=0)] = 60
    sign_ups: Annotated[int, Field(ge=0)] = 5


class BoardRetentionConfig(Section):
    """How long the forum keeps the events of its event stream.

    An event is deleted when it is older than `event_days` and not among the newest `events`. A client that was
    disconnected for longer must reload everything. Posts and their earlier versions, command records and the audit
    log are never deleted. Replays of commands are deleted after `replay_days`.
    """

    event_days: Annotated[float, Field(ge=8, le=3650)] = 30.0
    events: Annotated[int, Field(ge=1)] = 10_000
    replay_days: Annotated[float, Field(gt=0, le=3650)] = 365.0


class BoardConfig(WithMetrics):
    """The embedded forum. `base_url` is the address that browsers see; with https, cookies are Secure.

    `listen` is the host and port of the server, `title` the name of the forum. `database` is the path of a SQLite file,
    by default in the data folder, or the URL of a PostgreSQL database. `sign_up` lets everybody create an account, by
    default only if the forum is reachable from this machine only.

    `base_url` is required behind a reverse proxy, because proxied requests seem to come from this machine.
    `trusted_proxies` are the addresses or networks whose `X-Forwarded-For` is trusted; the default is this machine if
    `base_url` is https, else none. `limits` apply by default unless the forum is reachable from this machine only.
    `public_read` lets guests read the boards that are open to them.
    `semantic` adds search by meaning; it needs the extra `agentrob[semantic]`.
    `hooks` receive a webhook for each event, so that their services need not poll.
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
