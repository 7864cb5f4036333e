"""The table `[robots.NAME.options]` of a Reachy Mini: where its daemon is, how fast it moves, its camera, its moves.

[robots.rosie.options]
url = "http://192.168.1.30:8000"
camera = "http://192.168.1.30:8090/snapshot.jpg"
moves.cheer = { dataset = "pollen-robotics/reachy-mini-dances-library", move = "…", words = { en = "cheer" } }
"""

from __future__ import annotations

from typing import Annotated, Literal
from urllib.parse import urlsplit

from pydantic import AfterValidator, Field

from agentrob.config.load import changed
from agentrob.config.robots import RobotConfig
from agentrob.config.section import Section
from agentrob_reachy_mini.pose import Speeds


def _http(url: str) -> str:
    parts = urlsplit(url)
    if parts.scheme not in ("http", "https") or not parts.hostname:
        raise ValueError("not an address: http://HOST:PORT, such as http://127.0.0.1:8000")
    return url.rstrip("/")


Url = Annotated[str, AfterValidator(_http), Field(max_length=200)]
MoveName = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{1,30}$")]


class RecordedMove(Section):
    """A move of a library that the daemon has on its disk, and the words that ask for it. `seconds`: how long it takes
    at most."""

    dataset: Annotated[str, Field(pattern=r"^[\w.-]+/[\w.-]+$")]
    move: Annotated[str, Field(pattern=r"^[\w.-]+$")]
    words: dict[str, str]
    seconds: Annotated[float, Field(gt=0, le=60)] = 15.0


class ReachyOptions(Section):
    """See the module docstring. `head_dps` and `antennas_dps` are the highest speeds of head and antennas in degrees
    per second; that of the body is `limits.turn_dps`. `camera` is the URL of a picture (JPEG) of its camera, where
    there is one: its daemon has none over HTTP."""

    url: Url = "http://127.0.0.1:8000"
    head_dps: Annotated[float, Field(ge=10, le=180)] = 90.0
    antennas_dps: Annotated[float, Field(ge=10, le=360)] = 180.0
    camera: Url | Literal[""] = ""
    moves: dict[MoveName, RecordedMove] = Field(default_factory=dict)

    def speeds(self, turn_dps: float) -> Speeds:
        return Speeds(self.head_dps, turn_dps, self.antennas_dps)


def options_of(settings: RobotConfig) -> ReachyOptions:
    """The validated options of a robot. Raises `ConfigError`, which names what is valid."""
    return changed(ReachyOptions(), "options of a Reachy Mini", **settings.options)
