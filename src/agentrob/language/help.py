"""What a robot answers to "help": made from its capabilities."""

from __future__ import annotations

from agentrob.model import Capabilities, Language


def help_text(capabilities: Capabilities, name: str, language: Language) -> str:
    """Markdown for the robot called `name` (its handle without @)."""
    return f"@{name}"
