"""Write the notes on minds in a reply: which mind replaced another, and the tokens and time used. Pure.

Names of models come from their servers, so they are shown as code.
"""

from __future__ import annotations

from collections.abc import Sequence

from agentrob.agent.reporting.report import disarmed
from agentrob.agent.understanding.extract import OVER, Assessment
from agentrob.language.messages.catalog import can_say, join_sentences, quote, say
from agentrob.minds.extraction.summary import Summary
from agentrob.minds.usage import Usage
from agentrob.model import Language


def notes(assessment: Assessment | None, asked: str, language: Language, more: Sequence[Usage] = ()) -> list[str]:
    """Return the paragraphs for a report; empty if no model was involved.

    `asked` is the configured mind, `more` the usage after the assessment.
    """
    if assessment is None:
        return []
    sentences = []
    if assessment.fallback and assessment.fallback != OVER:
        by = say("agent.mind.rules", language) if assessment.mind == "rules" else quote(assessment.mind)
        sentences.append(
            say("agent.mind.fallback", language, asked=quote(asked), why=_why(assessment.fallback, language), by=by)
        )
    if assessment.screened is not None and assessment.screened.failed not in ("", OVER):
        sentences.append(say("agent.mind.unscreened", language, why=_why(assessment.screened.failed, language)))
    line = usage_line((*assessment.usage, *more), language)
    return [part for part in (join_sentences(sentences, language), line and f"*{line}*") if part]


def summary_text(summary: Summary | None, language: Language) -> str:
    """Return a model's summary, marked as the model's words, or an empty string."""
    if summary is None or not summary.text:
        return ""
    return say("agent.mind.polished", language, text=disarmed(summary.text), mind=quote(summary.mind))


def usage_line(usage: Sequence[Usage], language: Language) -> str:
    """Return the models that were asked, with tokens, time, and costs if prices are configured.

    Questions to the same model are added up. Empty if no model was asked.
    """
    groups: dict[tuple[str, str], list[Usage]] = {}
    for one in usage:
        groups.setdefault((one.mind, one.model), []).append(one)
    return ("；" if language == "zh" else "; ").join(_taken(ones, language) for ones in groups.values())


def _taken(ones: Sequence[Usage], language: Language) -> str:
    """Return the usage of one model over all its questions."""
    first = ones[0]
    name = f"{quote(first.mind)} ({quote(first.model)})" if first.model else quote(first.mind)
    parts = []
    if len(ones) > 1:
        parts.append(say("agent.usage.questions", language, count=len(ones)))
    counted = [u for u in ones if u.input_tokens is not None and u.output_tokens is not None]
    if counted:
        into, out = sum(u.input_tokens or 0 for u in counted), sum(u.output_tokens or 0 for u in counted)
        parts.append(say("agent.usage.tokens", language, input=into, output=out))
    elif not all(u.failed for u in ones):
        parts.append(say("agent.usage.unknown", language))
    costs = [u.cost for u in ones if u.cost is not None]
    if costs and sum(costs) > 0:
        parts.append(f"{sum(costs):.4f} {first.currency}".rstrip())
    seconds = sum(u.latency_ms for u in ones) / 1000
    key = "agent.usage.failed" if all(u.failed for u in ones) else "agent.usage.time"
    parts.append(say(key, language, seconds=seconds))
    return say("agent.usage.line", language, name=name, parts=say("agent.usage.joint", language).join(parts))


def _why(kind: str, language: Language) -> str:
    key = f"agent.mind.why.{kind}"
    return say(key if can_say(key) else "agent.mind.why.failed", language)
