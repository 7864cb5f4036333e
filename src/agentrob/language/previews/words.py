"""How a language asks to be shown first what a robot would do."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PreviewWords:
    """How one language asks for a preview, as regular expressions: words before the command, and behind it. `hints`
    matches words that speak of a preview, wherever they stand."""

    leads: str = "(?!)"
    ends: str = "(?!)"
    hints: str = "(?!)"
