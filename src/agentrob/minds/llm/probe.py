"""Check whether the configured minds can be used, with questions like an agent's: one line each, with what to set."""

from __future__ import annotations

import asyncio
import io
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from time import monotonic
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from agentrob.config.minds import MindConfig
from agentrob.minds.extraction.schema import Wants
from agentrob.minds.llm.chat import Image, Tool, UserMessage
from agentrob.minds.llm.errors import ModelError
from agentrob.minds.llm.model import ConfiguredModel
from agentrob.minds.llm.prompt import prompts, user_message
from agentrob.minds.safety_review import review_command
from agentrob.model import Capabilities, Direction, Op, Plan, turn, walk

#: The post to read and the plan to review.
_POST = "please go ahead for one metre and then have a look to the left"
_ROBOT = Capabilities("go2", frozenset(Op))
_PLAN = Plan((walk(Direction.FORWARD, 1.0), turn(Direction.LEFT, 90.0)))
YesNo = Literal["yes", "no", "off", "unknown"]
_SYSTEM = "You are being tried out. Do exactly what is asked, with as few words as possible."
_ASK_TOOL = "Use the tool set_number with the number 7."
_ASK_COLOUR = "Which colour fills this picture? Answer with one word: red, green or blue."


class _Number(BaseModel):
    model_config = ConfigDict(extra="forbid")

    number: Annotated[int, Field(ge=0, le=9)]


_TOOL = Tool("set_number", "Sets the number.", _Number)


@dataclass(frozen=True, slots=True)
class ProbeResult:
    """The result for one mind. `problem` is empty if it can be used."""

    mind: str
    model: str
    reachable: bool
    reading_s: float = 0.0
    tool_calls: YesNo = "unknown"
    images: YesNo = "unknown"
    latency_ms: float = 0.0
    problem: str = ""
    advice: str = ""

    @property
    def ok(self) -> bool:
        return not self.problem

    def line(self) -> str:
        if not self.reachable:
            return f"{self.mind}: NOT reachable, model {self.model}: {self.problem}"
        facts = f"model {self.model}, tool calls {self.tool_calls}, images {self.images}, {self.latency_ms:.0f} ms"
        facts += f", a post read in {self.reading_s:.1f} s" if self.reading_s else ""
        return f"{self.mind}: reachable, {facts}" + (f": {said}" if (said := self.problem or self.advice) else "")

    def as_data(self) -> dict[str, Any]:
        return {**asdict(self), "ok": self.ok}


async def probe(name: str, config: MindConfig, ledger: Path) -> ProbeResult:
    """Ask one mind for a tool call, the colour of a picture, a reading and a review, without retries."""
    model = ConfiguredModel(name, config.model_copy(update={"retries": 0}), ledger)
    try:
        return await _check(model)
    finally:
        await model.close()


async def _check(model: ConfiguredModel) -> ProbeResult:
    config = model.config
    try:
        answer = await model.turn(_SYSTEM, [UserMessage(_ASK_TOOL)], [_TOOL])
        called = any(isinstance(c.arguments, _Number) and c.arguments.number == 7 for c in answer.value.calls)
    except ModelError as fault:
        if fault.kind not in ("rejected", "malformed"):
            return ProbeResult(model.name, config.model, reachable=False, problem=str(fault))
        try:  # perhaps only tools are too much for it
            answer, called = await model.turn(_SYSTEM, [UserMessage("Say yes.")], []), False
        except ModelError:
            return ProbeResult(model.name, config.model, reachable=False, problem=str(fault))
    usage = answer.usage[-1]
    problem, reading_s = "", 0.0
    if not called:
        hint = ' or set answers = "json"' if config.answers == "tools" else ""
        problem = f"it does not call tools as it was asked; try another model{hint}"
    else:
        problem, reading_s = await _works(model)
    images = await _sees(model)
    if images == "no" and not problem:
        advice = f"it takes no pictures: set images = false in [minds.{model.name}]"
    else:
        advice = ""
    return ProbeResult(
        model.name,
        usage.model,
        reachable=True,
        reading_s=reading_s,
        tool_calls="yes" if called else "no",
        images=images,
        latency_ms=usage.latency_ms,
        problem=problem,
        advice=advice,
    )


async def _works(model: ConfiguredModel) -> tuple[str, float]:
    """Return what keeps it from an agent's real work, and the seconds of a reading, with an agent's prompts and
    schemas.
    """
    begun_s = monotonic()
    try:
        system_prompt, begins = prompts(_ROBOT, "read", model.shares_prompt)
        await model.answer(system_prompt, begins + user_message(_POST, ()), Wants)
        reading_s = monotonic() - begun_s
        screened = await review_command(model, _POST, _PLAN, _ROBOT, "en")
    except ModelError as fault:
        return _advised(fault, model.config), monotonic() - begun_s
    if screened.failed:
        return f"it reads posts but cannot look at commands ({screened.failed}); try another model", reading_s
    return "", reading_s


def _advised(fault: ModelError, config: MindConfig) -> str:
    """Return what is wrong with a reading, and what to set."""
    text = str(fault)
    if fault.kind == "timeout":
        slow = "" if config.kind == "local" else ' or kind = "local"'
        return f"a post takes it longer than timeout_s = {config.timeout_s:g} s to read; set a longer one{slow}"
    if "context" in text.lower() or "too long" in text.lower():
        return f"its context is too short for a reading; start its server with 4096 tokens at least ({text})"
    if fault.kind == "malformed":
        other = "json_object" if config.answers == "tools" else "tools"
        return f'its readings are not in our schema; set answers = "{other}", or try another model ({text})'
    return text


async def _sees(model: ConfiguredModel) -> YesNo:
    """Return whether it recognises a red picture."""
    if not model.config.images:
        return "off"
    try:
        answer = await model.turn(_SYSTEM, [UserMessage(_ASK_COLOUR, (_red(),))], [])
    except ModelError as fault:
        return "no" if fault.kind in ("rejected", "malformed", "server") else "unknown"
    words = answer.value.text.lower()
    return "yes" if "red" in words and "green" not in words and "blue" not in words else "no"


def _red() -> Image:
    from PIL import Image as Picture

    data = io.BytesIO()
    Picture.new("RGB", (64, 64), (220, 20, 20)).save(data, "JPEG")
    return Image(data.getvalue())


async def probe_all(minds: Mapping[str, MindConfig], ledger: Path) -> list[ProbeResult]:
    """Probe all minds at once, in order of their names."""
    return list(await asyncio.gather(*(probe(name, minds[name], ledger) for name in sorted(minds))))
