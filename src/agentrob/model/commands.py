"""Commands: a post, its intent, and how a mind understood it."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum
from typing import Any

from agentrob.model.accounts import Account
from agentrob.model.plans import Plan
from agentrob.model.posts import StatusCard
from agentrob.model.schedules import ScheduledRun

#: The code (ISO 639-1) of a language that `agentrob.language` knows: en, zh, and what a user adds.
Language = str


class Intent(StrEnum):
    """The purpose of a post. Only `command` moves anything."""

    COMMAND = "command"
    STOP = "stop"
    HALT = "halt"
    HELP = "help"
    STATUS = "status"
    CANCEL = "cancel"
    QUESTION = "question"
    SCHEDULES = "schedules"  # it asks for the list of schedules
    ASK_BACK = "ask_back"
    NOTHING = "nothing"


@dataclass(frozen=True, slots=True)
class Understanding:
    """A mind's reading of a post. `question` is the sentence to ask back or greet with, in `language`.

    `cancels`: its author's earlier commands that have not begun are not wanted any more ("never mind, turn left").
    `looks`: a question that a photo answers, where one may be taken ("what do you see?"); `question` is said where not.
    """

    intent: Intent
    language: Language = "en"
    plan: Plan = Plan()
    question: str = ""
    cancels: bool = False
    looks: bool = False


@dataclass(frozen=True, slots=True)
class Command:
    """A post that wants something of a robot: bound to its text and its author (law 4). `text` is the visible text.

    `run`: it is one run of a schedule. `posted_at` is then the time of the run, and `text` has no time in it.
    `part`: it is this part, counted from 1, of a post with `parts` parts for several robots; 0 for other posts.
    `further`: its robot has an earlier part in the same post.
    """

    post_id: str
    topic_id: str
    content_hash: str
    author: Account
    robot: str
    text: str
    language: Language
    posted_at: datetime
    trace_id: str
    run: ScheduledRun | None = None
    part: int = 0
    parts: int = 0
    further: bool = False

    @property
    def key(self) -> str:
        """The key under which it is claimed and carried out, once: its post; for a scheduled run also the time, and for
        a further part of a post also its number."""
        if self.further:
            return f"{self.post_id}#{self.part}"
        return self.post_id if self.run is None else f"{self.post_id}@{self.run.at:%Y%m%dT%H%M%SZ}"

    @property
    def written_at(self) -> datetime:
        """When its post was written: a later stop ends it (law 14)."""
        return self.posted_at if self.run is None else self.run.posted_at

    def card(self, state: str, **more: Any) -> StatusCard:
        """The status card of this command in a state. That of a part says to which post it belongs, and to which text,
        since the agents of other robots may wait for it."""
        if self.part:
            part = {"part": self.part, "parts": self.parts, "post": self.post_id, "content_hash": self.content_hash}
            more = part | more
        return StatusCard(self.robot, state, trace_id=self.trace_id, **more)
