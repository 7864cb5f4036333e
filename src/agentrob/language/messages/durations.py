"""Format durations in words (pure). Replies give durations because they do not know the reader's time zone."""

from __future__ import annotations

from agentrob.model import Language

_SECONDS = {"day": 86_400, "hour": 3_600, "minute": 60, "second": 1}
_CHINESE = {"day": "天", "hour": "小时", "minute": "分钟", "second": "秒"}


def duration(seconds: float, language: Language = "en") -> str:
    """Return a duration in its largest unit and the next smaller one, rounded: "10 minutes", "2 hours 50 minutes".

    The shortest is one second. Languages other than Chinese use English.
    """
    whole, units = max(1, round(seconds)), list(_SECONDS)
    for larger, smaller in zip(units, [*units[1:], units[-1]], strict=True):
        size, step = _SECONDS[larger], _SECONDS[smaller]
        rounded = round(whole / step) * step
        if rounded >= size:
            parts = {larger: rounded // size, smaller: rounded % size // step} if size > step else {larger: rounded}
            return " ".join(_counted(count, unit, language) for unit, count in parts.items() if count)
    raise AssertionError("every length is at least a second")


def _counted(count: int, unit: str, language: Language) -> str:
    return f"{count} {_CHINESE[unit]}" if language == "zh" else f"{count} {unit}{'s' if count != 1 else ''}"
