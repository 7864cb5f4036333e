"""What goes over the wire of the agent's HTTP service, as its OpenAPI document shows it."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, StringConstraints

from agentrob.model import CommandState

Text = Annotated[str, StringConstraints(min_length=1, max_length=8_000, pattern=r"\S")]
Id = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9_.:-]{1,80}$")]


class Problem(BaseModel):
    """What went wrong, as RFC 9457 has it: `code` is a stable word, `hint` says what would be valid."""

    type: str = "about:blank"
    title: str
    status: int
    detail: str
    code: str
    hint: str = ""


class _Asked(BaseModel):
    model_config = ConfigDict(extra="forbid")


class NewCommand(_Asked):
    """What to post for the robot. It is mentioned where the text does not do so. Without `topic` a new one is made."""

    text: Text
    topic: Id | None = None
    title: Annotated[str, StringConstraints(min_length=1, max_length=200, pattern=r"\S")] | None = None


class NewPreview(_Asked):
    """What one would post."""

    text: Text


class Robot(BaseModel):
    """A robot as it is now. `state` is its mode, `halted`, or `offline` when its driver does not answer."""

    name: str
    model: str
    simulated: bool
    state: str
    ops: list[str] = []
    limits: dict[str, float] = {}
    boards: list[str] = []
    battery_percent: float | None = None
    homed: bool | None = None
    state_age_s: float | None = None
    moving: str | None = Field(None, description="the post whose command moves it now")
    waiting: int = 0
    forum_silent_s: float | None = Field(None, description="since when nothing was heard of the forum; null: never")


class Robots(BaseModel):
    items: list[Robot]


class Judged(BaseModel):
    """What decided: `allow`, `ask_back`, `needs_approval` or `refuse`, by which rule, and a sentence for people."""

    decision: str
    rule: str
    reason: str = ""


class Preview(BaseModel):
    """What would be made of the text now. Rights, limits and state are asked again before anything moves."""

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
    """`created` is false when the same key had been used before: then it is the command of then."""

    command: Command
    created: bool


class Queue(BaseModel):
    """Commands that move or wait, in order."""

    items: list[Command]


class Stopped(BaseModel):
    """What the stop did, as the robot's driver measured it. `latency_ms` counts from the request until zero velocity
    was commanded; `confirmed`: the robot's own state shows rest. `ended` is how many commands it ended."""

    robot: str
    reached: bool
    confirmed: bool = False
    latency_ms: float | None = None
    was_moving: bool | None = None
    coasted_m: float | None = None
    ended: int = 0
    message: str = ""


class Scanned(BaseModel):
    """`heard`: the forum was asked, and everything new has been heard."""

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
