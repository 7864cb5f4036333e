"""One `agentrob.toml` and the environment for secrets; an unknown key or a wrong value is refused with what is valid.

[board]                       # the embedded forum, when this machine runs it
listen = "127.0.0.1:8088"

[forum]                       # where the agents read and write
kind = "board"
url = "http://127.0.0.1:8088"

[robots.quadruped]            # one table per robot; the name is the robot's account and its driver's name
model = "go2"
interface = "lo"
domain = 1
"""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from agentrob.errors import ConfigError

DEFAULT_LISTEN = "127.0.0.1:8088"
Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_-]{1,31}$")]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class BoardConfig(_Section):
    """The embedded forum. `base_url` is what browsers see; https there makes cookies Secure.

    Behind a reverse proxy it must be set: whoever comes through the proxy seems to come from this machine.
    """

    listen: str = DEFAULT_LISTEN
    base_url: str = ""
    database: str = ""
    title: str = "AgentRob"
    sign_up: bool | None = None


class ForumConfig(_Section):
    """Where agents read and write. The secret is in the environment, in the variable that `token_env` names."""

    kind: str = "board"
    url: str = "http://" + DEFAULT_LISTEN
    token_env: str = "AGENTROB_TOKEN"


class FenceConfig(_Section):
    """A rectangle around the robot's home, in metres (x forward at home, y left)."""

    x_min_m: float = -5.0
    x_max_m: float = 5.0
    y_min_m: float = -5.0
    y_max_m: float = 5.0


class LimitsConfig(_Section):
    """Bounds that commands may not exceed (law 10)."""

    speed_mps: Annotated[float, Field(gt=0, le=1.5)] = 0.5
    turn_dps: Annotated[float, Field(gt=0, le=90)] = 45.0
    step_m: Annotated[float, Field(gt=0)] = 5.0
    step_deg: Annotated[float, Field(gt=0)] = 360.0
    command_m: Annotated[float, Field(gt=0)] = 10.0
    command_s: Annotated[float, Field(gt=0)] = 60.0
    command_steps: Annotated[int, Field(ge=1)] = 10


class RatesConfig(_Section):
    """How often one account may command one robot; stops are exempt. 0 means no such limit.

    A command within `cooldown_s` of the account's last one waits for its time; beyond `commands_per_hour`, or when
    `waiting` commands of the account are in line already, it is refused and told when to come again.
    """

    commands_per_hour: Annotated[int, Field(ge=0)] = 60
    cooldown_s: Annotated[int, Field(ge=0, le=3600)] = 2
    waiting: Annotated[int, Field(ge=0)] = 5


class RobotConfig(_Section):
    """One robot: how its driver reaches it, what may command it where, and what its agent does.

    `interface` and `domain` are DDS settings. `step_length_m`: how long one of its steps is, where you measured that
    ("walk two steps" is asked back otherwise). `home_on_start`: the driver sets home when it starts; for simulation.
    `allow_unknown_ranges`: the owner's consent to move at 0.2 m/s without range readings (law 8).
    `moderators` are the handles that are told of the third stop within 5 minutes, besides the owner's.
    `room_camera` is the snapshot URL of a camera that sees the robot, `room_reset` a URL that resets a simulated room.
    """

    model: str = "go2"
    interface: str = "lo"
    domain: Annotated[int, Field(ge=0, le=230)] = 0
    simulated: bool = False
    owner: str = ""
    moderators: tuple[str, ...] = ()
    mentions: tuple[str, ...] = ()
    boards: tuple[str, ...] = ("robots",)
    mind: str = "rules"
    poll_s: Annotated[float, Field(gt=0)] = 30.0
    step_length_m: Annotated[float, Field(gt=0, le=2)] | None = None
    max_post_age_s: Annotated[float, Field(gt=0)] = 120.0
    queue_expiry_s: Annotated[float, Field(gt=0)] = 600.0
    home_on_start: bool = False
    allow_unknown_ranges: bool = False
    allow_flip: bool = False
    room_camera: str = ""
    room_reset: str = ""
    fence: FenceConfig = FenceConfig()
    limits: LimitsConfig = LimitsConfig()
    rates: RatesConfig = RatesConfig()
    options: dict[str, Any] = {}


class Config(_Section):
    """The whole file. `data` is where databases, journals and pictures are kept."""

    data: str = ""
    board: BoardConfig = BoardConfig()
    forum: ForumConfig = ForumConfig()
    robots: dict[Name, RobotConfig] = {}

    def robot(self, name: str) -> RobotConfig:
        """Settings of one robot; a `ConfigError` names those that are there."""
        if name not in self.robots:
            known = ", ".join(sorted(self.robots)) or "none"
            raise ConfigError(f"no robot named {name!r} in the configuration; there are: {known}")
        return self.robots[name]

    def write(self, path: Path, remark: str = "") -> None:
        """Write it as TOML, for a process that we start or for people."""
        import tomli_w

        text = f"# {remark}\n" if remark else ""
        path.write_text(text + tomli_w.dumps(self.model_dump(mode="json", exclude_defaults=True)), encoding="utf-8")

    @property
    def data_dir(self) -> Path:
        return Path(self.data).expanduser() if self.data else default_data_dir()


def default_data_dir() -> Path:
    """`$AGENTROB_DATA`, or `agentrob` in the user's XDG data folder."""
    if given := os.environ.get("AGENTROB_DATA"):
        return Path(given)
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local/share") / "agentrob"


def runtime_dir() -> Path:
    """A folder for sockets, only for this user, made when missing. Short, since socket paths are."""
    given = os.environ.get("AGENTROB_RUNTIME") or os.environ.get("XDG_RUNTIME_DIR")
    folder = Path(given) / "agentrob" if given else Path(f"/tmp/agentrob-{os.getuid()}")
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    if folder.stat().st_uid != os.getuid():
        raise ConfigError(f"{folder} belongs to another user; set AGENTROB_RUNTIME to a folder of your own")
    return folder


def load(path: Path | None = None) -> Config:
    """Read the file (default `./agentrob.toml` when it is there). Raises `ConfigError`."""
    if path is None:
        path = Path("agentrob.toml")
        if not path.exists():
            return Config()
    try:
        raw = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as e:
        raise ConfigError(f"cannot read {path}: {e.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as e:
        raise ConfigError(f"{path} is not valid TOML: {e}") from None
    return parse(raw, str(path))


def parse(raw: dict[str, Any], source: str = "configuration") -> Config:
    """Check a configuration that is already read."""
    try:
        return Config.model_validate(raw)
    except ValidationError as e:
        raise ConfigError(f"{source}: " + "; ".join(_explain(x) for x in e.errors())) from None


def _explain(error: Any) -> str:
    where = ".".join(str(p) for p in error["loc"])
    if error["type"] != "extra_forbidden":
        return f"{where}: {error['msg']} (found {error['input']!r})"
    section: type[BaseModel] = Config
    for part in error["loc"][:-1]:
        field = section.model_fields.get(str(part))
        kind = field.annotation if field else RobotConfig
        section = kind if isinstance(kind, type) and issubclass(kind, BaseModel) else RobotConfig
    return f"{where} is not a setting; valid here: {', '.join(sorted(section.model_fields))}"
