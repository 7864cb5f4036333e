"""The closed schema in which a model says what a post requests: enumerated actions, bounded numbers, no free text.

The model's quotation (`words`) is only looked up in the post, never shown or executed.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from agentrob.minds.extraction.units import SpeedUnit, Unit
from agentrob.model import Direction, Op, Primitive


class _Closed(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


Amount = Annotated[float, Field(gt=0, le=10_000, allow_inf_nan=False)]


class ExtractedStep(_Closed):
    """One thing to do, as the post says it: numbers and units as written there."""

    action: Op
    direction: Direction | None = None
    amount: Amount | None = Field(default=None, description="the number as written; null when the post gives none")
    unit: Unit | None = Field(default=None, description="the unit as written; null without an amount")
    speed: Amount | None = None
    speed_unit: SpeedUnit | None = None
    slow: bool = Field(default=False, description="true when the post asks to do this slowly")
    times: Annotated[int, Field(ge=1, le=20)] = 1
    words: Annotated[str, Field(max_length=300)] = Field(description="the words of the post for this step, copied")

    @property
    def translates(self) -> bool:
        """Whether it asks for a walk."""
        return Primitive(self.action).translates

    @property
    def rotates(self) -> bool:
        """Whether it asks for a turn."""
        return Primitive(self.action).rotates


class Wants(_Closed):
    """What the post requests of this robot."""

    intent: Literal["command", "nothing", "unclear"]
    steps: Annotated[tuple[ExtractedStep, ...], Field(max_length=20)] = ()
    doubt: Literal["none", "distance", "angle", "direction", "unit", "condition", "place", "meaning"] = "none"
