"""Format moments in the local time of a zone (pure)."""

from __future__ import annotations

from datetime import datetime

from agentrob.model import Language
from agentrob.model.schedules import zone_of

_DAYS = {"en": ("Mon", "Tue", "Wed", "Thu", "Fri", "Sat", "Sun"), "zh": tuple("一二三四五六日")}


def local(at: datetime, tz: str, language: Language = "en") -> str:
    """Return a moment as local time of a zone: "Mon 2026-11-23 09:00", 2026-11-23 周一 09:00."""
    there = at.astimezone(zone_of(tz))
    clock = f"{there:%H:%M:%S}" if there.second else f"{there:%H:%M}"
    if language == "zh":
        return f"{there:%Y-%m-%d} 周{_DAYS['zh'][there.weekday()]} {clock}"
    return f"{_DAYS['en'][there.weekday()]} {there:%Y-%m-%d} {clock}"
