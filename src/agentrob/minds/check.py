"""Whether the configured minds can be used: reachable, tool calls, images, latency; one line each."""

from __future__ import annotations

import asyncio
import io
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from agentrob.config import MindConfig
from agentrob.minds.chat import Image, Said, Tool
from agentrob.minds.configured import ConfiguredModel
from agentrob.minds.faults import MindFault

YesNo = Literal["yes", "no", "off", "unknown"]
_SYSTEM = "You are being tried out. Do exactly what is asked, with as few words as possible."
_ASK_TOOL = "Use the tool set_number with the number 7."
_ASK_COLOUR = "Which colour fills this picture? Answer with one word: red, green or blue."


class _Number(BaseModel):
    model_config = ConfigDict(extra="forbid")

    number: Annotated[int, Field(ge=0, le=9)]


_TOOL = Tool("set_number", "Sets the number.", _Number)


@dataclass(frozen=True, slots=True)
class Checked:
    """One mind as it is now. `problem` is empty when it can be used."""

    mind: str
    model: str
    reachable: bool
    tool_calls: YesNo = "unknown"
    images: YesNo = "unknown"
    latency_ms: float = 0.0
    problem: str = ""

    @property
    def ok(self) -> bool:
        return not self.problem

    def line(self) -> str:
        if not self.reachable:
            return f"{self.mind}: NOT reachable, model {self.model}: {self.problem}"
        facts = f"model {self.model}, tool calls {self.tool_calls}, images {self.images}, {self.latency_ms:.0f} ms"
        return f"{self.mind}: reachable, {facts}" + (f": {self.problem}" if self.problem else "")

    def as_data(self) -> dict[str, Any]:
        return {**asdict(self), "ok": self.ok}


async def check(name: str, config: MindConfig, ledger: Path) -> Checked:
    """Ask one mind for a tool call and for the colour of a picture; at most three questions, without retries."""
    model = ConfiguredModel(name, config.model_copy(update={"retries": 0}), ledger)
    try:
        return await _check(model)
    finally:
        await model.close()


async def _check(model: ConfiguredModel) -> Checked:
    config = model.config
    try:
        answer = await model.turn(_SYSTEM, [Said(_ASK_TOOL)], [_TOOL])
        called = any(isinstance(c.arguments, _Number) and c.arguments.number == 7 for c in answer.value.calls)
    except MindFault as fault:
        if fault.kind not in ("rejected", "malformed"):
            return Checked(model.name, config.model, reachable=False, problem=str(fault))
        try:  # perhaps only tools are too much for it
            answer, called = await model.turn(_SYSTEM, [Said("Say yes.")], []), False
        except MindFault:
            return Checked(model.name, config.model, reachable=False, problem=str(fault))
    usage = answer.usage[-1]
    problem = ""
    if not called:
        hint = ' or set answers = "json"' if config.answers == "tools" else ""
        problem = f"it does not call tools as it was asked; try another model{hint}"
    return Checked(
        model.name,
        usage.model,
        reachable=True,
        tool_calls="yes" if called else "no",
        images=await _sees(model),
        latency_ms=usage.latency_ms,
        problem=problem,
    )


async def _sees(model: ConfiguredModel) -> YesNo:
    """Whether it can tell a red picture from others."""
    if not model.config.images:
        return "off"
    try:
        answer = await model.turn(_SYSTEM, [Said(_ASK_COLOUR, (_red(),))], [])
    except MindFault as fault:
        return "no" if fault.kind in ("rejected", "malformed", "server") else "unknown"
    words = answer.value.text.lower()
    return "yes" if "red" in words and "green" not in words and "blue" not in words else "no"


def _red() -> Image:
    from PIL import Image as Picture

    data = io.BytesIO()
    Picture.new("RGB", (64, 64), (220, 20, 20)).save(data, "JPEG")
    return Image(data.getvalue())


async def check_all(minds: Mapping[str, MindConfig], ledger: Path) -> list[Checked]:
    """All of them at once, in order of their names."""
    return list(await asyncio.gather(*(check(name, minds[name], ledger) for name in sorted(minds))))
