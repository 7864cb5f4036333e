"""The loop in which a model sees, calls a tool, and reads the measured result, until it says what it saw.

    goal (our words) ──► model ──► tool call ──► checked ──► executor (mandate, rights, lease, guard) ──► robot
                           ▲                                                                                 │
                           └────────────── result with measured values, new image on request ◄───────────────┘

The model never sees a post: the goal is rendered from a closed vocabulary. The tools' schemas limit its calls here, and
the `ToolExecutor`, the only part that moves anything, limits them again. Every loop ends: with `finish`, or when its
budget of calls, time, tokens or turns without effect is used up.
"""

from __future__ import annotations

import asyncio
import io
import json
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, Protocol

from agentrob.minds.llm.chat import ChatModel, Image, Message, ModelReply, Tool, ToolCall, ToolResult, UserMessage
from agentrob.minds.llm.errors import ModelError, one_line
from agentrob.minds.usage import Usage
from agentrob.minds.visual_loop.tools import (
    FINISH,
    SAID_CHARS,
    SAID_LINES,
    Finish,
    problem_message,
    remaining,
    result_message,
    step_of,
    tools_of,
)
from agentrob.model import PHOTO, ActionResult, Capabilities, Mandate, Outcome, Primitive, RobotState

#: Pictures are sent to the model at most this wide, as JPEG of this quality.
MAX_IMAGE_PX, JPEG_QUALITY = 1024, 80
#: The newest pictures that stay in the conversation.
PICTURES_KEPT = 2
#: Further calls in one answer are rejected: the next call should depend on the result of the first.
CALLS_AT_ONCE = 3
#: Smaller motions count as no progress.
STILL_M, STILL_DEG = 0.02, 1.0

EndReason = Literal["finished", "calls", "time", "no_progress", "tokens", "model", "cut"]


@dataclass(frozen=True, slots=True)
class StepAttempt:
    """The result of a step, or the problem why it was not tried."""

    result: ActionResult | None
    problem: str = ""


class ToolExecutor(Protocol):
    """Moves the robot for the loop, within the mandate and the laws.

    `act` may end the whole loop by raising its own exception, which the loop passes on.
    """

    @property
    def used(self) -> Sequence[ActionResult]: ...

    async def act(self, step: Primitive) -> StepAttempt: ...

    async def state(self) -> RobotState | None: ...


@dataclass(frozen=True, slots=True)
class LoopBudget:
    """Limits of a loop: tool calls, seconds in total, and turns in a row without effect."""

    calls: int = 12
    seconds: float = 120.0
    idle: int = 3


@dataclass(frozen=True, slots=True)
class LoopCall:
    """One call by the model and its result, for the transcript. `step` counts the robot's steps from 1."""

    tool: str
    arguments: dict[str, Any]
    problem: str = ""
    outcome: str = ""
    step: int | None = None
    words: str = ""
    mind: str = ""
    latency_ms: float = 0.0


@dataclass(frozen=True, slots=True)
class LoopEnd:
    """How a loop ended, and what the model claims. `claim`: done, not_possible, unsure, or empty."""

    why: EndReason
    claim: str = ""
    saw: tuple[str, ...] = ()
    did: str = ""
    fault: str = ""


@dataclass(frozen=True, slots=True)
class LoopRecord:
    """The record of a loop, kept with its command: how it ended, every call, and the model's usage.

    `contradicted` says in the language of the post which claim of the model the measurements contradict.
    """

    goal: str
    end: LoopEnd
    turns: tuple[LoopCall, ...] = ()
    usage: tuple[Usage, ...] = ()
    mind: str = ""
    contradicted: str = ""


class VisualLoop:
    """One goal, one model, one robot. `turns` and `usage` grow while `run` runs, and stay if it is cancelled."""

    def __init__(
        self, model: ChatModel, prompt: str, goal: str, mandate: Mandate, capabilities: Capabilities,
        executor: ToolExecutor, budget: LoopBudget = LoopBudget(), spent: Sequence[Usage] = (),
    ) -> None:  # fmt: skip
        self.turns: list[LoopCall] = []
        self.usage: list[Usage] = []
        self.thinking = False
        self.mind = model.name
        self._model, self._prompt, self._goal = model, prompt, goal
        self._mandate, self._executor, self._budget = mandate, executor, budget
        self._tools = tools_of(mandate, capabilities)
        self._capabilities = capabilities
        self._spent = tuple(spent)
        self._talk: list[Message] = []
        self._end_s = 0.0
        self._idle = self._calls = 0
        self._moved = True  # since the last picture
        self._asked_to_finish = False

    async def run(self) -> LoopEnd:
        """Run until the model finishes or a budget is used up."""
        self._end_s = time.monotonic() + self._budget.seconds
        await self._begin()
        while True:
            if self._left_s <= 0:
                return LoopEnd("time")
            if self._idle >= self._budget.idle:
                return LoopEnd("no_progress")
            try:
                reply = await self._think()
            except TimeoutError:
                return LoopEnd("time")
            except ModelError as e:
                self.usage += e.usage
                return LoopEnd("tokens" if e.kind == "budget" else "model", fault=e.kind)
            if (end := await self._take(reply)) is not None:
                return end

    @property
    def _left_s(self) -> float:
        return self._end_s - time.monotonic()

    async def _begin(self) -> None:
        """Send the goal, the budget, and a first picture."""
        first = await self._executor.act(Primitive(PHOTO))
        self._moved = False
        images = await self._pictures(first)
        note = "" if images else f"\nThere is no picture: {first.problem or (first.result and first.result.message)}"
        message = f"Goal: {self._goal}.\nWhat there is to spend: {self._left()}{note}\nThe picture is from now."
        self._talk.append(UserMessage(message, images))

    async def _think(self) -> ModelReply:
        """Ask the model once, within the remaining time."""
        tools: Sequence[Tool] = self._tools
        if self._calls >= self._budget.calls:  # one last time, to say what was seen
            tools = [tool for tool in self._tools if tool.name == FINISH]
        began_s = time.monotonic()
        self.thinking = True
        try:
            async with asyncio.timeout(self._left_s):
                answer = await self._model.turn(self._prompt, self._thin(), tools, (*self._spent, *self.usage))
        finally:
            self.thinking = False
        self.usage += answer.usage
        self.mind = answer.mind
        self._talk.append(answer.value)
        self._latency_ms = (time.monotonic() - began_s) * 1e3
        return answer.value

    # ------------------------------------------------------------ what the model answered
    async def _take(self, reply: ModelReply) -> LoopEnd | None:
        """Execute the calls of a reply; return the end of the loop, if reached."""
        if not reply.calls:
            return self._words(reply)
        effect = False
        for number, call in enumerate(reply.calls):
            finished = call.arguments if call.name == FINISH else None
            if isinstance(finished, Finish):
                self._note(call, reply, outcome=finished.outcome)
                return LoopEnd("finished", finished.outcome, tuple(map(one_line, finished.saw)), one_line(finished.did))
            if self._calls >= self._budget.calls:
                self._note(call, reply, problem="the calls are used up")
                return LoopEnd("calls")
            self._calls += 1
            effect |= await self._call(call, reply, number)
        self._idle = 0 if effect else self._idle + 1
        return None

    def _words(self, reply: ModelReply) -> LoopEnd | None:
        """Handle words without a call: ask once to finish properly, then take them as the end."""
        lines = [one_line(line, limit=SAID_CHARS) for line in reply.text.splitlines() if line.strip()]
        self.turns.append(
            LoopCall("", {}, words=one_line(reply.text, limit=600), mind=self.mind, latency_ms=self._latency_ms)
        )
        if self._asked_to_finish or self._calls >= self._budget.calls:
            return LoopEnd("finished", "unsure", tuple(lines[:SAID_LINES]))
        self._asked_to_finish = True
        self._idle += 1
        self._talk.append(UserMessage(f"Call a tool, or `{FINISH}` to end."))
        return None

    async def _call(self, call: ToolCall, reply: ModelReply, number: int) -> bool:
        """Execute one call; return whether it had an effect."""
        problem = call.problem
        if number >= CALLS_AT_ONCE:
            problem = f"At most {CALLS_AT_ONCE} calls at once."
        if call.arguments is None or problem:
            self._return(call, reply, problem or "These arguments cannot be used.")
            return False
        step, look = step_of(call.name, call.arguments, self._mandate, self._capabilities)
        if step.operation.picture and not self._moved:
            self._return(call, reply, "Nothing has moved since the last picture; it is still as it was.")
            return False
        found = await self._executor.act(step)
        if found.result is None:
            self._return(call, reply, found.problem)
            return False
        at = len(self._executor.used)
        images = await self._pictures(found)
        effect = _made_progress(found.result) or bool(images)
        self._moved = (self._moved or _made_progress(found.result)) and not images
        if look and effect:
            shown = await self._executor.act(Primitive(PHOTO))
            images = await self._pictures(shown)
            self._moved = self._moved and not images
        message = result_message(found.result, await self._executor.state(), self._left())
        self._talk.append(ToolResult(call, message, images))
        self._note(call, reply, outcome=str(found.result.outcome), step=at)
        return effect

    def _return(self, call: ToolCall, reply: ModelReply, problem: str) -> None:
        self._talk.append(ToolResult(call, problem_message(problem, self._left())))
        self._note(call, reply, problem=one_line(problem, limit=300))

    def _note(self, call: ToolCall, reply: ModelReply, **more: Any) -> None:
        arguments = call.arguments.model_dump(mode="json", exclude_none=True) if call.arguments else _shown(call.raw)
        words = one_line(reply.text, limit=600)
        self.turns.append(
            LoopCall(call.name, arguments, words=words, mind=self.mind, latency_ms=self._latency_ms, **more)
        )

    # ------------------------------------------------------------ what the model is shown
    def _left(self) -> dict[str, Any]:
        return remaining(self._mandate, self._executor.used, self._budget.calls - self._calls, self._left_s)

    async def _pictures(self, found: StepAttempt) -> tuple[Image, ...]:
        if found.result is None or not found.result.image:
            return ()
        return (Image(await asyncio.to_thread(shrink_jpeg, found.result.image)),)

    def _thin(self) -> list[Message]:
        """Return the conversation with only its newest pictures, because each costs tokens in every turn."""
        left, thin = PICTURES_KEPT, list(self._talk)
        for at in range(len(thin) - 1, -1, -1):
            message = thin[at]
            if isinstance(message, UserMessage | ToolResult) and message.images:
                if left <= 0:
                    thin[at] = replace(message, images=())
                left -= 1
        return thin

    _latency_ms = 0.0


def _made_progress(result: ActionResult) -> bool:
    """Return whether a step moved the robot (perhaps by an unknown amount), or was a gesture that was done."""
    if result.unmeasured:
        return True
    if result.primitive.walks:
        moved_m, turned_deg = result.measured.get("distance_m", 0.0), result.measured.get("degrees", 0.0)
        return abs(moved_m) > STILL_M or abs(turned_deg) > STILL_DEG
    return result.primitive.moves and result.outcome is Outcome.DONE


def _shown(raw: Any) -> dict[str, Any]:
    """Return arguments that did not match the schema, for the transcript only."""
    return {
        "raw": one_line(raw if isinstance(raw, str) else json.dumps(raw, ensure_ascii=False, default=str), limit=200)
    }


def shrink_jpeg(jpeg: bytes, max_px: int = MAX_IMAGE_PX) -> bytes:
    """Return the picture as a small JPEG without metadata; an unreadable one is returned as it is."""
    from PIL import Image

    try:
        with Image.open(io.BytesIO(jpeg)) as picture:
            if max(picture.size) <= max_px and picture.format == "JPEG":
                return jpeg
            picture.draft("RGB", (max_px, max_px))
            small = picture.convert("RGB")
            small.thumbnail((max_px, max_px), Image.Resampling.BILINEAR)
            out = io.BytesIO()
            small.save(out, "JPEG", quality=JPEG_QUALITY)
            return out.getvalue()
    except (OSError, ValueError):
        return jpeg
