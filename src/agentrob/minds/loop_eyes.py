"""Which models see: the configured mind and its fallbacks, as far as they take pictures, and what they are told."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from importlib import resources
from pathlib import Path

from agentrob.config import MindConfig
from agentrob.minds.chain import ChatChain
from agentrob.minds.configured import ConfiguredModel
from agentrob.model import Language

_OTHER = "robot"
#: What a model calls the language in which people want to read what it saw.
_LANGUAGES = {"en": "English", "zh": "Chinese"}


def eyes_of(name: str, minds: Mapping[str, MindConfig], ledger: Path) -> ChatChain | None:
    """The mind of that name with those of its fallbacks that take pictures; None when the first one takes none."""
    if name not in minds or not minds[name].images:
        return None
    names = [name, *(other for other in minds[name].fallbacks if other != "rules" and minds[other].images)]
    return ChatChain([ConfiguredModel(n, minds[n], ledger) for n in names])


def loop_prompt(kind: str, language: Language) -> str:
    """The prompt of the loop for a kind of robot."""
    return _prompt(kind).replace("{language}", _LANGUAGES.get(language, "English"))


@cache
def _prompt(kind: str) -> str:
    folder = resources.files("agentrob.minds") / "prompts"
    file = folder / f"loop_{kind if re.fullmatch('[a-z0-9_]+', kind) else _OTHER}.md"
    return (file if file.is_file() else folder / f"loop_{_OTHER}.md").read_text(encoding="utf-8")
