"""The text about a preview in replies. Names of things are the owner's words, so they are disarmed. Pure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median

from agentrob.agent.media import track
from agentrob.agent.reporting.report import disarmed, doing, reason_text
from agentrob.agent.store.rows import ApprovalDecision
from agentrob.language.messages.catalog import join_sentences, quote, say
from agentrob.minds.visual_loop.vocabulary import chinese, thing_named
from agentrob.model import ActionResult, Language, Pose
from agentrob.rehearsal.geometry import seen_from
from agentrob.rehearsal.preview import Basis, Ending, Preview

#: The nearest things that a reply names.
NEAREST = 5


def preview_text(preview: Preview, language: Language) -> str:
    """The answer to "preview …": what was found, and how to carry it out."""
    return "\n\n".join([findings(preview, language), say("preview.how", language)])


def approval_preview(preview: Preview, language: Language) -> str:
    """Show a preview to people who may approve its command, and say that their approval is bound to it."""
    return "\n\n".join([findings(preview, language), say("preview.bound", language, hash=preview.hash[:12])])


def preview_paragraphs(
    preview: Preview | None,
    decided: ApprovalDecision | None,
    results: Sequence[ActionResult],
    language: Language,
    *,
    rehearsable: bool,
) -> list[str]:
    """Compare the preview with the measured results, or say that an approval came without one. A command whose steps a
    model chooses by the camera is not `rehearsable`."""
    sentences = [beside_measured(preview, results, language)] if preview is not None else []
    if rehearsable and decided is not None and decided.approved and not decided.preview:
        sentences.append(say("preview.unbound", language))
    return sentences


def beside_measured(preview: Preview, results: Sequence[ActionResult], language: Language) -> str:
    """Compare the expected with the measured result, for the report of a command that had a preview; empty if nothing
    moved. Ends are compared in the frame of each start, since odometry and room have their own."""
    measured = [Pose(*point[1:]) for result in results for point in result.path]
    took_s = track.seconds(results)
    if not took_s or not any(result.moved for result in results):
        return ""
    expected = say("preview.beside", language, expected=preview.median_s, worst=preview.worst_s, measured=took_s)
    if not measured or preview.start is None:
        return expected
    ends = [seen_from(preview.start, Pose(*run.path[-1])) for run in preview.runs]
    end = seen_from(measured[0], measured[-1])
    apart_m = median(math.hypot(one.x_m - end.x_m, one.y_m - end.y_m) for one in ends)
    return join_sentences([expected, say("preview.beside.end", language, metres=apart_m)], language)


def findings(preview: Preview, language: Language) -> str:
    """The findings of a preview, as a sentence and a list."""
    lines = [_result(preview, language)]
    lines += [_ending(ending, preview, language) for ending in preview.endings]
    if any(run.fell for run in preview.runs):
        lines.append(say("preview.fell", language, count=sum(run.fell for run in preview.runs)))
    if preview.touched:
        lines.append(say("preview.touched", language, things=_names(preview.touched, language)))
    if any(run.done for run in preview.runs):
        lines.append(_duration(preview, language))
    lines += [line] if (line := _nearest(preview, language)) else []
    if not preview.others_known:
        lines.append(say("preview.others_unknown", language))
    listed = "\n".join(f"- {line}" for line in lines)
    return f"{_head(preview, language)}\n\n{listed}"


def _head(preview: Preview, language: Language) -> str:
    head = say("preview.head", language)
    if preview.basis is Basis.SIMULATION:
        assert preview.start is not None
        where = say("preview.from", language, x_m=preview.start.x_m, y_m=preview.start.y_m)
        return join_sentences([head, say("preview.simulated", language, runs=len(preview.runs)), where], language)
    why = say(f"preview.missing.{preview.missing}", language) if preview.missing else ""
    return join_sentences([head, *([why] if why else []), say("preview.geometry", language)], language)


def _result(preview: Preview, language: Language) -> str:
    if preview.basis is Basis.GEOMETRY:
        return say("preview.allowed" if preview.done else "preview.not_allowed", language)
    if preview.done == len(preview.runs):
        return say("preview.done", language, runs=preview.done)
    if not preview.done:
        return say("preview.done.none", language, runs=len(preview.runs))
    return say("preview.done.some", language, done=preview.done, runs=len(preview.runs))


def _ending(ending: Ending, preview: Preview, language: Language) -> str:
    """At which step runs ended, where, and why."""
    step, result = ending.step, ActionResult(ending.step.primitive, ending.step.outcome, reason=ending.step.reason,
                                             message=ending.step.message)  # fmt: skip
    why = reason_text(result, language)
    key = "preview.ended" if preview.basis is Basis.SIMULATION else "preview.refused"
    where = say("preview.at", language, x_m=step.at[0], y_m=step.at[1]) if step.at is not None else ""
    doing_ = doing(step.primitive, language)
    return say(key, language, runs=ending.runs, step=ending.number, doing=doing_, where=where, why=why)


def _duration(preview: Preview, language: Language) -> str:
    if preview.basis is Basis.GEOMETRY:
        return say("preview.seconds.about", language, seconds=preview.median_s)
    return say("preview.seconds", language, median=preview.median_s, worst=preview.worst_s)


def _nearest(preview: Preview, language: Language) -> str:
    shown = list(preview.distances_m.items())[:NEAREST]
    if not shown:
        return ""
    parts = [say("preview.distance", language, thing=_name(name, language), metres=metres) for name, metres in shown]
    return say("preview.nearest", language, distances=say("agent.list.joint", language).join(parts))


def _names(names: tuple[str, ...], language: Language) -> str:
    return say("agent.list.joint", language).join(_name(name, language) for name in names)


def _name(name: str, language: Language) -> str:
    """A thing in the words of the world or, where they are known, in Chinese; a robot by its handle; or a wall."""
    if name == "wall":
        return say("preview.wall", language)
    if name.startswith("@"):
        return quote(name.removeprefix("@"))
    known = thing_named(name) if language == "zh" else None
    return disarmed(name) if known is None else chinese(known.colour) + chinese(known.thing)
