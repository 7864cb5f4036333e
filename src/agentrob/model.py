"""The frozen facts that travel between rooms: who wrote what, what is wanted, what is allowed, what was measured.

Frames follow REP-103: x forward, y left, yaw counter-clockwise. Units stand in the names. Times called `*_at` are
aware UTC datetimes by the forum's clock; times called `*_s` are seconds of the machine's monotonic clock.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from datetime import datetime
from enum import StrEnum
from typing import Any

from agentrob.model_accounts import Account, AccountKind, ActionClass, RobotRights, Role

#: What stands elsewhere and is asked for here, beside all that is defined below.
__all__ = ["Account", "AccountKind", "ActionClass", "RobotRights", "Role"]

#: The code (ISO 639-1) of a language that `agentrob.language` knows: en, zh, and what a user adds.
Language = str


# ------------------------------------------------------------------ what was said
@dataclass(frozen=True, slots=True)
class StatusCard:
    """The machine-readable state of one command, shown by a forum that can as a card on the status post.

    `state`: seen, waiting (for an approval), queued, running, done, failed, refused, asks_back, stopped, interrupted,
    cancelled, expired. `until`: until when a waiting one may be approved, as RFC 3339 with a zone; else empty.
    """

    robot: str
    state: str
    step: int = 0
    steps: int = 0
    doing: str = ""
    place: int | None = None
    trace_id: str = ""
    until: str = ""


@dataclass(frozen=True, slots=True)
class Post:
    """One post as a forum delivers it. `raw` is Markdown, `version` grows by one with each edit. `mentions` are the
    accounts that its page links as mentioned; `rendering_differs`: its page shows other words than those
    read from `raw`."""

    id: str
    topic_id: str
    board_id: str
    author: Account
    raw: str
    created_at: datetime
    version: int = 1
    edited_at: datetime | None = None
    removed: bool = False
    mentions: tuple[str, ...] = ()
    reply_to: str | None = None
    key: str | None = None
    url: str = ""
    images: tuple[str, ...] = ()
    card: StatusCard | None = None
    rendering_differs: bool = False

    @property
    def content_hash(self) -> str:
        """SHA-256 of the raw text, in hex; what a command is bound to."""
        return hashlib.sha256(self.raw.encode("utf-8", "surrogatepass")).hexdigest()


# ------------------------------------------------------------------ what is wanted
class Op(StrEnum):
    """The operations of robots, as data calls them (tools that a VLM sees are named `act_move`, …)."""

    MOVE = "move"
    TURN = "turn"
    HELLO = "hello"
    HEART = "heart"
    CLAP = "clap"
    SHAKE = "shake"
    BACKFLIP = "backflip"
    SIT = "sit"
    STAND = "stand"
    STRETCH = "stretch"
    GET_FRONT_IMAGE = "get_front_image"


class Direction(StrEnum):
    """Of a move: all four. Of a turn: left (counter-clockwise) or right."""

    FORWARD = "forward"
    BACKWARD = "backward"
    LEFT = "left"
    RIGHT = "right"


@dataclass(frozen=True, slots=True)
class Primitive:
    """One step for a robot.

    `move` has `direction`, `distance_m` and perhaps `speed_mps`; `turn` has `direction` and `degrees`; the others have
    nothing. Distances and degrees are positive.
    """

    op: Op
    direction: Direction | None = None
    distance_m: float | None = None
    degrees: float | None = None
    speed_mps: float | None = None

    def asked(self) -> dict[str, Any]:
        """What is asked, as data: only the fields that this operation has."""
        fields = asdict(self)
        return {k: (str(v) if isinstance(v, StrEnum) else v) for k, v in fields.items() if k != "op" and v is not None}

    @property
    def moves(self) -> bool:
        """Whether the robot's body moves at all."""
        return self.op is not Op.GET_FRONT_IMAGE


@dataclass(frozen=True, slots=True)
class Plan:
    """Steps in order. `notes` are assumptions the reply must state ("turn left" was taken as 90°)."""

    steps: tuple[Primitive, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def distance_m(self) -> float:
        """Sum of all moves."""
        return sum(s.distance_m or 0.0 for s in self.steps)

    @property
    def moves(self) -> bool:
        return any(s.moves for s in self.steps)


class Intent(StrEnum):
    """What a post wants of the robot. Only `command` moves anything."""

    COMMAND = "command"
    STOP = "stop"
    HALT = "halt"
    HELP = "help"
    STATUS = "status"
    CANCEL = "cancel"
    QUESTION = "question"
    ASK_BACK = "ask_back"
    NOTHING = "nothing"


@dataclass(frozen=True, slots=True)
class Understanding:
    """What a mind made of a post. `question` is the sentence to ask back or greet with, in `language`.

    `cancels`: its author's earlier commands that have not begun are not wanted any more ("never mind, turn left").
    """

    intent: Intent
    language: Language = "en"
    plan: Plan = Plan()
    question: str = ""
    cancels: bool = False


@dataclass(frozen=True, slots=True)
class Command:
    """A post that wants something of a robot: bound to its text and its author (law 4). `text` is the visible text."""

    post_id: str
    topic_id: str
    content_hash: str
    author: Account
    robot: str
    text: str
    language: Language
    posted_at: datetime
    trace_id: str


# ------------------------------------------------------------------ what is allowed
@dataclass(frozen=True, slots=True)
class Limits:
    """Bounds of one robot (law 10). Beyond them a command is refused with the limit named."""

    speed_mps: float = 0.5
    turn_dps: float = 45.0
    step_m: float = 5.0
    step_deg: float = 360.0
    command_m: float = 10.0
    command_s: float = 60.0
    command_steps: int = 10


@dataclass(frozen=True, slots=True)
class Capabilities:
    """What a robot can do, readable before it is connected. `model` is go2, g1, fake, …"""

    model: str
    ops: frozenset[Op]
    limits: Limits = Limits()
    move_directions: frozenset[Direction] = frozenset(Direction)
    simulated: bool = False


class Decision(StrEnum):
    ALLOW = "allow"
    ASK_BACK = "ask_back"
    NEEDS_APPROVAL = "needs_approval"
    REFUSE = "refuse"


@dataclass(frozen=True, slots=True)
class Verdict:
    """The screen's answer: `rule` names what decided, `reason` is a sentence in the language of the post."""

    decision: Decision
    rule: str
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Mandate:
    """What a screened command may use up at most (law 7): calls per operation, metres, degrees, seconds, steps.

    `speed_mps` bounds each walk and `motions` the steps that move, where they are given.
    """

    calls: Mapping[Op, int] = field(default_factory=dict)
    distance_m: float = 0.0
    degrees: float = 0.0
    seconds: float = 60.0
    steps: int = 0
    speed_mps: float | None = None
    motions: int | None = None


# ------------------------------------------------------------------ what the robot says
@dataclass(frozen=True, slots=True)
class Pose:
    """Odometry: metres and radians in the robot's own odometry frame."""

    x_m: float
    y_m: float
    yaw_rad: float


#: Why a robot is locked when somebody asked for it; other reasons are sentences of its guard.
EMERGENCY_STOP = "an emergency stop"


@dataclass(frozen=True, slots=True)
class Lock:
    """An emergency stop that holds until the robot's owner releases it: who set it, why, and when by the clock of the
    robot's machine. `by` is empty and `at` None where that is not known; both texts are untrusted."""

    by: str
    why: str
    at: datetime | None = None


@dataclass(frozen=True, slots=True)
class RobotState:
    """What is known of a robot now. `None` means unknown, and unknown is never taken as good.

    `age_s`: age of the newest state message. `ranges_m`: front, left, back, right. `mode`: idle, walking, gesture,
    sitting, lying, damping, locked, fallen, unknown. `halted`: it refuses all motion, and `lock` says since when.
    """

    age_s: float
    pose: Pose | None = None
    velocity_mps: tuple[float, float] | None = None
    yaw_rate_rps: float | None = None
    mode: str = "unknown"
    battery_percent: float | None = None
    ranges_m: tuple[float | None, float | None, float | None, float | None] = (None, None, None, None)
    upright: bool | None = None
    homed: bool = False
    halted: bool = False
    error_code: int | None = None
    lock: Lock | None = None


class Outcome(StrEnum):
    """How a step ended. `unknown` means that the robot did not confirm."""

    DONE = "done"
    INACCURATE = "inaccurate"
    FAILED = "failed"
    REFUSED = "refused"
    STOPPED = "stopped"
    INTERRUPTED = "interrupted"
    UNKNOWN = "unknown"
    SKIPPED = "skipped"


@dataclass(frozen=True, slots=True)
class ActionResult:
    """One step, asked beside measured.

    `measured` has the keys of what was asked (`distance_m`, `degrees`) and what is worth knowing besides. It is empty
    where nothing was measured; `unmeasured` then says why, of a step that may have moved the robot: `odometry_lost` or
    `odometry_jump`. `reason` is
    a stable word (obstacle, fence, deadline, stale_state, lease_lapsed, stop, stalled, unsupported, busy, …), `message`
    an English sentence. `path` is the odometry during the step: (seconds, x_m, y_m, yaw_rad), `commanded` what was sent
    to the body meanwhile: (seconds, forward_mps, left_mps, turn_rps). `image` is a JPEG. `started_s` and `ended_s` are
    monotonic.
    """

    primitive: Primitive
    outcome: Outcome
    measured: Mapping[str, float] = field(default_factory=dict)
    reason: str = ""
    message: str = ""
    started_s: float = 0.0
    ended_s: float = 0.0
    path: tuple[tuple[float, float, float, float], ...] = ()
    image: bytes | None = None
    animated: bool = False
    commanded: tuple[tuple[float, float, float, float], ...] = ()
    unmeasured: str = ""

    @property
    def ok(self) -> bool:
        return self.outcome is Outcome.DONE

    @property
    def moved(self) -> bool:
        """Whether the driver was given this step and did not refuse it, so that the robot moved or may have moved."""
        return self.outcome not in (Outcome.SKIPPED, Outcome.REFUSED)

    @property
    def duration_s(self) -> float:
        return self.ended_s - self.started_s


@dataclass(frozen=True, slots=True)
class StopResult:
    """What a stop did.

    `latency_ms`: from asked to zero velocity commanded. `confirmed`: the robot's own state shows rest. `ended_s`: what
    was accepted until then, by the monotonic clock of the driver's host, is over.
    """

    latency_ms: float
    confirmed: bool
    was_moving: bool = False
    coasted_m: float | None = None
    message: str = ""
    ended_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Report:
    """Everything the final reply says. `status`: done, failed, refused, asks_back, stopped, interrupted, cancelled,
    expired, answered. `timings_ms` counts from the post being accepted by the forum. `goal` is what a model was to look
    for, in our words, `approved_by` the handle of who approved the command, where that was needed."""

    command: Command
    status: str
    verdict: Verdict | None = None
    plan: Plan = Plan()
    results: tuple[ActionResult, ...] = ()
    message: str = ""
    stop: StopResult | None = None
    timings_ms: Mapping[str, float] = field(default_factory=dict)
    goal: str = ""
    approved_by: str = ""
