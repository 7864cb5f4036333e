"""The base model of all tables: it rejects unknown keys, and instances are immutable."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

DEFAULT_LISTEN = "127.0.0.1:8088"
Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_-]{1,31}$")]


class Section(BaseModel):
    """One table. Its validator is built on first use, because most commands read few tables."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)
