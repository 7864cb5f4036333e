"""The schedules on a robot's card, which its forum shows. Pure."""

from __future__ import annotations

import json
from collections.abc import Sequence
from datetime import timedelta
from itertools import islice
from typing import Any

from agentrob.agent.store.rows import KeptSchedule
from agentrob.model.schedules import runs

#: The most bytes of all schedules as JSON, half of what a card may have, and characters of one command.
MOST_BYTES, MOST_CHARS = 8 * 1024, 160


def schedule_card(kept: Sequence[KeptSchedule]) -> dict[str, Any]:
    """Return the fields `schedules`, the next one first, and `schedules_more`, how many others there are."""
    running = [one for one in kept if one.ended is None and one.next_at is not None]
    found: list[dict[str, Any]] = []
    size = 0
    for one in running:
        entry = _entry(one)
        size += len(json.dumps(entry, ensure_ascii=False).encode()) + 2
        if size > MOST_BYTES:
            break
        found.append(entry)
    return {"schedules": found, "schedules_more": len(running) - len(found)}


def _entry(kept: KeptSchedule) -> dict[str, Any]:
    """`runs` are the times of all further runs, in Unix seconds. `renewable`: it ends by the limit of runs or days."""
    assert kept.next_at is not None
    schedule, text = kept.asked.schedule, kept.asked.understood
    following = list(islice(runs(schedule, kept.next_at - timedelta(seconds=1)), kept.runs_left))
    by_days = schedule.limited_days and len(following) < kept.runs_left
    return {
        "post": kept.post_id,
        "text": text if len(text) <= MOST_CHARS else text[: MOST_CHARS - 1] + "…",
        "zone": schedule.tz,
        "runs": [int(at.timestamp()) for at in following],
        "until": schedule.until_at.isoformat(),
        "renewable": schedule.limited_runs or by_days,
    }
