"""The interface to a model: `chat(system_prompt, user_message)`, typed answers, and turns with tools and images.

It is independent of providers and libraries. A conversation is a sequence of our own frozen messages, so that another
model can continue it after a failure.
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
    """An image as bytes, sent inline; at most 1024 px is sensible."""

    data: bytes
    media_type: str = "image/jpeg"


@dataclass(frozen=True, slots=True)
class Tool:
    """A tool that a model may call. `arguments` is a closed pydantic model with bounds."""

    name: str
    description: str
    arguments: type[BaseModel]


@dataclass(frozen=True, slots=True)
class ToolCall:
    """A call by the model. `arguments` are validated, or None with the `problem` to tell the model."""

    id: str
    name: str
    arguments: BaseModel | None
    problem: str = ""
    raw: Any = None


@dataclass(frozen=True, slots=True)
class UserMessage:
    """A message from us to the model."""

    text: str
    images: tuple[Image, ...] = ()


@dataclass(frozen=True, slots=True)
class ModelReply:
    """The model's reply: words, tool calls, or both."""

    text: str
    calls: tuple[ToolCall, ...] = ()


@dataclass(frozen=True, slots=True)
class ToolResult:
    """The measured result of a call; the model gets it as data."""

    call: ToolCall
    content: str
    images: tuple[Image, ...] = ()


Message = UserMessage | ModelReply | ToolResult


@dataclass(frozen=True, slots=True)
class Question:
    """One question to a model. With `output`, the reply must give the arguments of this tool."""

    system_prompt: str
    conversation: Sequence[Message]
    tools: Sequence[Tool] = ()
    output: Tool | None = None

    @property
    def has_images(self) -> bool:
        return any(message.images for message in self.conversation if not isinstance(message, ModelReply))


@dataclass(frozen=True, slots=True)
class Answer(Generic[T]):
    """A value and what it cost, including models that failed before. `mind` is who answered."""

    value: T
    mind: str
    usage: tuple[Usage, ...]


class ChatModel(Protocol):
    """A model, or several with fallback. Every call raises `ModelError` if there is no answer within its budget.

    `spent` is what the command used before, for the limits per command; pass on the usage of earlier answers.
    """

    name: str

    @property
    def limit_s(self) -> float:
        """The longest time for one answer, in seconds."""
        ...

    @property
    def shares_prompt(self) -> bool:
        """Whether all questions should share one system prompt (`prompt.shared_prompt`).

        A local server caches the prompt it read last, and would read several prompts anew each time.
        """
        ...

    async def warm(self, system_prompt: str) -> None:
        """Let a local server process this prompt before the first post; others are not called. Never raises."""
        ...

    async def chat(self, system_prompt: str, user_message: str, spent: Sequence[Usage] = ()) -> Answer[str]:
        """Answer text with text."""
        ...

    async def answer(
        self,
        system_prompt: str,
        user_message: str,
        kind: type[M],
        images: Sequence[Image] = (),
        spent: Sequence[Usage] = (),
    ) -> Answer[M]:
        """Answer in a closed schema; an answer is always valid."""
        ...

    async def turn(
        self, system_prompt: str, conversation: Sequence[Message], tools: Sequence[Tool], spent: Sequence[Usage] = ()
    ) -> Answer[ModelReply]:
        """Take one turn with tools. Calls of unknown tools or with invalid arguments come back with a `problem`."""
        ...

    async def prepare(self) -> None:
        """Load what the first question would wait for (a library, a second or two). Asks nothing, never raises."""
        ...

    async def close(self) -> None:
        """Close connections."""
        ...
