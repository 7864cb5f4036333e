"""What a mind is: it reads one post and says what is wanted. It never moves anything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from agentrob.model import Capabilities, Plan, Understanding


@dataclass(frozen=True, slots=True)
class Listener:
    """For whom a post is read: the robot's own mention patterns (without @), those of others, what it can do.

    `step_m` is the length of one of its steps, where somebody has measured it; without it "two steps" is asked back.
    """

    names: Sequence[str]
    others: Sequence[str]
    capabilities: Capabilities
    step_m: float | None = None


class Mind(Protocol):
    """Reads a post's visible text for one robot."""

    name: str

    async def understand(self, text: str, listener: Listener, history: Sequence[Plan] = ()) -> Understanding:
        """`text` is the visible text (law 3), mentions included; `history` the plans done before in this thread,
        oldest first.

        Raises `agentrob.errors.MindError` when the mind cannot answer at all.
        """
        ...
