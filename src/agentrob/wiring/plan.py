"""How a text would be understood and screened, and when it would be carried out. Nothing moves."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

from agentrob.language.addressing import part_for
from agentrob.language.joint.parts import JointCommand
from agentrob.language.joint.reading import JointProblem, joint_command
from agentrob.language.messages.moments import local
from agentrob.language.previews.reading import rehearsed_part
from agentrob.language.schedule.reading import TimedText, cancels_elsewhere, lists_schedules, timed_text
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
    if (joint := joint_command(visible)) is not None:
        return _joint_facts(joint)
    named = mentions(visible)
    name = named[0] if named else model
    others = tuple(other for other in named if other != name)
    part = part_for(visible, (name,), others)
    rehearsed = rehearsed_part(part, visible)
    if rehearsed:
        text = visible = f"@{name} {rehearsed}"
    understood: Understanding = asyncio.run(understand(text, name, capabilities))
    schedule: Schedule | None = None
    if lists_schedules(part) or cancels_elsewhere(part):
        understood = Understanding(Intent.SCHEDULES, understood.language)
    elif (timed := when_of(visible, (name,), tz)) is not None and timed.schedule is not None:
        text = visible.replace(part_for(visible, (name,), [n for n in named if n != name]), timed.rest)
        understood, schedule = asyncio.run(understand(text, name, capabilities)), timed.schedule
    elif timed is not None and (
        understood.intent is Intent.ASK_BACK or (timed.surely_later and understood.intent is Intent.COMMAND)
    ):
        understood = Understanding(Intent.ASK_BACK, understood.language, question=timed.question)
    facts: dict[str, Any] = {
        "intent": "preview" if rehearsed and understood.intent is Intent.COMMAND else str(understood.intent),
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


def _joint_facts(joint: JointCommand | JointProblem) -> dict[str, Any]:
    """The parts of a post whose robots wait for each other. Whether a robot may do its part is judged by its own
    agent."""
    facts: dict[str, Any] = {"language": joint.language, "plan": [], "notes": [], "question": ""}
    if isinstance(joint, JointProblem):
        return {"intent": str(Intent.ASK_BACK), **facts, "question": f"{joint.question} {joint.example}"}
    parts = [
        {"robots": list(part.robots), "after": list(part.after), "plan": part.plan.as_data(), "notes": part.plan.notes}
        for part in joint.parts
    ]
    return {"intent": str(Intent.COMMAND), **facts, "parts": parts}


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
    for number, part in enumerate(facts.get("parts", ()), 1):
        after = f", after part {' and '.join(map(str, part['after']))}" if part["after"] else ""
        lines.append(f"  part {number}: {' or '.join('@' + name for name in part['robots'])}{after}")
        lines += [f"    {_step(n, step)}" for n, step in enumerate(part["plan"], 1)]
        lines += [f"    note: {note}" for note in part["notes"]]
    for n, step in enumerate(facts["plan"], 1):
        lines.append(f"  {_step(n, step)}")
    lines += [f"  note: {note}" for note in facts["notes"]]
    if facts["question"]:
        lines.append(f"  it would answer: {facts['question']}")
    if verdict := facts.get("verdict"):
        lines.append(f"  verdict: {verdict['decision']} ({verdict['rule']}) {verdict['reason']}".rstrip())
    if schedule := facts.get("schedule"):
        lines.append(f"  a schedule: it would not run now, but on {_times(schedule)}")
    return "\n".join(lines)


def _step(number: int, step: dict[str, Any]) -> str:
    details = " ".join(f"{k}={v}" for k, v in step.items() if k != "op")
    return f"{number}. {step['op']} {details}".rstrip()


def _times(schedule: dict[str, Any]) -> str:
    times, zone = ", ".join(schedule["next_runs"]), schedule["time_zone"]
    if schedule["runs"] == 1:
        return f"{times} ({zone})"
    more = ", …" if schedule["runs"] > len(schedule["next_runs"]) else ""
    return f"{times}{more} ({zone}); {schedule['runs']} runs at most, until {schedule['until']}"
