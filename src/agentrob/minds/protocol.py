"""The protocol of a mind: it reads one post and says what is requested. It never moves anything."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from agentrob.minds.usage import Usage
from agentrob.model import Capabilities, Plan, Understanding


@dataclass(frozen=True, slots=True)
class Addressee:
    """The robot for which a post is read: its mention names (without @), those of other robots, what it can do.

    `step_m` is the length of one of its steps, if configured; without it the robot asks back about "two steps".
    """

    names: Sequence[str]
    others: Sequence[str]
    capabilities: Capabilities
    step_m: float | None = None


class Mind(Protocol):
    """Reads a post's visible text for one robot."""

    name: str

    async def understand(self, text: str, addressee: Addressee, history: Sequence[Plan] = ()) -> Understanding:
        """Read `text`, the visible text (law 3) with mentions; `history` are the plans executed in this thread, oldest
        first.

        Raises `agentrob.errors.MindError` if the mind cannot answer.
        """
        ...


@dataclass(frozen=True, slots=True)
class Reading:
    """The understanding of a post and how it was reached, for reports and records (law 19).

    `mind` is the mind that answered in the end. `usage` has one entry per question to a model, including failed ones.
    `fallback` is why the mind that was asked first did not answer (an `ErrorKind`), empty if it did.
    """

    understanding: Understanding
    mind: str
    usage: tuple[Usage, ...] = ()
    fallback: str = ""


@runtime_checkable
class MeteredMind(Protocol):
    """A mind that reports what its answer cost."""

    name: str

    async def read(
        self, text: str, addressee: Addressee, history: Sequence[Plan] = (), spent: Sequence[Usage] = ()
    ) -> Reading:
        """Like `Mind.understand`. `spent` is what the same command used before."""
        ...


@runtime_checkable
class ManagedMind(Protocol):
    """A mind with resources: it prepares before the first post, and closes."""

    async def prepare(self) -> None:
        """Load what the first post would otherwise wait for. Never raises."""
        ...

    async def close(self) -> None: ...


async def read(mind: Mind, text: str, addressee: Addressee, history: Sequence[Plan] = ()) -> Reading:
    """Ask any mind; one that does not report usage counts as free."""
    if isinstance(mind, MeteredMind):
        return await mind.read(text, addressee, history)
    return Reading(await mind.understand(text, addressee, history), mind.name)
