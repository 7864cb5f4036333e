"""What the status post of a command shows before its end: its place in the queue, what it waits for, its step."""

from __future__ import annotations

from typing import Any

from agentrob.agent.queue.queue import CommandQueue, QueuedCommand
from agentrob.agent.reporting import report as reply_text
from agentrob.agent.reporting import room_text
from agentrob.agent.reporting.status_post import Shown
from agentrob.language.messages.catalog import say
from agentrob.model import CommandState, Hindrance, Plan, Primitive


def show(job: QueuedCommand, text: str, state: CommandState, **more: Any) -> None:
    """Show a text in the status post; `more` are fields of its card."""
    job.status.show(Shown(text, job.command.card(state, **more)))


def show_place(job: QueuedCommand, queue: CommandQueue) -> None:
    """Show a command that waits its place in the queue."""
    if (
        job.ended is None
        and not job.held
        and not job.waits_for_others
        and not job.begun
        and "seen" in job.timings_ms
        and (ahead := queue.ahead(job))
    ):
        left = [other.left_s for other in ahead]
        wait_s = None if None in left else sum(seconds for seconds in left if seconds is not None)
        behind = ahead[-1].command.author.name
        text = reply_text.queued(job.command.language, len(ahead), behind, wait_s)
        show(job, text, CommandState.QUEUED, place=len(ahead))


def show_wait(job: QueuedCommand, state: CommandState, hindrance: Hindrance) -> None:
    """Show for whom the command waits in the room."""
    doing = room_text.who_does(hindrance, job.command.language)
    card = f"{say('agent.room.card', job.command.language)} {doing}"
    show(job, room_text.waits_for_room(hindrance, job.command.language), state, doing=card)


def show_step(job: QueuedCommand, plan: Plan, step: Primitive, number: int) -> None:
    """Show the step that begins; `number` counts from zero."""
    language = job.command.language
    doing = reply_text.doing(step, language)
    if goal := job.goal_text:
        text = say("visual.running", language, step=number + 1, doing=doing, goal=goal)
        return show(job, text, CommandState.RUNNING, step=number + 1, doing=doing)
    text = reply_text.running(language, number, plan.steps)
    show(job, text, CommandState.RUNNING, step=number + 1, steps=len(plan.steps), doing=doing)
