"""What a mind is: it reads one post and says what is wanted. It never moves anything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from agentrob.minds.usage import Usage
from agentrob.model import Capabilities, Plan, Understanding


@dataclass(frozen=True, slots=True)
class Addressee:
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

    async def understand(self, text: str, addressee: Addressee, history: Sequence[Plan] = ()) -> Understanding:
        """`text` is the visible text (law 3), mentions included; `history` the plans done before in this thread,
        oldest first.

        Raises `agentrob.errors.MindError` when the mind cannot answer at all.
        """
        ...


@dataclass(frozen=True, slots=True)
class Reading:
    """What was made of a post, and how: for reports and records (law 19).

    `mind` is who answered in the end. `usage` is one entry per question to a model, failed ones included. `fallback` is
    why the mind that was asked first did not answer itself (a word of `ErrorKind`), empty when it did.
    """

    understanding: Understanding
    mind: str
    usage: tuple[Usage, ...] = ()
    fallback: str = ""


@runtime_checkable
class MeteredMind(Protocol):
    """A mind that tells what its answer took."""

    name: str

    async def read(
        self, text: str, addressee: Addressee, history: Sequence[Plan] = (), spent: Sequence[Usage] = ()
    ) -> Reading:
        """As `Mind.understand`. `spent` is what the same command used up before."""
        ...


@runtime_checkable
class ManagedMind(Protocol):
    """A mind that holds something: it gets ready before the first post and gives back what it holds."""

    async def prepare(self) -> None:
        """Load what the first post would wait for. Never raises."""
        ...

    async def close(self) -> None: ...


async def read(mind: Mind, text: str, addressee: Addressee, history: Sequence[Plan] = ()) -> Reading:
    """Ask any mind; one that tells nothing of what it took is believed to have taken nothing."""
    if isinstance(mind, MeteredMind):
        return await mind.read(text, addressee, history)
    return Reading(await mind.understand(text, addressee, history), mind.name)
