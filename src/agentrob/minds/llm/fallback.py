"""Several models as one: each is asked if those before it failed; the usage includes the failures.

pydantic-ai's `FallbackModel` moves on after one failed request and reports no usage for requests that raised. Here a
model may retry and correct an invalid answer within its own time before the next one is asked, and what it used counts
against the limits of the command and is recorded (law 19).
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from pathlib import Path

import structlog

from agentrob.config.minds import MindConfig
from agentrob.minds.llm.chat import Answer, ChatModel, Image, M, Message, ModelReply, T, Tool
from agentrob.minds.llm.errors import ModelError
from agentrob.minds.llm.model import ConfiguredModel
from agentrob.minds.usage import Usage

_log = structlog.get_logger()


class FallbackModel:
    """Models in order of preference. Raises the last one's `ModelError` if none answers; then the rules are left."""

    def __init__(self, models: Sequence[ChatModel]) -> None:
        self.name = models[0].name
        self._models = tuple(models)

    async def chat(self, system_prompt: str, user_message: str, spent: Sequence[Usage] = ()) -> Answer[str]:
        return await self._first(lambda m, used: m.chat(system_prompt, user_message, used), spent)

    async def answer(
        self, system_prompt: str, user_message: str, kind: type[M], images: Sequence[Image] = (),
        spent: Sequence[Usage] = (),
    ) -> Answer[M]:  # fmt: skip
        return await self._first(lambda m, used: m.answer(system_prompt, user_message, kind, images, used), spent)

    async def turn(
        self, system_prompt: str, conversation: Sequence[Message], tools: Sequence[Tool], spent: Sequence[Usage] = ()
    ) -> Answer[ModelReply]:
        return await self._first(lambda m, used: m.turn(system_prompt, conversation, tools, used), spent)

    def with_images(self) -> FallbackModel | None:
        """Return those of the models that accept images; None if the first does not."""
        seers = [m for m in self._models if not isinstance(m, ConfiguredModel) or m.config.images]
        return FallbackModel(seers) if seers[:1] == list(self._models[:1]) else None

    @property
    def limit_s(self) -> float:
        """The longest time for one answer, if every model but the last fails as late as it may."""
        return sum(model.limit_s for model in self._models)

    @property
    def shares_prompt(self) -> bool:
        return self._models[0].shares_prompt

    async def warm(self, system_prompt: str) -> None:
        for model in self._models:
            await model.warm(system_prompt)

    async def prepare(self) -> None:
        for model in self._models:
            await model.prepare()

    async def close(self) -> None:
        for model in self._models:
            await model.close()

    async def _first(
        self, ask: Callable[[ChatModel, Sequence[Usage]], Awaitable[Answer[T]]], spent: Sequence[Usage]
    ) -> Answer[T]:
        failed: list[Usage] = []
        fault: ModelError | None = None
        for model in self._models:
            try:
                answer = await ask(model, [*spent, *failed])
            except ModelError as e:
                _log.warning("a model failed", mind=model.name, kind=e.kind, error=str(e))
                failed += e.usage
                fault = e
                continue
            return Answer(answer.value, answer.mind, (*failed, *answer.usage))
        assert fault is not None
        fault.usage = tuple(failed)
        raise fault


def model_with_fallbacks(name: str, minds: Mapping[str, MindConfig], ledger: Path) -> FallbackModel:
    """Return the mind of that name with its fallbacks; `rules` at their end is not a model and left to the caller."""
    names = [name, *(other for other in minds[name].fallbacks if other != "rules")]
    return FallbackModel([ConfiguredModel(n, minds[n], ledger) for n in names])
