"""The text about schedules in replies, in local times of their zone. Pure."""

from __future__ import annotations

import re
from collections.abc import Sequence

from agentrob.agent.store.rows import KeptSchedule
from agentrob.language.messages.catalog import join_sentences, quote, say
from agentrob.language.messages.durations import duration
from agentrob.language.messages.moments import local
from agentrob.model import Language, Schedule, ScheduledRun
from agentrob.model.schedules import runs

#: How many of the next runs the first reply names.
SHOWN = 3
#: An address that needs no escaping in a Markdown link.
_ADDRESS = re.compile(r"https?://[^\s<>()\[\]\\`*]{1,500}")


def scheduled(kept: KeptSchedule, language: Language, *, needs_approval: bool) -> str:
    """Say what was scheduled, when it runs next, when it ends, and how to cancel it."""
    schedule = kept.asked.schedule
    times = [local(at, schedule.tz, language) for _, at in zip(range(SHOWN), runs(schedule), strict=False)]
    once = schedule.runs_left == 1
    joined = say("schedule.times.joint", language).join(times)
    sentences = [
        say("schedule.made", language, understood=kept.asked.understood),
        say("schedule.next.once" if once else "schedule.next", language, times=joined, zone=schedule.tz),
        *([] if once else [_end(schedule, language)]),
        *([say("schedule.approval", language)] if needs_approval else []),
        say("schedule.how", language),
    ]
    return join_sentences(sentences, language)


def renewed(kept: KeptSchedule, language: Language) -> str:
    """Say that a schedule was renewed, when it runs next, and when it ends."""
    schedule = kept.asked.schedule
    times = [local(at, schedule.tz, language) for _, at in zip(range(SHOWN), runs(schedule), strict=False)]
    joined = say("schedule.times.joint", language).join(times)
    sentences = [
        say("schedule.renewed", language, understood=kept.asked.understood),
        say("schedule.next", language, times=joined, zone=schedule.tz),
        _end(schedule, language),
    ]
    return join_sentences(sentences, language)


def _end(schedule: Schedule, language: Language) -> str:
    until = local(schedule.until_at, schedule.tz, language)
    if schedule.limited_runs:
        key = "schedule.ends.both" if schedule.limited_days else "schedule.ends.until"
        return say(key, language, runs=schedule.runs_left, until=until)
    return say("schedule.ends.runs", language, runs=schedule.runs_left)


def listed(schedules: Sequence[KeptSchedule], language: Language) -> str:
    """List the schedules of a robot."""
    running = [kept for kept in schedules if kept.ended is None and kept.next_at is not None]
    if not running:
        return say("schedule.list.none", language)
    key = "schedule.list.one" if len(running) == 1 else "schedule.list"
    lines = [f"- {_item(kept, language)}" for kept in running]
    return "\n".join([say(key, language, count=len(running)), "", *lines, "", say("schedule.list.how", language)])


def _item(kept: KeptSchedule, language: Language) -> str:
    assert kept.next_at is not None
    tz, author = kept.asked.schedule.tz, kept.asked.command.author.name
    return say(
        "schedule.list.item", language, understood=kept.asked.understood, at=local(kept.next_at, tz, language), zone=tz,
        runs=kept.runs_left, who=quote(author),
    )  # fmt: skip


def missed(run: ScheduledRun, late_s: float, language: Language) -> str:
    """Say which runs did not take place."""
    late, at = duration(late_s, language), local(run.at, run.tz, language)
    if run.missed > 1:
        return say("agent.missed.more", language, at=at, zone=run.tz, count=run.missed - 1, late=late)
    return say("agent.missed", language, at=at, zone=run.tz, late=late)


def named(run: ScheduledRun, language: Language) -> str:
    """Name a run by its number, its schedule, with a link to its post, and its time."""
    name = say("schedule.run.schedule", language)
    schedule = f"[{name}]({run.url})" if _ADDRESS.fullmatch(run.url) else name
    key = "schedule.run.once" if run.of <= 1 else "schedule.run.limited" if run.limited else "schedule.run"
    return say(
        key, language, number=run.number, of=run.of, schedule=schedule, at=local(run.at, run.tz, language), zone=run.tz
    )  # fmt: skip
