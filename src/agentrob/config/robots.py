"""The `[robots.NAME]` tables: a robot's driver and agent, its limits, rates, approvals, recordings and retention.

[robots.quadruped]            # the name is the robot's account on the forum and the name of its driver
model = "go2"
interface = "lo"
domain = 1

[robots.rex]                  # on the robot's own computer: its driver also serves agents on other machines
model = "go2"
interface = "eth0"
driver_listen = "192.168.1.20:8093"
driver_cert = "/etc/agentrob/driver.pem"
driver_key = "/etc/agentrob/driver.key"
driver_ca = "/etc/agentrob/ca.pem"

[robots.rex]                  # on the agent's machine
model = "go2"
driver_url = "https://192.168.1.20:8093"
driver_cert = "/etc/agentrob/agent.pem"
driver_key = "/etc/agentrob/agent.key"
driver_ca = "/etc/agentrob/ca.pem"
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self
from urllib.parse import urlsplit

from pydantic import Field, field_validator, model_validator

from agentrob.config.map import MapConfig
from agentrob.config.section import Section, WithMetrics
from agentrob.model import ActionClass
from agentrob.model.schedules import zone_of
from agentrob.process.listen import is_loopback, parse_listen


class FenceConfig(Section):
    """A rectangle around the robot's home, in metres: `x_min_m` to `x_max_m` forward, as the robot faced at home, and
    `y_min_m` to `y_max_m` to its left.
    """

    x_min_m: float = -5.0
    x_max_m: float = 5.0
    y_min_m: float = -5.0
    y_max_m: float = 5.0


class LimitsConfig(Section):
    """Bounds that commands may not exceed (law 10).

    `speed_mps` and `turn_dps` bound every motion, `step_m` and `step_deg` one step, `command_m`, `command_s` and
    `command_steps` a whole command.
    """

    speed_mps: Annotated[float, Field(gt=0, le=1.5)] = 0.5
    turn_dps: Annotated[float, Field(gt=0, le=90)] = 45.0
    step_m: Annotated[float, Field(gt=0)] = 5.0
    step_deg: Annotated[float, Field(gt=0)] = 360.0
    command_m: Annotated[float, Field(gt=0)] = 10.0
    command_s: Annotated[float, Field(gt=0)] = 60.0
    command_steps: Annotated[int, Field(ge=1)] = 10


class RatesConfig(Section):
    """Rate limits per account and robot; 0 disables a limit. Stops are exempt.

    A command within `cooldown_s` of the account's previous one is delayed. A command beyond `commands_per_hour`, or
    beyond `waiting` queued commands of the account, is refused, and the reply says when to try again.
    """

    commands_per_hour: Annotated[int, Field(ge=0)] = 60
    cooldown_s: Annotated[int, Field(ge=0, le=3600)] = 2
    waiting: Annotated[int, Field(ge=0)] = 5


class LookConfig(Section):
    """Let a model steer the robot by its camera ("walk to the red ball"), within limits per command.

    Off unless the owner sets `allowed = true`. The robot's mind must then be a model with `images`. Each such command
    may use `distance_m` of walking, `degrees` of turning, `calls` of the model's tools, `pictures`, and `seconds` in
    total, including the model's time. `speed_mps` is the top walking speed. The robot's own limits apply as well.
    """

    allowed: bool = False
    distance_m: Annotated[float, Field(gt=0, le=50)] = 5.0
    degrees: Annotated[float, Field(gt=0, le=3600)] = 720.0
    calls: Annotated[int, Field(ge=1, le=50)] = 12
    pictures: Annotated[int, Field(ge=1, le=50)] = 10
    seconds: Annotated[float, Field(gt=0, le=600)] = 120.0
    speed_mps: Annotated[float, Field(ge=0.05, le=1.0)] = 0.3


class EyesConfig(Section):
    """How things are found in the robot's camera picture without a language model ("turn to the red ball").

    `detector` is `colours` (built in: plain colours, and balls, boxes and columns by their outlines), the name of an
    installed one, or empty for none; `options` are its own. `fov_deg` is the camera's vertical field of view, from
    which angles are computed; without it, that of the simulated robots.
    """

    detector: str = "colours"
    fov_deg: Annotated[float, Field(gt=5, lt=170)] | None = None
    options: dict[str, Any] = Field(default_factory=dict)


#: The maximum length of `scene`.
SCENE_CHARS = 2_000


class RecordingConfig(Section):
    """Recordings of commands that move a robot: its path, its speeds, and a short animation for the reply.

    `view` selects the animation. `room`: from `room_camera`; `robot`: from the robot's own camera; `path`: the path on
    a map; `none`: no animation. `auto` shows the room if every reader of the thread may watch that camera live anyway
    (on a forum with robot pages), else the path; other cameras are shown only if the owner selects them.

    `camera` is the URL of a camera that keeps the past, such as a simulated room's: it is asked for the pictures of a
    command after its motion (`?ago_s=`, the age in seconds), and `auto` and `room` show them. An animation has at most
    `max_kb`; forums limit attachments. Recordings stay on disk for `keep_days` and up to `keep_mb` per robot, the
    oldest are deleted first; 0 keeps none.
    """

    view: Literal["auto", "room", "robot", "path", "none"] = "auto"
    camera: str = ""
    max_kb: Annotated[int, Field(ge=100, le=8000)] = 2000
    keep_days: Annotated[float, Field(ge=0, le=3650)] = 30.0
    keep_mb: Annotated[float, Field(ge=0)] = 200.0


class RetentionConfig(Section):
    """How long an agent keeps finished commands: the row in the journal, the record and the pictures of the steps.

    Kept for `days` and up to `commands` commands, with records and pictures up to `mb` each; the oldest are deleted
    first. Rows younger than a day and commands that are still open always stay in the journal.
    """

    days: Annotated[float, Field(ge=1, le=3650)] = 30.0
    commands: Annotated[int, Field(ge=1)] = 5000
    mb: Annotated[float, Field(gt=0)] = 200.0


class ApprovalConfig(Section):
    """Which action `classes` need approval, in addition to those that the forum's own settings of the robot list.

    `who` (a minimum role, or `owner`) may approve; with `own`, also their own commands. Both apply only where the forum
    has no such settings. A command waits for approval at most `wait_s` after its post, and at most `queue_expiry_s`.
    """

    classes: tuple[ActionClass, ...] = ()
    who: Literal["operator", "moderator", "admin", "owner"] = "moderator"
    own: bool = False
    wait_s: Annotated[float, Field(gt=0)] = 600.0


class RehearsalConfig(Section):
    """Where previews are simulated ("preview walk 3 m"). `world` is the name of a shipped world or the path of a world
    file that describes the robot's surroundings, in the frame of its `map`; without one, a preview is made of geometry
    and limits alone. So is one whose simulation takes longer than `limit_s`.
    """

    world: str = ""
    limit_s: Annotated[float, Field(gt=0, le=3600)] = 120.0


class RobotConfig(WithMetrics):
    """One robot: the connection of its driver, who may command it and where, and what its agent does.

    `model` is the kind of robot: `go2`, `g1`, `fake`, or that of an installed package, whose class gets `options`.
    `interface` and `domain` are DDS settings. `simulated` says that no real robot moves, so that accounts for
    simulated robots may command it. `owner` is the handle of the account that releases it, sets its home and changes
    its rights; `mentions` are further names by which posts address it, `boards` the boards on which it reads them.
    `poll_s` is how often the agent reads a forum without an event stream. A post older than `max_post_age_s` moves
    nothing (law 5), and a command that waited longer than `queue_expiry_s` expires. `allow_flip` is the owner's
    consent to backflips, `allow_risky` to the risky operations that the robot declares. `step_length_m` is the
    measured length of one of the robot's steps; without it, the reply to "walk two steps" asks for a distance. With
    `home_on_start` the driver sets home when it starts; allowed only with `simulated`, because the owner sets the home
    of a real robot (law 9).
    `allow_unknown_ranges`: the owner's consent to move at 0.2 m/s without range readings (law 8).
    `least_battery_percent`: no motion begins below this charge; a robot that does not report its charge may move.
    `moderators` are handles that are alerted, with the owner, of the third stop within 5 minutes.
    `mind` reads the posts: `rules`, or the name of a table of `minds`. `screen` says whether that model also reviews
    commands that the rules allow: `rules` never; `model` yes, but the rules decide alone if it does not answer;
    `required` yes, and nothing moves if it does not answer. `scene` describes the robot's surroundings in English
    ("stairs 2 m behind home"); rules and model use it to judge danger. With `harm_classifier` (needs the extra
    `agentrob[semantic]`) a small offline classifier judges the words of each command that the rules allow and may make
    the robot ask back; if it cannot be loaded or does not answer, the rules decide alone.
    `summary` lets the model describe in words what was done, from the measured figures.
    `time_zone` (an IANA name such as `Europe/Berlin`) is the zone of the times in posts: "every day at 9".
    `room_camera` is the snapshot URL of a camera that sees the robot, `room_reset` a URL that resets a simulated room.
    `map` describes the room for the live map.

    Robots with the same `room` never move where another one moves or stands. Their drivers share a data folder, or name
    in `room_url` the driver of another host that keeps the room (`https://host:port`, its `driver_listen`; the
    certificates and the token are those below). `room_error_m` says that the robot's place in the room is known: its
    first home is where `map` says (`map.room` is then the same room), and odometry and home together are wrong by at
    most this much. Robots whose paths stay apart may then move at once; without it, one robot of the room at a time.

    The driver serves its Unix socket, and with `driver_listen` (host:port) also other machines; there, agents reach it
    at `driver_url`. `driver_cert` and `driver_key` are the certificate of this machine, `driver_ca` the authority that
    signed those of the other side, `driver_token_env` the variable of a token of at least 16 characters that both
    sides have. A driver with `driver_ca` demands a certificate of its clients, one with `driver_token_env` the token.
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
    harm_classifier: bool = False
    summary: bool = False
    poll_s: Annotated[float, Field(gt=0)] = 30.0
    step_length_m: Annotated[float, Field(gt=0, le=2)] | None = None
    max_post_age_s: Annotated[float, Field(gt=0)] = 120.0
    queue_expiry_s: Annotated[float, Field(gt=0)] = 600.0
    home_on_start: bool = False
    allow_unknown_ranges: bool = False
    least_battery_percent: Annotated[float, Field(ge=0, le=100)] = 15.0
    allow_flip: bool = False
    allow_risky: tuple[Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{1,39}$")], ...] = ()
    time_zone: str = "UTC"
    room: Annotated[str, Field(pattern=r"^([a-z0-9][a-z0-9 _-]{0,39})?$")] = ""
    room_url: str = ""
    room_error_m: Annotated[float, Field(ge=0, le=2)] | None = None
    room_camera: str = ""
    room_reset: str = ""
    driver_listen: str = ""
    driver_url: str = ""
    driver_cert: str = ""
    driver_key: str = ""
    driver_ca: str = ""
    driver_token_env: Annotated[str, Field(pattern=r"^([A-Za-z_][A-Za-z0-9_]{0,63})?$")] = ""
    fence: FenceConfig = Field(default_factory=FenceConfig)
    map: MapConfig = Field(default_factory=MapConfig)
    limits: LimitsConfig = Field(default_factory=LimitsConfig)
    rates: RatesConfig = Field(default_factory=RatesConfig)
    approval: ApprovalConfig = Field(default_factory=ApprovalConfig)
    look: LookConfig = Field(default_factory=LookConfig)
    eyes: EyesConfig = Field(default_factory=EyesConfig)
    recording: RecordingConfig = Field(default_factory=RecordingConfig)
    rehearsal: RehearsalConfig = Field(default_factory=RehearsalConfig)
    retention: RetentionConfig = Field(default_factory=RetentionConfig)
    options: dict[str, Any] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _can_be_screened(self) -> Self:
        if self.screen == "required" and self.mind == "rules":
            raise ValueError('screen = "required" needs a mind that is a model; otherwise nothing would ever move')
        return self

    @field_validator("time_zone")
    @classmethod
    def _known_zone(cls, name: str) -> str:
        zone_of(name)
        return name

    @property
    def consents(self) -> frozenset[str]:
        """The risky operations that the owner consents to (`Operation.needed_consent`)."""
        return frozenset(self.allow_risky) | ({"flip"} if self.allow_flip else frozenset())

    @property
    def homes_itself(self) -> bool:
        """Whether its driver sets its home whenever it has none; a simulated robot's only."""
        return self.simulated and self.home_on_start

    @model_validator(mode="after")
    def _protects_its_driver(self) -> Self:
        if bool(self.driver_cert) != bool(self.driver_key):
            raise ValueError("driver_cert and driver_key belong together: set both or neither")
        if self.driver_listen:
            _check_listen(self)
        if self.driver_url:
            _check_url(self, "driver_url")
        return self

    @model_validator(mode="after")
    def _shares_its_room(self) -> Self:
        if not self.room and (self.room_url or self.room_error_m is not None):
            raise ValueError("room_url and room_error_m belong to a room that the robot shares; set room")
        if self.room_error_m is not None and self.map.room != self.room:
            raise ValueError(
                f"room_error_m needs the robot's place in the room: set room = {self.room!r}, home_at_m and "
                f"home_facing_deg in its map (found room = {self.map.room!r})"
            )
        if self.room_url:
            _check_url(self, "room_url")
        return self


def _check_listen(settings: RobotConfig) -> None:
    host, _ = parse_listen(settings.driver_listen)
    if settings.driver_cert:
        if not settings.driver_ca and not settings.driver_token_env:
            raise ValueError(
                "driver_listen needs to know who may move the robot: set driver_ca, the authority that signs the "
                "certificates of the clients, or driver_token_env, the variable of a token, or both"
            )
    elif not is_loopback(host):
        raise ValueError(
            f"driver_listen = {settings.driver_listen!r} is reachable from other machines and needs TLS: set "
            "driver_cert and driver_key, and driver_ca or driver_token_env; without TLS only an address of this "
            "machine is valid, such as 127.0.0.1:8093, for a tunnel, with driver_token_env"
        )
    elif not settings.driver_token_env:
        raise ValueError("driver_listen without TLS needs driver_token_env, the variable of a token")


def _check_url(settings: RobotConfig, name: str) -> None:
    parts = urlsplit(getattr(settings, name))
    plain = parts.scheme == "http" and is_loopback(parts.hostname or "")
    bare = not (parts.username or parts.query or parts.fragment or parts.path.strip("/"))
    if not parts.hostname or not bare or not (parts.scheme == "https" or plain):
        raise ValueError(f"{name} must be https://host:port, or http://127.0.0.1:port for the end of a tunnel")
    if not settings.driver_token_env and (plain or not settings.driver_cert):
        either = "" if plain else ", or driver_cert and driver_key, a certificate for this machine"
        raise ValueError(f"{name} needs driver_token_env, the variable of the driver's token{either}")
