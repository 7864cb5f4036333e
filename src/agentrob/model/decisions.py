"""The verdict of the screen, and the limits of a command that it allows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum


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
    """The most that a screened command may use up (law 7): calls per operation, metres, degrees, seconds, steps.

    `speed_mps` bounds each walk and `motions` the steps that move, where they are given.
    """

    calls: Mapping[str, int] = field(default_factory=dict)
    distance_m: float = 0.0
    degrees: float = 0.0
    seconds: float = 60.0
    steps: int = 0
    speed_mps: float | None = None
    motions: int | None = None
