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

[service.tokens.planner]      # the agent's HTTP service: who may use it, for what
token_env = "PLANNER_TOKEN"
scopes = ["look"]

[minds.clever]                # one table per model; its key is in the environment
provider = "openai"
model = "gpt-5-mini"
"""

from __future__ import annotations

import os
import tomllib
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import BaseModel, Field, ValidationError, field_validator, model_validator

from agentrob.config.board import BoardConfig
from agentrob.config.images import ImagesConfig, plain_address
from agentrob.config.mcp import McpConfig
from agentrob.config.section import DEFAULT_LISTEN, Name, Section
from agentrob.config.service import McpRobotConfig, ServiceConfig
from agentrob.errors import ConfigError
from agentrob.model import ActionClass
from agentrob.process.listen import base_url, parse_listen


class ForumConfig(Section):
    """Where agents read and write. The secret is in the environment, in the variable that `token_env` names.

    `options` are the adapter's own (which groups may do what, how often it may ask); the adapter checks them.
    """

    kind: str = "board"
    url: str = "http://" + DEFAULT_LISTEN
    token_env: str = "AGENTROB_TOKEN"
    options: dict[str, Any] = Field(default_factory=dict)


class FenceConfig(Section):
    """A rectangle around the robot's home, in metres (x forward at home, y left)."""

    x_min_m: float = -5.0
    x_max_m: float = 5.0
    y_min_m: float = -5.0
    y_max_m: float = 5.0


class LimitsConfig(Section):
    """Bounds that commands may not exceed (law 10)."""

    speed_mps: Annotated[float, Field(gt=0, le=1.5)] = 0.5
    turn_dps: Annotated[float, Field(gt=0, le=90)] = 45.0
    step_m: Annotated[float, Field(gt=0)] = 5.0
    step_deg: Annotated[float, Field(gt=0)] = 360.0
    command_m: Annotated[float, Field(gt=0)] = 10.0
    command_s: Annotated[float, Field(gt=0)] = 60.0
    command_steps: Annotated[int, Field(ge=1)] = 10


class RatesConfig(Section):
    """How often one account may command one robot; stops are exempt. 0 means no such limit.

    A command within `cooldown_s` of the account's last one waits for its time; beyond `commands_per_hour`, or when
    `waiting` commands of the account are in line already, it is refused and told when to come again.
    """

    commands_per_hour: Annotated[int, Field(ge=0)] = 60
    cooldown_s: Annotated[int, Field(ge=0, le=3600)] = 2
    waiting: Annotated[int, Field(ge=0)] = 5


class LookConfig(Section):
    """Whether a model may steer the robot by what its camera shows ("walk to the red ball"), and for how much at most.

    Off unless the owner says `allowed = true`; then the robot's mind must be a model with `images`. Each such command
    may take `distance_m` of walking, `degrees` of turning, `calls` of the model's tools, `pictures`, and `seconds` in
    all, thinking included; walks go at `speed_mps` at most. The robot's own limits hold besides.
    """

    allowed: bool = False
    distance_m: Annotated[float, Field(gt=0, le=50)] = 5.0
    degrees: Annotated[float, Field(gt=0, le=3600)] = 720.0
    calls: Annotated[int, Field(ge=1, le=50)] = 12
    pictures: Annotated[int, Field(ge=1, le=50)] = 10
    seconds: Annotated[float, Field(gt=0, le=600)] = 120.0
    speed_mps: Annotated[float, Field(ge=0.05, le=1.0)] = 0.3


#: The longest description of what is around a robot.
SCENE_CHARS = 2_000


class RecordingConfig(Section):
    """What is recorded of each command that moves a robot: its path, its speeds, and a short animation in the reply.

    `view` is what the animation shows. `room`: the camera of `room_camera`; `robot`: the robot's own; `path`: the way
    on a map; `none`: no animation. `auto` shows the room where everybody who reads the thread may watch that camera
    live anyway (a forum with pages for robots), else the way: other cameras are shown only where their owner says so.
    Recordings are kept on disk for `keep_days` and up to `keep_mb` per robot, the newest longest; 0 keeps none.
    """

    view: Literal["auto", "room", "robot", "path", "none"] = "auto"
    keep_days: Annotated[float, Field(ge=0, le=3650)] = 30.0
    keep_mb: Annotated[float, Field(ge=0)] = 200.0


class RetentionConfig(Section):
    """How long an agent keeps what became of each command: its row in the journal, its record, the steps' pictures.

    For `days` and up to `commands` commands, the newest longest; records and pictures up to `mb` each. What is younger
    than a day stays in the journal however much it is, and what is open stays however old.
    """

    days: Annotated[float, Field(ge=1, le=3650)] = 30.0
    commands: Annotated[int, Field(ge=1)] = 5000
    mb: Annotated[float, Field(gt=0)] = 200.0


class ApprovalConfig(Section):
    """Which `classes` of action need somebody's approval, besides those that the forum keeps of the robot.

    `who` (the least role, or `owner`) approves, and with `own` also what they asked for themselves, where the forum
    keeps no such rights. An approval is waited for `wait_s` after the post at most, and never beyond `queue_expiry_s`.
    """

    classes: tuple[ActionClass, ...] = ()
    who: Literal["operator", "moderator", "admin", "owner"] = "moderator"
    own: bool = False
    wait_s: Annotated[float, Field(gt=0)] = 600.0


class RobotConfig(Section):
    """One robot: how its driver reaches it, what may command it where, and what its agent does.

    `interface` and `domain` are DDS settings. `step_length_m`: how long one of its steps is, where you measured that
    ("walk two steps" is asked back otherwise). `home_on_start`: the driver sets home when it starts, together with
    `simulated` only; of any other robot the owner sets it (law 9).
    `allow_unknown_ranges`: the owner's consent to move at 0.2 m/s without range readings (law 8).
    `least_battery_percent`: below this no motion begins; a robot that does not tell its charge is moved all the same.
    `moderators` are the handles that are told of the third stop within 5 minutes, besides the owner's.
    `mind` reads its posts: `rules`, or a table of `minds`. `screen`: whether that model also looks at each command that
    the rules allow; `rules` no, `model` yes, and where it does not answer the rules decide alone, `required` yes, and
    where it does not answer nothing moves. `scene`: what is around the robot, in English ("stairs 2 m behind home"), by
    which rules and model judge what is dangerous here. `summary`: it words the reports of what was done, from figures.
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
    screen: Literal["rules", "model", "required"] = "model"
    scene: Annotated[str, Field(max_length=SCENE_CHARS)] = ""
    summary: bool = False
    poll_s: Annotated[float, Field(gt=0)] = 30.0
    step_length_m: Annotated[float, Field(gt=0, le=2)] | None = None
    max_post_age_s: Annotated[float, Field(gt=0)] = 120.0
    queue_expiry_s: Annotated[float, Field(gt=0)] = 600.0
    home_on_start: bool = False
    allow_unknown_ranges: bool = False
    least_battery_percent: Annotated[float, Field(ge=0, le=100)] = 15.0
    allow_flip: bool = False
    room_camera: str = ""
    room_reset: str = ""
    fence: FenceConfig = Field(default_factory=FenceConfig)
    limits: LimitsConfig = Field(default_factory=LimitsConfig)
    rates: RatesConfig = Field(default_factory=RatesConfig)
    approval: ApprovalConfig = Field(default_factory=ApprovalConfig)
    look: LookConfig = Field(default_factory=LookConfig)
    recording: RecordingConfig = Field(default_factory=RecordingConfig)
    retention: RetentionConfig = Field(default_factory=RetentionConfig)
    options: dict[str, Any] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _can_be_screened(self) -> Self:
        if self.screen == "required" and self.mind == "rules":
            raise ValueError('screen = "required" needs a mind that is a model; otherwise nothing would ever move')
        return self


class MindLimitsConfig(Section):
    """What one mind may use up, per command and per UTC day; money in the currency of its price. 0: no limit."""

    command_tokens: Annotated[int, Field(ge=0)] = 100_000
    day_tokens: Annotated[int, Field(ge=0)] = 2_000_000
    command_cost: Annotated[float, Field(ge=0)] = 0.0
    day_cost: Annotated[float, Field(ge=0)] = 0.0


class PriceConfig(Section):
    """What a million tokens cost. Costs are known only from here: no price list is fetched."""

    input_per_million: Annotated[float, Field(ge=0)] = 0.0
    output_per_million: Annotated[float, Field(ge=0)] = 0.0
    currency: str = "USD"


#: Address and key variable of each provider, when nothing else is configured.
_PROVIDERS = {
    "openai": ("https://api.openai.com/v1", "OPENAI_API_KEY"),
    "anthropic": ("https://api.anthropic.com", "ANTHROPIC_API_KEY"),
    "ark": ("https://ark.cn-beijing.volces.com/api/v3", "ARK_API_KEY"),
    "compatible": ("", ""),
}


#: What `kind = "local"` sets unless something else is said. A cold prompt took 17 s on two cores with llama.cpp.
_LOCAL = {"timeout_s": 60.0, "total_s": 120.0, "concurrency": 1}
#: The longest that all models of a chain may take together: a queued command expires after 600 s by default, and a
#: reading and a second look must both fit.
CHAIN_S = 300.0


class MindConfig(Section):
    """One model. The key is in the environment, in the variable that `key_env` names; it is never written here.

    `provider` says whose dialect is spoken; `compatible` is any OpenAI-compatible server (Ollama, vLLM, llama.cpp) and
    needs a `base_url`. `answers`: how typed answers are asked for; `tools` by tool calls, `json` by words in the prompt
    (for weak local models), `json_object` the same with `response_format` and the schema (llama.cpp).
    `timeout_s` bounds one attempt, `total_s` one answer with all attempts and waits. `fallbacks` are other minds, tried
    in order when this one fails; the rules always come last. An agent waits for all of them as long as they say.
    `kind = "local"` is for a slow server of one's own (llama.cpp, Ollama): 60 s an attempt and 120 s in all, one
    question at a time, no second attempt after a timeout, prompts that share one prefix, read once when the agent
    starts, and answers as a stream, so that a question that is given up is not computed to its end.
    `reads`: the posts that the rules ask back (`unclear`), or `all`; then the rules and the model must agree.
    """

    @model_validator(mode="before")
    @classmethod
    def _local_times(cls, data: Any) -> Any:
        return {**_LOCAL, **data} if isinstance(data, dict) and data.get("kind") == "local" else data

    provider: Literal["openai", "anthropic", "ark", "compatible"]
    kind: Literal["hosted", "local"] = "hosted"
    reads: Literal["unclear", "all"] = "unclear"
    model: Annotated[str, Field(min_length=1)]
    base_url: str = ""
    key_env: Annotated[str, Field(pattern=r"^([A-Za-z_][A-Za-z0-9_]{0,63})?$")] = ""
    answers: Literal["tools", "json", "json_object"] = "tools"
    images: bool = True
    timeout_s: Annotated[float, Field(gt=0, le=120)] = 15.0
    total_s: Annotated[float, Field(gt=0, le=300)] = 25.0
    retries: Annotated[int, Field(ge=0, le=10)] = 2
    concurrency: Annotated[int, Field(ge=1, le=64)] = 2
    max_output_tokens: Annotated[int, Field(ge=16)] = 2_000
    fallbacks: tuple[str, ...] = ()
    limits: MindLimitsConfig = Field(default_factory=MindLimitsConfig)
    price: PriceConfig | None = None

    @property
    def address(self) -> str:
        """Where it is reached: `base_url`, or the provider's own."""
        return self.base_url or _PROVIDERS[self.provider][0]

    @property
    def key_variable(self) -> str:
        """The environment variable with the key: `key_env`, or the provider's usual one; empty when none is needed."""
        return self.key_env or _PROVIDERS[self.provider][1]

    @field_validator("base_url")
    @classmethod
    def _is_plain_address(cls, url: str) -> str:
        if url and not plain_address(url):
            raise ValueError("must be http(s)://host[:port][/path] without a user, key or query")
        return url.rstrip("/")

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        if self.provider == "compatible" and not self.base_url:
            raise ValueError('provider "compatible" needs base_url, for example "http://127.0.0.1:11434/v1"')
        if (self.limits.command_cost or self.limits.day_cost) and self.price is None:
            raise ValueError("a limit of cost needs a price: input_per_million and output_per_million")
        return self


class Config(Section):
    """The whole file. `data` is where databases, journals and pictures are kept."""

    data: str = ""
    board: BoardConfig = Field(default_factory=BoardConfig)
    forum: ForumConfig = Field(default_factory=ForumConfig)
    images: ImagesConfig = Field(default_factory=ImagesConfig)
    mcp: McpConfig = Field(default_factory=McpConfig)
    mcp_robot: McpRobotConfig = Field(default_factory=McpRobotConfig)
    service: ServiceConfig = Field(default_factory=ServiceConfig)
    robots: dict[Name, RobotConfig] = Field(default_factory=dict)
    minds: dict[Name, MindConfig] = Field(default_factory=dict)

    @model_validator(mode="before")
    @classmethod
    def _forum_is_the_own_board(cls, data: Any) -> Any:
        """Agents use the embedded forum where it listens, unless another forum or address is given."""
        if not isinstance(data, dict):
            return data
        forum, board = data.get("forum", {}), data.get("board", {})
        listen = board.get("listen") if isinstance(board, dict) else board.listen
        if isinstance(forum, dict) and isinstance(listen, str) and forum.get("kind", "board") == "board":
            with suppress(ValueError):  # a wrong address is reported where `board` is validated
                data = {**data, "forum": {"url": _local_url(listen), **forum}}
        return data

    @model_validator(mode="after")
    def _minds_fit(self) -> Self:
        if "rules" in self.minds:
            raise ValueError("minds.rules is the built-in mind without a model; call yours otherwise")
        for name, mind in self.minds.items():
            models = mind.fallbacks[:-1] if mind.fallbacks[-1:] == ("rules",) else mind.fallbacks
            if wrong := [other for other in models if other not in self.minds or other == name]:
                known = ", ".join([*sorted(set(self.minds) - {name}), "and rules as the last"])
                raise ValueError(f"minds.{name}.fallbacks names {', '.join(wrong)}; valid are: {known}")
            chain_s = sum(self.minds[other].total_s for other in (name, *models))
            if chain_s > CHAIN_S:
                raise ValueError(
                    f"minds.{name} and its fallbacks may take {chain_s:g} s together (total_s); at most {CHAIN_S:g} s"
                )
        return self

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


def _local_url(listen: str) -> str:
    """The URL by which this machine reaches a listen address: loopback if it listens on every interface."""
    host, port = parse_listen(listen)
    return base_url("127.0.0.1" if host in ("0.0.0.0", "::") else host, port)


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


#: Where a key may have been put by mistake: what was found there is not repeated.
_UNSPOKEN = ("key_env", "secret_env", "token_env", "base_url", "endpoint")


def _explain(error: Any) -> str:
    where = ".".join(str(p) for p in error["loc"])
    said = error["msg"].removeprefix("Value error, ")
    if error["type"] == "extra_forbidden":
        return f"{where} is not a setting; valid here: {', '.join(sorted(_section_at(error['loc']).model_fields))}"
    secret = bool(error["loc"]) and error["loc"][-1] in _UNSPOKEN
    if secret or not isinstance(error["input"], str | int | float | bool):
        return f"{where}: {said}" if where else said
    return f"{where}: {said} (found {error['input']!r})"


def _section_at(where: tuple[Any, ...]) -> type[BaseModel]:
    """The table that a wrong key stands in."""
    section: type[BaseModel] = Config
    kind: Any = Config
    for part in where[:-1]:
        field = section.model_fields.get(str(part)) if kind is section else None
        # A table of tables (robots, minds) has any key; then come the settings of one of them.
        kind = field.annotation if field else (get_args(kind) or (section,))[-1]
        kinds = [k for k in (kind, *get_args(kind)) if isinstance(k, type) and issubclass(k, BaseModel)]
        if kinds and not str(kind).startswith("dict"):
            section = kind = kinds[0]
    return section
