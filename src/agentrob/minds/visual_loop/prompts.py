"""What a model that steers by a camera is told: a prompt for each kind of robot."""

from __future__ import annotations

import re
from functools import cache
from importlib import resources

from agentrob.model import Language

_OTHER = "robot"
#: What a model calls the language in which people want to read what it saw.
_LANGUAGES = {"en": "English", "zh": "Chinese"}


def loop_prompt(kind: str, language: Language) -> str:
    """The prompt of the loop for a kind of robot."""
    return _prompt(kind).replace("{language}", _LANGUAGES.get(language, "English"))


@cache
def _prompt(kind: str) -> str:
    folder = resources.files("agentrob.minds") / "prompts"
    file = folder / f"loop_{kind if re.fullmatch('[a-z0-9_]+', kind) else _OTHER}.md"
    return (file if file.is_file() else folder / f"loop_{_OTHER}.md").read_text(encoding="utf-8")
