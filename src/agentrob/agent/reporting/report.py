"""Write replies as Markdown in the language of the post. Pure.

People's words appear only as escaped code (`agentrob.language.messages.catalog.quote`). Sentences of a mind, the screen
or a driver, which may contain such words, are sanitised by `disarmed`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import timedelta

from agentrob.agent.media.pictures import Picture
from agentrob.agent.media.track import clips
from agentrob.agent.reporting.schedule_text import named
from agentrob.language.messages.catalog import can_say, join_sentences, quote, say
from agentrob.language.messages.done_text import done_text
from agentrob.language.messages.durations import duration
from agentrob.language.messages.plan_text import measured_text, step_label
from agentrob.model import (
    ActionResult,
    CommandState,
    Language,
    Outcome,
    Plan,
    Primitive,
    Report,
    RobotRights,
    RobotState,
    StopResult,
)
from agentrob.robots.safety.ranges import obstacle_in

SENTENCE_CHARS = 600
#: Estimated waiting times are rounded to this many seconds.
ROUNDED_S = 5.0
_UNSEEN = re.compile("[\u00ad\u034f\u061c\u180e\u200b-\u200f\u202a-\u202e\u2060-\u206f\ufeff\ud800-\udfff]")
#: Markup that forums interpret, with its replacements.
_DISARMING = (
    (re.compile(r"[@＠](?=\S)"), "@ "),
    (re.compile(r"<"), "‹"),
    (re.compile(r">"), "›"),
    (re.compile(r"&(?=#|\w+;)"), "& "),
    (re.compile(r"`{2,}|~{2,}"), "'"),
    (re.compile(r"!\["), "! ["),
    (re.compile(r"\](?=[(\[:])"), "] "),
    (re.compile(r"\[(?=/?[A-Za-z_]+[\]=])"), "("),
    (re.compile(r":(?=//)|\b(?<=mailto):", re.IGNORECASE), ": "),
    (re.compile(r"\bwww\.", re.IGNORECASE), "www. "),
    (re.compile(r"^(?:#+|[-+*=_|]+|\d{1,9}[.)])(?=\s|$)"), ""),
)
_COLUMNS = ("step", "asked", "measured", "outcome")
#: Reasons for which the agent itself ended a step; the driver's message does not mention them.
_NOT_THE_DRIVERS = frozenset({"stop_channel", "shutdown", "unreachable", "internal"})


# -------------------------------------------------------------------- untrusted text
def disarmed(text: str) -> str:
    """Sanitise a sentence that may contain untrusted text: one line, shortened, without mentions, pictures, links,
    addresses that a forum would link, HTML, entities, headings, quotes, lists, tables, code fences, `[tag]`s, and
    invisible or bidirectional control characters."""
    plain = " ".join(_UNSEEN.sub("", text).split())
    for pattern, instead in _DISARMING:
        plain = pattern.sub(instead, plain)
    return plain if len(plain) <= SENTENCE_CHARS else plain[: SENTENCE_CHARS - 1] + "…"


# -------------------------------------------------------------------- progress
def seen(language: Language, trace_id: str) -> str:
    return f"{say('agent.seen', language)} {_small(say('agent.trace', language, trace_id=trace_id))}"


def queued(language: Language, place: int, behind: str = "", wait_s: float | None = None) -> str:
    """`behind` is the handle of the account whose command runs before; `wait_s` about how long until its turn."""
    if not behind:
        return say("agent.queued", language, place=place)
    if wait_s is None:
        return say("agent.queued.behind.unknown", language, place=place, who=quote(behind))
    about = duration(max(ROUNDED_S, ROUNDED_S * round(wait_s / ROUNDED_S)), language)
    return say("agent.queued.behind", language, place=place, who=quote(behind), wait=about)


def running(language: Language, number: int, steps: Sequence[Primitive]) -> str:
    """`number` counts from 0."""
    return say("agent.running", language, step=number + 1, steps=len(steps), doing=doing(steps[number], language))


def planned(plan: Plan, language: Language, goal: str = "") -> str:
    """Return the goal in words if there is one, else the plan."""
    return goal or say("agent.list.joint", language).join(doing(step, language) for step in plan.steps)


def doing(step: Primitive, language: Language) -> str:
    """Return a step in words: "walk forward 1 m"."""
    return disarmed(step_label(step, language))


def waits(
    understood: str, needed: str, rights: RobotRights | None, called: str, wait_s: float, language: Language
) -> str:
    """Say that a command waits for approval: what it would do, why, who may approve it and how long it waits."""
    rights = rights or RobotRights()
    role = f"agent.who.{rights.approve}"
    who = say(role if can_say(role) else "agent.who.moderator", language)
    sentences = [
        say("agent.waits", language),
        say("agent.waits.plan", language, understood=understood),
        disarmed(needed),
        say("agent.waits.who", language, who=who, wait=duration(wait_s, language)),
        say("agent.waits.how", language, robot=called),
    ]
    sentences += [] if rights.approve_own else [say("agent.waits.own", language)]
    return join_sentences(sentences, language)


# -------------------------------------------------------------------- the end
def final(
    report: Report,
    pictures: Sequence[Picture] = (),
    notes: Sequence[str] = (),
    summary: str = "",
    calls: str = "",
    page: str = "",
) -> str:
    """Return the final reply to a command: what happened in a sentence, the steps, and details under a heading.

    The message of a stopped command names who stopped it. `summary` is a paragraph after the first one, `notes` are
    paragraphs below the table; those in small print go to the details. `calls` is a table of the model's calls with
    their steps, which replaces the table of steps. `page` is the address of the command's page, if any.
    """
    language = report.command.language
    linked = any(picture.link for picture in pictures)
    shown, small = _pictures(pictures, language), [note for note in notes if _is_small(note)]
    stopped = "" if report.stop is None else stop_figures(report.stop, language)
    warned = report.stop is not None and not report.stop.confirmed  # above everything that needs scrolling
    run = report.command.run
    command = report.command
    which = [named(run, language)] if run is not None and not run.missed else []
    which += [say("joint.part.of", language, part=command.part, parts=command.parts)] if command.parts > 1 else []
    parts = [
        *which,
        *_lead(report),
        report.hint,
        stopped if warned else "",
        summary,
        shown if linked else "",
        calls or _table(report),
    ]
    if report.plan.notes and report.status not in (CommandState.ASKS_BACK, CommandState.REFUSED):
        parts.append(say("agent.note", language, notes=" ".join(disarmed(note) for note in report.plan.notes)))
    if not warned:
        parts.append(stopped)
    if report.approved_by:
        parts.append(say("agent.approved.by", language, who=quote(report.approved_by)))
    parts += [_slower(report), *(note for note in notes if not _is_small(note))]
    parts += [f"#### {say('agent.details', language)}", "" if linked else shown, _rule(report), *small]
    parts.append(_foot(report, page))
    return "\n\n".join(part for part in parts if part)


def plain(report: Report) -> str:
    """Return the report as plain data, used if writing the reply fails."""
    steps = [
        f"{n}. `{r.primitive.op} {r.primitive.asked()}`: {r.outcome}, measured `{dict(r.measured)}`"
        for n, r in enumerate(report.results, 1)
    ]
    return "\n\n".join([f"**{report.status}**", *steps, f"`{report.command.trace_id}`"])


def short(report: Report) -> str:
    """Return the text of the status post when the report is a separate reply."""
    return say("agent.see_reply", report.command.language, state=_head(report))


def _lead(report: Report) -> list[str]:
    """Return the first paragraph: how it ended, why, and what was done until then. An answer may have several."""
    head, why, language = _head(report), _why(report), report.command.language
    if report.status is CommandState.ANSWERED:
        return [head, why]
    until_then = ""
    if report.status is not CommandState.DONE and not report.goal and (did := done_text(report.results, language)):
        until_then = say("agent.until_then", language, did=did)
    return [join_sentences((part for part in (head, why, until_then) if part), language)]


def _head(report: Report) -> str:
    language = report.command.language
    # "Nothing moved" is said only if no step was sent to the driver, or the driver refused all of them.
    begun = any(result.moved for result in report.results)
    at = next((n for n, r in enumerate(report.results, 1) if not r.ok), len(report.results))
    match report.status:
        case CommandState.DONE if report.findings:
            found = join_sentences(map(disarmed, report.findings), language)
            return say("agent.goal.found", language, found=found)
        case CommandState.DONE | CommandState.FAILED if report.goal:
            return say(f"agent.goal.{report.status}", language, goal=report.goal)
        case CommandState.ANSWERED | CommandState.EXPIRED:
            return ""
        case CommandState.DONE if did := done_text(report.results, language):
            return say("agent.done.did", language, did=did)
        case CommandState.FAILED:
            return say("agent.failed", language, step=at) if begun else say("agent.failed.before", language)
        case CommandState.CANCELLED | CommandState.REFUSED if begun:
            return say(f"agent.{report.status}.at", language, step=at)
        case CommandState.INTERRUPTED if report.message == say("agent.interrupted.claim", language):
            return ""  # the message names the state
        case CommandState.INTERRUPTED if any(r.outcome is Outcome.UNKNOWN for r in report.results):
            return say("agent.interrupted.unknown", language)
        case CommandState.STOPPED if report.message:
            return say("agent.stopped.by", language, who=quote(report.message))
        case status:
            return say(f"agent.{status}", language)


def _why(report: Report) -> str:
    """Return the verdict's reason, the message, and why the last step failed."""
    language = report.command.language
    sentences = []
    verdict = report.verdict
    if (
        verdict is not None
        and verdict.reason
        and (report.status in (CommandState.REFUSED, CommandState.CANCELLED) or verdict.rule.startswith("command."))
    ):
        sentences.append(disarmed(verdict.reason))
    if report.message and report.status is not CommandState.STOPPED:
        sentences.append(report.message if report.status is CommandState.ANSWERED else disarmed(report.message))
    if report.status not in (CommandState.DONE, CommandState.STOPPED):
        sentences += [disarmed(found) for found in report.findings]
    # On the way to a goal, a failed step may be followed by others.
    last = _decisive(report.results[-1:] if report.goal else report.results)
    if last is not None and report.status not in (CommandState.DONE, CommandState.STOPPED):
        reason = reason_text(last, language)
        sentences = [sentence for sentence in sentences if sentence not in reason]  # say "My agent was ended." once
        sentences.append(reason)
        if can_say(todo := f"agent.todo.{last.reason}"):
            sentences.append(say(todo, language))
    return "\n\n".join(sentences) if report.status is CommandState.ANSWERED else join_sentences(sentences, language)


def _rule(report: Report) -> str:
    """Name the rule that refused a command."""
    if report.status is not CommandState.REFUSED or report.verdict is None:
        return ""
    return say("agent.rule", report.command.language, rule=report.verdict.rule)


def _decisive(results: Sequence[ActionResult]) -> ActionResult | None:
    return next((r for r in results if not r.ok and r.outcome is not Outcome.SKIPPED), None)


def reason_text(result: ActionResult, language: Language) -> str:
    """Return the catalogue's sentence for the reason, if any, or the driver's English message if that says more."""
    reason = result.reason
    own = say(f"agent.reason.{reason}", language) if can_say(f"agent.reason.{reason}") else ""
    if reason == "obstacle" and (near := obstacle_in(result.message)) is not None:
        side = say(f"direction.{near[0]}", language)
        own = say("agent.reason.obstacle.near", language, side=side, distance=near[1], needed=near[2])
    if not own and not result.message and reason:
        own = say("agent.reason.other", language, reason=reason)
    detail = disarmed(result.message) if result.message and (language == "en" or not own) else ""
    if language == "en" and reason in _NOT_THE_DRIVERS:
        return f"{own} {detail}".strip()
    return (detail or own) if language == "en" else own or detail


def _table(report: Report) -> str:
    language = report.command.language
    if not report.results or all(r.outcome is Outcome.SKIPPED for r in report.results):
        return ""
    rows = [
        [str(n), asked(result, language), measured(result, language), outcome(result, language)]
        for n, result in enumerate(report.results, 1)
    ]
    return markdown_table([say(f"agent.table.{column}", language) for column in _COLUMNS], rows)


def markdown_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table whose first column is right-aligned."""
    lines = [head, ["---:", *["---"] * (len(head) - 1)], *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def asked(result: ActionResult, language: Language) -> str:
    """Return a step in words."""
    return doing(result.primitive, language)


def outcome(result: ActionResult, language: Language) -> str:
    """Return how a step ended, in a word or two."""
    text = say(f"agent.outcome.{result.outcome}", language)
    return say("agent.outcome.animated", language, outcome=text) if result.animated else text


def measured(result: ActionResult, language: Language) -> str:
    """Return what is measured of a step by the declaration of its operation, or a dash if that is nothing."""
    quantities = result.primitive.operation.measured
    if not quantities or result.outcome in (Outcome.SKIPPED, Outcome.REFUSED):
        return "–"
    found = [measured_text(result.measured[q.name], q.unit) for q in quantities if q.name in result.measured]
    if found:
        return ", ".join(found)
    why = f"agent.unknown.{result.unmeasured}"
    return say(why, language) if result.unmeasured and can_say(why) else say("agent.unknown", language)


def _slower(report: Report) -> str:
    """Say which steps were slower than requested, even if they succeeded."""
    language = report.command.language
    sentences = (say("agent.slower", language, **clip._asdict()) for clip in clips(report.results))
    return join_sentences(sentences, language)


def _pictures(pictures: Sequence[Picture], language: Language) -> str:
    """List the pictures, with links for those that are stored elsewhere."""
    names = [(p, say(f"agent.picture.{p.kind}", language, step=p.step)) for p in pictures]
    linked = [name if p.link is None else f"[{name}]({p.link.url})" for p, name in names]
    joint = "、" if language == "zh" else ", "
    if not linked:
        return ""
    sentences = [say("agent.pictures", language, pictures=joint.join(linked))]
    if valid_s := min((p.link.valid_s for p in pictures if p.link), default=None):
        sentences.append(say("agent.pictures.until", language, valid=duration(valid_s, language)))
    return join_sentences(sentences, language)


def _foot(report: Report, page: str) -> str:
    language, timings = report.command.language, report.timings_ms
    parts = [
        say(f"agent.timing.{name}", language, seconds=timings[name] / 1000)
        for name in ("seen", "first_motion", "done")
        if name in timings and (name != "done" or report.status is CommandState.DONE)
    ]
    trace = say("agent.trace", language, trace_id=report.command.trace_id)
    parts.append(f"[{trace}]({page})" if page else trace)
    return _small(" · ".join(parts))


def _small(text: str) -> str:
    return f"*{text}*"


def _is_small(text: str) -> bool:
    """Whether a paragraph is in small print as a whole."""
    return text.startswith("*") and not text.startswith("**") and text.endswith("*")


# -------------------------------------------------------------------- stop and status
def stop_figures(stop: StopResult, language: Language) -> str:
    """Describe the effect of a stop in measured figures."""
    if not stop.confirmed:
        return say("agent.stop.unconfirmed", language)
    text = say("agent.stop.moving" if stop.was_moving else "agent.stop.still", language, latency_ms=stop.latency_ms)
    if stop.was_moving and stop.coasted_m is not None:
        return text + say("agent.stop.coasted", language, coasted_m=stop.coasted_m)
    return text + say("agent.stop.end", language)


def stop_reply(
    stop: StopResult | None,
    language: Language,
    ended: int,
    halted: bool | None,
    folded: int = 0,
    how: str = "",
    taken: bool = False,
) -> str:
    """Return the reply to a stop post.

    `stop` is None if the driver was unreachable, `halted` is None if a halt was requested but only a stop succeeded.
    `ended` counts the commands that the stop ended. `how` says how to release a halt. `taken`: the post was treated as
    a stop although it may not be one.
    """
    sentences = [say("agent.stopped", language)] if stop is not None and stop.confirmed else []
    sentences += [say("agent.stop.taken", language)] if taken else []
    sentences.append(stop_figures(stop, language) if stop else say("agent.stop.unreachable", language))
    if halted is not False and stop:
        sentences.append(say("agent.stop.halted" if halted else "agent.stop.not_halted", language))
        sentences += [how] if halted and how else []
    if ended:
        sentences.append(say("agent.stop.cancelled", language, count=ended))
    if folded:
        sentences.append(say("agent.stop.folded", language, count=folded))
    return " ".join(sentences)


def clock_set(by: timedelta, language: Language) -> str:
    """Say that the forum's clock was changed, and by about how much."""
    about = duration(abs(by.total_seconds()), language)
    return say("agent.clock.back" if by < timedelta(0) else "agent.clock.ahead", language, by=about)


def state_text(state: RobotState | None, waiting: int, language: Language, message: str = "") -> str:
    """Return the answer to a status question. `state` is None if the robot is unreachable; `message` says why."""
    if state is None:
        return say("agent.status.unknown", language, message=disarmed(message))
    mode = say(f"agent.mode.{state.mode}", language) if can_say(f"agent.mode.{state.mode}") else disarmed(state.mode)
    parts = [say("agent.status.mode", language, mode=mode)]
    if state.battery_percent is None:
        parts.append(say("agent.status.battery.unknown", language))
    else:
        parts.append(say("agent.status.battery", language, percent=state.battery_percent))
    if state.pose is not None:
        parts.append(say("agent.status.pose", language, x_m=state.pose.x_m, y_m=state.pose.y_m))
    parts += [say("agent.status.halted", language)] if state.halted else []
    parts += [] if state.homed else [say("agent.status.not_homed", language)]
    parts.append(say("agent.status.queue", language, count=waiting))
    return ("，" if language == "zh" else ", ").join(parts) + ("。" if language == "zh" else ".")
