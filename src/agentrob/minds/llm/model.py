"""A configured model: asked with retries, within its time, its budget and its number of parallel questions."""

from __future__ import annotations

import asyncio
import contextlib
import os
import random
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

import structlog

from agentrob.config.minds import MindConfig
from agentrob.minds.llm.budget import Budget, Reserve
from agentrob.minds.llm.chat import Answer, Image, M, Message, ModelReply, Question, Tool, ToolResult, UserMessage
from agentrob.minds.llm.errors import UNBILLED, ModelError
from agentrob.minds.llm.tool_calls import (
    checked_call,
    final_of,
    found_in,
    prompted_reply,
    schema_of,
    with_prompted_tools,
)
from agentrob.minds.usage import Usage, cost_of, estimate_tokens

_log = structlog.get_logger()

if TYPE_CHECKING:
    from agentrob.minds.llm.provider import Provider, ProviderAnswer

#: How often an invalid answer is sent back with an explanation.
_REPAIRS = 1
#: Seconds before the first retry, and at most before any.
RETRY_FIRST_S = 0.5
RETRY_MAX_S = 8.0


class ConfiguredModel:
    """One `[minds.NAME]` table. The key is read from the environment at the first question.

    `ledger` is the file with what was spent today; `chance` gives the jitter of retries, evenly in 0..1.
    """

    def __init__(
        self, name: str, config: MindConfig, ledger: Path, chance: Callable[[], float] = random.random
    ) -> None:
        self.name = name
        self.config = config
        self._budget = Budget(name, config.limits, ledger)
        self._chance = chance
        self._gate = asyncio.Semaphore(config.concurrency)
        self._opening = asyncio.Lock()
        self._provider: Provider | None = None
        self._accepts_images = True

    async def chat(self, system_prompt: str, user_message: str, spent: Sequence[Usage] = ()) -> Answer[str]:
        received, usage = await self._ask(Question(system_prompt, [UserMessage(user_message)]), spent)
        if not received.text.strip():
            raise self._unusable("an empty answer", [usage])
        return Answer(received.text.strip(), self.name, (usage,))

    async def answer(
        self,
        system_prompt: str,
        user_message: str,
        kind: type[M],
        images: Sequence[Image] = (),
        spent: Sequence[Usage] = (),
    ) -> Answer[M]:
        output = Tool("answer", "Gives the answer.", kind)
        conversation: list[Message] = [UserMessage(user_message, self._pictures(images))]
        used: list[Usage] = []
        until = monotonic() + self.config.total_s
        for _ in range(1 + _REPAIRS):
            question = Question(system_prompt, conversation, output=output)
            try:
                received, usage = await self._ask(question, [*spent, *used], until)
            except ModelError as e:
                raise _with_usage(e, used) from None
            used.append(usage)
            given = [raw for _, name, raw in received.calls if name == output.name]
            value, problem = final_of(given, kind) if given else found_in(received.text, kind)
            if value is not None:
                return Answer(value, self.name, tuple(used))
            text = str(given[-1]) if given else received.text
            conversation += [
                ModelReply(text[:2_000] or "(nothing)"),
                UserMessage(f"That cannot be used: {problem} Answer again."),
            ]
        raise self._unusable(f"no usable answer: {problem}", used)

    async def turn(
        self, system_prompt: str, conversation: Sequence[Message], tools: Sequence[Tool], spent: Sequence[Usage] = ()
    ) -> Answer[ModelReply]:
        if self.config.answers == "tools":
            received, usage = await self._ask(Question(system_prompt, conversation, tools), spent)
            calls = tuple(checked_call(call_id, name, raw, tools) for call_id, name, raw in received.calls)
            reply = ModelReply(received.text.strip(), calls)
        else:
            received, usage = await self._ask(with_prompted_tools(system_prompt, conversation, tools), spent)
            reply = prompted_reply(received.text, len(conversation), tools)
        if received.cut or not (reply.text or reply.calls):
            what = "the answer was cut off at max_output_tokens" if received.cut else "an empty answer"
            raise self._unusable(what, [usage])
        return Answer(reply, self.name, (usage,))

    @property
    def limit_s(self) -> float:
        """The longest that one answer takes."""
        return self.config.total_s

    @property
    def shares_prompt(self) -> bool:
        """Whether its server should get one system prompt for all questions."""
        return self.config.kind == "local"

    async def warm(self, system_prompt: str) -> None:
        """Let a local server read the prompt before the first post comes. Never raises."""
        if self.shares_prompt:
            with contextlib.suppress(ModelError):
                await self._ask(Question(system_prompt, [UserMessage("Answer with the one word: ready.")]), ())

    async def prepare(self) -> None:
        with contextlib.suppress(ModelError):  # the first question says what is wrong
            await self._opened()

    async def close(self) -> None:
        if self._provider is not None:
            await self._provider.close()
            self._provider = None

    def _unusable(self, why: str, used: Sequence[Usage]) -> ModelError:
        """Return the error for an answer that was paid for but cannot be used."""
        last = replace(used[-1], failed="malformed")
        return ModelError("malformed", f"{self.name}: {why}", usage=[*used[:-1], last])

    def _stop_images(self, fault: ModelError) -> ModelError:
        """Stop sending pictures to a server that fails on one (llama.cpp without a projector)."""
        if self._accepts_images:
            _log.warning("a model fails on pictures and gets none any more", mind=self.name, error=str(fault))
        self._accepts_images = False
        message = f"{self.name} fails on pictures; set images = false in [minds.{self.name}] ({fault})"
        return ModelError("rejected", message, final=True)

    def _pictures(self, images: Sequence[Image]) -> tuple[Image, ...]:
        if images and not (self.config.images and self._accepts_images):
            raise ModelError(
                "rejected", f"{self.name} takes no images (minds.{self.name}.images is false, or it failed)"
            )
        return tuple(images)

    # ------------------------------------------------------------ one question, asked until it is answered or over
    async def _ask(
        self, question: Question, spent: Sequence[Usage], until: float | None = None
    ) -> tuple[ProviderAnswer, Usage]:
        """Ask, with retries, until `until` by the monotonic clock, or for `total_s`. Each attempt reserves its cost."""
        if not self._accepts_images and question.has_images:
            raise ModelError("rejected", f"{self.name} failed on a picture before and gets none any more")
        began = monotonic()
        until = began + self.config.total_s if until is None else until
        attempt = 0
        fault: ModelError
        estimate = self._estimate(question)
        wasted = 0  # attempts that may be billed though nothing came
        try:
            async with asyncio.timeout(until - began), self._gate:
                while True:
                    attempt += 1
                    try:
                        provider = await self._opened()
                        reserve = await self._reserve(estimate, [*spent, self._lost(began, estimate, wasted)])
                        received = await self._once(provider, reserve, question)
                        return received, await self._settled(
                            reserve, received, began, attempt, self._lost(began, estimate, wasted)
                        )
                    except ModelError as e:
                        fault = e
                    if fault.kind == "server" and question.has_images:
                        fault = self._stop_images(fault)
                    wasted += fault.kind not in UNBILLED and fault.kind != "budget"
                    wait_s = retry_wait_s(attempt, self._chance(), fault.retry_after_s)
                    given_up = fault.kind == "timeout" and self.config.kind == "local"  # a retry would queue behind it
                    if given_up or not fault.transient or attempt > self.config.retries or wait_s > until - monotonic():
                        break
                    await asyncio.sleep(wait_s)
        except TimeoutError:
            fault = ModelError(
                "timeout", f"{self.name}: no answer within {self.config.total_s:g} s ({self.config.address})"
            )
            wasted += attempt > 0
        lost = replace(self._lost(began, estimate, wasted), attempts=attempt, failed=fault.kind)
        raise _with_usage(fault, [lost]) from None

    async def _once(self, provider: Provider, reserve: Reserve, question: Question) -> ProviderAnswer:
        """Make one attempt; if it was surely not served, release the reservation."""
        try:
            async with asyncio.timeout(self.config.timeout_s):
                return await provider.ask(question)
        except TimeoutError:
            limit = f"{self.config.timeout_s:g} s"
            raise ModelError("timeout", f"{self.name}: no answer within {limit} ({self.config.address})") from None
        except ModelError as e:
            if e.kind in UNBILLED:
                await self._budget.settle(reserve, 0, 0.0)
            raise

    async def _opened(self) -> Provider:
        """Return the provider, created once in a thread: its library loads slowly, and stops must not wait."""
        async with self._opening:
            if self._provider is None:
                self._provider = await asyncio.to_thread(self._open)
            return self._provider

    def _open(self) -> Provider:
        variable = self.config.key_variable
        key = os.environ.get(variable, "").strip() if variable else ""
        if variable and not key:
            raise ModelError("no_key", f"{self.name}: the environment variable {variable} must hold the key")
        if not key.isascii() or not key.isprintable():
            raise ModelError("no_key", f"{self.name}: what {variable} holds cannot be a key")
        try:
            from agentrob.minds.llm.provider import Provider
        except ImportError as e:
            missing = f"{self.name}: a model needs the extra 'models' (pip install 'agentrob[models]'): {e}"
            raise ModelError("no_library", missing) from None
        return Provider(self.name, self.config, key)

    # ------------------------------------------------------------ what it takes
    def _estimate(self, question: Question) -> tuple[int, int]:
        """Estimate the most that a question may cost: input tokens, output tokens."""
        texts = [question.system_prompt]
        texts += [m.content if isinstance(m, ToolResult) else m.text for m in question.conversation]
        tools = (*question.tools, *([question.output] if question.output else []))
        texts += [t.description + str(schema_of(t.arguments)) for t in tools]
        pictures = sum(len(m.images) for m in question.conversation if not isinstance(m, ModelReply))
        return estimate_tokens(texts, pictures), self.config.max_output_tokens

    async def _reserve(self, estimate: tuple[int, int], spent: Sequence[Usage]) -> Reserve:
        return await self._budget.reserve(sum(estimate), cost_of(*estimate, self.config.price) or 0.0, spent)

    async def _settled(
        self, reserve: Reserve, received: ProviderAnswer, began: float, attempts: int, lost: Usage
    ) -> Usage:
        """Return what an answer cost, including failed attempts before it."""
        tokens, cost = reserve.tokens, reserve.cost
        if received.input_tokens is not None and received.output_tokens is not None:
            tokens = received.input_tokens + received.output_tokens
            cost = cost_of(received.input_tokens, received.output_tokens, self.config.price) or 0.0
        await self._budget.settle(reserve, tokens, cost)
        return replace(
            lost,
            model=received.model,
            input_tokens=received.input_tokens,
            output_tokens=received.output_tokens,
            counted_tokens=tokens + lost.counted_tokens,
            cost=None if lost.cost is None else cost + lost.cost,
            latency_ms=(monotonic() - began) * 1e3,
            attempts=attempts,
        )

    def _lost(self, began: float, estimate: tuple[int, int], times: int) -> Usage:
        """Return the usage of failed attempts that may be billed, at their maximum."""
        cost = cost_of(*estimate, self.config.price)
        return Usage(
            mind=self.name,
            model=self.config.model,
            counted_tokens=times * sum(estimate),
            cost=None if cost is None else times * cost,
            currency=self.config.price.currency if self.config.price else "",
            latency_ms=(monotonic() - began) * 1e3,
        )


def _with_usage(fault: ModelError, before: Sequence[Usage]) -> ModelError:
    """Return the error with what was used before it."""
    fault.usage = (*before, *fault.usage)
    return fault


def retry_wait_s(attempt: int, chance: float, retry_after_s: float | None = None) -> float:
    """Return the seconds to wait after failed attempt number `attempt` (1, 2, …); `chance` is evenly in 0..1.

    Full jitter (a random part of a growing bound) spreads clients that failed together. A `retry_after_s` of the server
    is respected, with a small jitter on top.
    """
    bound = min(RETRY_MAX_S, RETRY_FIRST_S * 2.0 ** (min(attempt, 32) - 1))
    if retry_after_s is None:
        return bound * chance
    return max(0.0, retry_after_s) + 0.1 * bound * chance
