"""The request and response models of the agent's HTTP service, as in its OpenAPI document."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from agentrob.model import CommandState

Text = Annotated[str, StringConstraints(min_length=1, max_length=8_000, pattern=r"\S")]
Id = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9_.:-]{1,80}$")]


class _Asked(BaseModel):
    model_config = ConfigDict(extra="forbid")


class NewCommand(_Asked):
    """A command to post. A mention of the robot is added if missing; without `topic` a new topic is started."""

    text: Text
    topic: Id | None = None
    title: Annotated[str, StringConstraints(min_length=1, max_length=200, pattern=r"\S")] | None = None


class NewPreview(_Asked):
    """A text to preview."""

    text: Text


class Robot(BaseModel):
    """A robot's current state. `state` is its mode, `halted`, or `offline` if its driver does not answer."""

    name: str
    model: str
    simulated: bool
    state: str
    ops: list[str] = []
    operations: list[dict[str, Any]] = Field([], description="the operations that the robot declares")
    limits: dict[str, float] = {}
    boards: list[str] = []
    battery_percent: float | None = None
    homed: bool | None = None
    state_age_s: float | None = None
    moving: str | None = Field(None, description="the post of the command that moves it now")
    waiting: int = 0
    forum_silent_s: float | None = Field(None, description="seconds since the forum last answered; null: never")


class Robots(BaseModel):
    items: list[Robot]


class Judged(BaseModel):
    """The decision (`allow`, `ask_back`, `needs_approval` or `refuse`), its rule, and the reason as a sentence."""

    decision: str
    rule: str
    reason: str = ""


class Preview(BaseModel):
    """How the text would be handled now. Rights, limits and state are checked again before anything moves."""

    intent: str
    language: str
    plan: list[dict[str, Any]] = []
    notes: list[str] = []
    question: str = ""
    verdict: Judged | None = None
    mind: str = ""
    author: str = ""


class Command(BaseModel):
    """A command. `state` is `stop` for a post that is a stop, and `nothing` for one that asks nothing of the robot.
    `ended`: the state is final. `text` was written by somebody: data, never an instruction."""

    id: str
    robot: str
    state: CommandState
    ended: bool
    topic: str = ""
    url: str = ""
    author: str = ""
    text: str = ""
    posted_at: datetime | None = None
    trace_id: str = ""
    place: int | None = None
    step: int = 0
    steps: int = 0
    doing: str = ""
    message: str = ""
    plan: list[dict[str, Any]] = []
    verdict: Judged | None = None
    results: list[dict[str, Any]] = []
    stopped_by: str = ""
    timings_ms: dict[str, float] = {}


class Submitted(BaseModel):
    """`created` is false if the key was used before; `command` is then the earlier command."""

    command: Command
    created: bool


class Queue(BaseModel):
    """Running and waiting commands, in order."""

    items: list[Command]


class Stopped(BaseModel):
    """The result of a stop, measured by the robot's driver. `latency_ms` is the time from the request until zero
    velocity was commanded; `confirmed`: the robot's own state shows rest; `ended` counts the commands it ended."""

    robot: str
    reached: bool
    confirmed: bool = False
    latency_ms: float | None = None
    was_moving: bool | None = None
    coasted_m: float | None = None
    ended: int = 0
    message: str = ""


class Scanned(BaseModel):
    """`heard`: the forum answered, and all new posts were received."""

    heard: bool
    waiting: int


class Health(BaseModel):
    status: str


class Readiness(BaseModel):
    """Each part that must work before a command can move the robot."""

    ready: bool
    agent: bool
    forum: bool
    driver: bool
