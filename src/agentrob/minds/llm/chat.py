"""What a model is to us: `chat(system_prompt, user_message)`, typed answers, and turns with tools and images.

Nothing here knows a provider or a library. A conversation is a sequence of our own frozen messages, so that another
model can go on with it where one failed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from pydantic import BaseModel

from agentrob.minds.usage import Usage

T = TypeVar("T")
M = TypeVar("M", bound=BaseModel)


@dataclass(frozen=True, slots=True)
class Image:
    """A picture as bytes, sent inline; at most 1024 px is sensible."""

    data: bytes
    media_type: str = "image/jpeg"


@dataclass(frozen=True, slots=True)
class Tool:
    """Something a model may ask for. `arguments` is a closed pydantic model with bounds."""

    name: str
    description: str
    arguments: type[BaseModel]


@dataclass(frozen=True, slots=True)
class ToolCall:
    """What a model asked for. `arguments` are checked ones, or None with the `problem` to tell the model."""

    id: str
    name: str
    arguments: BaseModel | None
    problem: str = ""
    raw: Any = None


@dataclass(frozen=True, slots=True)
class UserMessage:
    """What we say to the model."""

    text: str
    images: tuple[Image, ...] = ()


@dataclass(frozen=True, slots=True)
class ModelReply:
    """What the model answered: words, calls of tools, or both."""

    text: str
    calls: tuple[ToolCall, ...] = ()


@dataclass(frozen=True, slots=True)
class ToolResult:
    """What a call came to, measured by us; goes to the model as data."""

    call: ToolCall
    content: str
    images: tuple[Image, ...] = ()


Message = UserMessage | ModelReply | ToolResult


@dataclass(frozen=True, slots=True)
class Answer(Generic[T]):
    """A value and what it cost, failed models before it included. `mind` is who answered."""

    value: T
    mind: str
    usage: tuple[Usage, ...]


class ChatModel(Protocol):
    """A model, or a chain of them. Every call raises `ModelError` when there is no answer within its budget.

    `spent` is what the command used up before, for the limits per command; pass the usage of earlier answers on.
    """

    name: str

    @property
    def limit_s(self) -> float:
        """The longest that one answer takes, in seconds."""
        ...

    @property
    def shares_prompt(self) -> bool:
        """Whether all questions had better have one system prompt (`prompt.shared_prompt`): a local server then reads
        it once, where it would read each of several anew."""
        ...

    async def warm(self, system_prompt: str) -> None:
        """Let a local server read this prompt before the first post comes; others are not asked. Never raises."""
        ...

    async def chat(self, system_prompt: str, user_message: str, spent: Sequence[Usage] = ()) -> Answer[str]:
        """Words for words."""
        ...

    async def answer(
        self,
        system_prompt: str,
        user_message: str,
        kind: type[M],
        images: Sequence[Image] = (),
        spent: Sequence[Usage] = (),
    ) -> Answer[M]:
        """An answer in a closed schema: valid, or none at all."""
        ...

    async def turn(
        self, system_prompt: str, conversation: Sequence[Message], tools: Sequence[Tool], spent: Sequence[Usage] = ()
    ) -> Answer[ModelReply]:
        """One turn with tools. Calls of unknown tools or with wrong arguments come back with a `problem`."""
        ...

    async def prepare(self) -> None:
        """Load what the first question would wait for (a second or two of a library). Asks nothing, never raises."""
        ...

    async def close(self) -> None:
        """Give connections back."""
        ...
