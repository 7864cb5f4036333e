"""What a post wants of a robot."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

from agentrob.model.accounts import Account
from agentrob.model.plans import Plan
from agentrob.model.schedules import ScheduledRun

#: The code (ISO 639-1) of a language that `agentrob.language` knows: en, zh, and what a user adds.
Language = str


class Intent(StrEnum):
    """What a post wants of the robot. Only `command` moves anything."""

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
    """What a mind made of a post. `question` is the sentence to ask back or greet with, in `language`.

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

    @property
    def key(self) -> str:
        """What it is claimed and carried out under, once: its post, and of a scheduled run also its time."""
        return self.post_id if self.run is None else f"{self.post_id}@{self.run.at:%Y%m%dT%H%M%SZ}"

    @property
    def written_at(self) -> datetime:
        """When its post was written: a later stop ends it (law 14)."""
        return self.posted_at if self.run is None else self.run.posted_at
