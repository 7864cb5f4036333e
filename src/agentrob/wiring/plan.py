"""How a text would be understood and screened, and when it would be carried out. Nothing moves."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

from agentrob.language.addressing import part_for
from agentrob.language.messages.moments import local
from agentrob.language.schedule.reading import TimedText, timed_text
from agentrob.language.visible_text import mentions, visible_text
from agentrob.model import Account, Intent, Role, Schedule, Understanding
from agentrob.model.schedules import first_runs
from agentrob.wiring.app import capabilities_of, understand

#: How many of the next runs are named.
SHOWN = 3


def when_of(visible: str, names: Sequence[str], tz: str) -> TimedText | None:
    """When the part of a text for a robot is to be carried out; None if it says nothing about that."""
    others = [name for name in mentions(visible) if name not in names]
    return timed_text(part_for(visible, names, others), datetime.now(UTC), tz)


def plan_text(text: str, model: str, tz: str = "UTC") -> dict[str, Any]:
    """How a robot of this kind would understand a text, as data: intent, steps, notes, question, verdict; and the
    schedule, if the text says when. `tz` is the zone of its local times."""
    from agentrob.screening.screen import screen

    capabilities, visible = capabilities_of(model), visible_text(text)
    named = mentions(visible)
    name = named[0] if named else model
    understood: Understanding = asyncio.run(understand(text, name, capabilities))
    schedule: Schedule | None = None
    if (timed := when_of(visible, (name,), tz)) is not None and timed.schedule is not None:
        text = visible.replace(part_for(visible, (name,), [n for n in named if n != name]), timed.rest)
        understood, schedule = asyncio.run(understand(text, name, capabilities)), timed.schedule
    elif timed is not None and (timed.surely_later or understood.intent is not Intent.COMMAND):
        understood = Understanding(Intent.ASK_BACK, understood.language, question=timed.question)
    facts: dict[str, Any] = {
        "intent": str(understood.intent),
        "language": understood.language,
        "plan": understood.plan.as_data(),
        "notes": list(understood.plan.notes),
        "question": understood.question,
    }
    if understood.intent is Intent.COMMAND:
        author = Account(id="local", name="local", role=Role.OPERATOR)
        verdict = screen(
            understood.plan, text=text, author=author, capabilities=capabilities, language=understood.language
        )
        facts["verdict"] = {"decision": str(verdict.decision), "rule": verdict.rule, "reason": verdict.reason}
        facts |= {"schedule": _as_data(schedule)} if schedule is not None else {}
    return facts


def _as_data(schedule: Schedule) -> dict[str, Any]:
    return {
        "time_zone": schedule.tz,
        "next_runs": [local(at, schedule.tz) for at in first_runs(schedule, SHOWN)],
        "runs": schedule.runs_left,
        "until": local(schedule.until_at, schedule.tz),
    }


def describe_plan(facts: dict[str, Any]) -> str:
    """`plan_text` for people."""
    lines = [f"{facts['intent']}"]
    for n, step in enumerate(facts["plan"], 1):
        details = " ".join(f"{k}={v}" for k, v in step.items() if k != "op")
        lines.append(f"  {n}. {step['op']} {details}".rstrip())
    lines += [f"  note: {note}" for note in facts["notes"]]
    if facts["question"]:
        lines.append(f"  it would answer: {facts['question']}")
    if verdict := facts.get("verdict"):
        lines.append(f"  verdict: {verdict['decision']} ({verdict['rule']}) {verdict['reason']}".rstrip())
    if schedule := facts.get("schedule"):
        lines.append(f"  a schedule: it would not run now, but on {_times(schedule)}")
    return "\n".join(lines)


def _times(schedule: dict[str, Any]) -> str:
    times, zone = ", ".join(schedule["next_runs"]), schedule["time_zone"]
    if schedule["runs"] == 1:
        return f"{times} ({zone})"
    more = ", …" if schedule["runs"] > len(schedule["next_runs"]) else ""
    return f"{times}{more} ({zone}); {schedule['runs']} runs at most, until {schedule['until']}"
