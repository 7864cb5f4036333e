"""What `agentrob init` is to set up, from its dialogue or its options."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from agentrob.config.section import DEFAULT_LISTEN


class Services(StrEnum):
    """What runs the processes: nothing, systemd for this user or for the machine, or Docker Compose."""

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
