"""Load agentrob.toml. An unknown key or an invalid value raises an error that says what is valid.

Each table has its own module in this package; its docstring shows an example.
"""

from __future__ import annotations

import os
import tomllib
from contextlib import suppress
from pathlib import Path
from typing import Any, Self, TypeVar, get_args

from pydantic import BaseModel, Field, ValidationError, model_validator

from agentrob.config.board import BoardConfig
from agentrob.config.forum import ForumConfig
from agentrob.config.images import ImagesConfig
from agentrob.config.journal import JournalConfig
from agentrob.config.mcp import McpConfig
from agentrob.config.minds import CHAIN_S, MindConfig
from agentrob.config.robots import RobotConfig
from agentrob.config.section import Name, Section
from agentrob.config.service import McpRobotConfig, ServiceConfig
from agentrob.config.worker import WorkerConfig
from agentrob.errors import ConfigError
from agentrob.process.listen import base_url, parse_listen

AnySection = TypeVar("AnySection", bound=Section)


class Config(Section):
    """The whole file. `data` is the folder for databases, journals and pictures."""

    data: str = ""
    board: BoardConfig = Field(default_factory=BoardConfig)
    forum: ForumConfig = Field(default_factory=ForumConfig)
    images: ImagesConfig = Field(default_factory=ImagesConfig)
    journal: JournalConfig = Field(default_factory=JournalConfig)
    mcp: McpConfig = Field(default_factory=McpConfig)
    mcp_robot: McpRobotConfig = Field(default_factory=McpRobotConfig)
    service: ServiceConfig = Field(default_factory=ServiceConfig)
    robots: dict[Name, RobotConfig] = Field(default_factory=dict)
    minds: dict[Name, MindConfig] = Field(default_factory=dict)
    worker: WorkerConfig = Field(default_factory=WorkerConfig)

    @model_validator(mode="before")
    @classmethod
    def _default_to_embedded_forum(cls, data: Any) -> Any:
        """Set the forum's URL to where the embedded forum listens, unless another forum or URL is configured."""
        if not isinstance(data, dict):
            return data
        forum, board = data.get("forum", {}), data.get("board", {})
        listen = board.get("listen") if isinstance(board, dict) else board.listen
        if isinstance(forum, dict) and isinstance(listen, str) and forum.get("kind", "board") == "board":
            with suppress(ValueError):  # a wrong address is reported where `board` is validated
                data = {**data, "forum": {"url": _local_url(listen), **forum}}
        return data

    @model_validator(mode="after")
    def _check_minds(self) -> Self:
        if "rules" in self.minds:
            raise ValueError("minds.rules is reserved for the built-in mind without a model; choose another name")
        for name, mind in self.minds.items():
            models = mind.fallbacks[:-1] if mind.fallbacks[-1:] == ("rules",) else mind.fallbacks
            if wrong := [other for other in models if other not in self.minds or other == name]:
                known = ", ".join([*sorted(set(self.minds) - {name}), "rules (last)"])
                raise ValueError(f"minds.{name}.fallbacks: invalid {', '.join(wrong)}; valid: {known}")
            chain_s = sum(self.minds[other].total_s for other in (name, *models))
            if chain_s > CHAIN_S:
                raise ValueError(
                    f"total_s of minds.{name} and its fallbacks add up to {chain_s:g} s; valid: at most {CHAIN_S:g} s"
                )
        return self

    def robot(self, name: str) -> RobotConfig:
        """The settings of one robot. Raises `ConfigError` with the names of all configured robots."""
        if name not in self.robots:
            known = ", ".join(sorted(self.robots)) or "none"
            raise ConfigError(f"robot {name!r} is not configured; configured robots: {known}")
        return self.robots[name]

    def write(self, path: Path, comment: str = "") -> None:
        """Write it as TOML, with a comment in the first line; values that are defaults are left out."""
        import tomli_w

        text = f"# {comment}\n" if comment else ""
        path.write_text(text + tomli_w.dumps(self.model_dump(mode="json", exclude_defaults=True)), encoding="utf-8")

    @property
    def data_dir(self) -> Path:
        return Path(self.data).expanduser() if self.data else default_data_dir()


def _local_url(listen: str) -> str:
    """The URL by which this machine reaches a listen address: loopback if it listens on every interface."""
    host, port = parse_listen(listen)
    return base_url("127.0.0.1" if host in ("0.0.0.0", "::") else host, port)


def default_data_dir() -> Path:
    """`$AGENTROB_DATA`, else `agentrob` in the user's XDG data folder."""
    if given := os.environ.get("AGENTROB_DATA"):
        return Path(given)
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local/share") / "agentrob"


def runtime_dir() -> Path:
    """The folder for sockets, private to this user; created if missing. Its path is short: socket paths are limited."""
    given = os.environ.get("AGENTROB_RUNTIME") or os.environ.get("XDG_RUNTIME_DIR")
    folder = Path(given) / "agentrob" if given else Path(f"/tmp/agentrob-{os.getuid()}")
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    if folder.stat().st_uid != os.getuid():
        raise ConfigError(f"{folder} belongs to another user; set AGENTROB_RUNTIME to a folder of your own")
    return folder


def load(path: Path | None = None) -> Config:
    """Read the file; the default is `./agentrob.toml`, or an empty configuration without one. Raises `ConfigError`."""
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
    """Validate a configuration that was read from `source`. Raises `ConfigError`."""
    try:
        return Config.model_validate(raw)
    except ValidationError as e:
        raise ConfigError(f"{source}: " + "; ".join(_explain(x, Config) for x in e.errors())) from None


def changed(settings: AnySection, source: str, **changes: Any) -> AnySection:
    """A table with other values, given by `source` (an option). Raises `ConfigError`."""
    try:
        return type(settings).model_validate({**settings.model_dump(), **changes})
    except ValidationError as e:
        raise ConfigError(f"{source}: " + "; ".join(_explain(x, type(settings)) for x in e.errors())) from None


#: Settings that may hold a secret by mistake: messages do not repeat their values.
_REDACTED = ("key_env", "secret_env", "token_env", "driver_token_env", "base_url", "endpoint")


def _explain(error: Any, root: type[BaseModel]) -> str:
    where = ".".join(str(p) for p in error["loc"])
    message = error["msg"].removeprefix("Value error, ")
    if error["type"] == "extra_forbidden":
        return (
            f"{where} is not a setting; valid here: {', '.join(sorted(_section_at(error['loc'], root).model_fields))}"
        )
    secret = bool(error["loc"]) and error["loc"][-1] in _REDACTED
    if secret or not isinstance(error["input"], str | int | float | bool):
        return f"{where}: {message}" if where else message
    return f"{where}: {message} (found {error['input']!r})"


def _section_at(where: tuple[Any, ...], root: type[BaseModel]) -> type[BaseModel]:
    """The model of the table that an unknown key is in."""
    section: type[BaseModel] = root
    kind: Any = root
    for part in where[:-1]:
        field = section.model_fields.get(str(part)) if kind is section else None
        # A table of tables (robots, minds) accepts any key; below it are the settings of one table.
        kind = field.annotation if field else (get_args(kind) or (section,))[-1]
        kinds = [k for k in (kind, *get_args(kind)) if isinstance(k, type) and issubclass(k, BaseModel)]
        if kinds and not str(kind).startswith("dict"):
            section = kind = kinds[0]
    return section
