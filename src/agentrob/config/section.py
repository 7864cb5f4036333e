"""What all tables of the configuration share: unknown keys are refused, and nothing changes once it is read."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

DEFAULT_LISTEN = "127.0.0.1:8088"
Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_-]{1,31}$")]


class Section(BaseModel):
    """Built when it is first used: most commands read few tables."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)
