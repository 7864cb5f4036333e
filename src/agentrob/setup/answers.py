"""The choices for `agentrob init`, from its dialogue or its options."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from agentrob.config.section import DEFAULT_LISTEN
from agentrob.errors import ConfigError
from agentrob.process.listen import is_free, parse_listen


def check_address(listen: str) -> None:
    """Raise `ConfigError` if the forum cannot listen there now: `agentrob init` would take another program's answer for
    the forum's. Raises `ValueError` for what is not host:port."""
    host, port = parse_listen(listen)
    if port and not is_free(host, port):
        raise ConfigError(f"{listen} is in use, or not an address of this machine; choose another (--listen)")


class Services(StrEnum):
    """The manager of the processes: none, systemd for this user or for the machine, or Docker Compose."""

    NONE = "none"
    USER = "user"
    SYSTEM = "system"
    COMPOSE = "compose"


@dataclass(frozen=True, slots=True)
class RobotAnswers:
    """One robot. A simulated one has no interface; `domain` None chooses a DDS domain."""

    name: str
    model: str = "go2"
    simulated: bool = True
    interface: str = "lo"
    domain: int | None = None


@dataclass(frozen=True, slots=True)
class Answers:
    """Everything. `walk`: let the robot walk at the end, by a post on the forum."""

    admin: str
    config: Path = Path("agentrob.toml")
    title: str = "AgentRob"
    listen: str = DEFAULT_LISTEN
    url: str = ""
    data: str = ""
    database: str = ""
    invites: int = 0
    robot: RobotAnswers | None = None
    services: Services = Services.NONE
    walk: bool = False
