"""Let a model describe what a robot did, from measurements alone, and check every number, action and direction.

The model gets no post and no tools. Only a command that was done as requested is described; failures are reported in
our own words. A text with anything that is not in the measured results is discarded, and the structured report stands
alone.
"""

from __future__ import annotations

import asyncio
import json
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from agentrob.language.messages.plan_text import measured_text, operation_name
from agentrob.language.registry import language_of
from agentrob.minds.extraction.evidence import Evidence, EvidenceKind, evidence_in
from agentrob.minds.extraction.units import same
from agentrob.minds.llm.chat import ChatModel
from agentrob.minds.llm.errors import ModelError
from agentrob.minds.llm.prompt import clean, prompt_file
from agentrob.minds.usage import Usage
from agentrob.model import ActionResult, Language

#: Seconds that a finished report waits for the text, and its longest length.
LIMIT_S, MOST_CHARS = 8.0, 400
#: Why a text was discarded, in addition to the values of `ErrorKind`.
UNFOUNDED = "unfounded"
#: Markup, links, and characters that would hide digits from the check.
_NO_WORDS = re.compile(r"[@<>\[\]`|#*_\\~]|://|www\.")
#: Verbs in the past tense: `evidence` knows only forms that can be commands.
_PAST_VERBS = {
    "walked": "walk", "moved": "move", "went": "go", "stepped": "step", "advanced": "advance", "strolled": "stroll",
    "travelled": "travel", "traveled": "travel", "drove": "drive", "ran": "run", "crawled": "crawl", "came": "come",
    "reversed": "reverse", "retreated": "retreat", "backed": "back", "sidestepped": "sidestep", "covered": "walk",
    "turned": "turn", "rotated": "rotate", "spun": "spin", "pivoted": "pivot", "faced": "face",
    "waved": "wave", "greeted": "greet", "shook hands": "shake hands", "clapped": "clap", "applauded": "applaud",
    "flipped": "flip", "somersaulted": "somersault", "sat": "sit", "stood": "stand", "rose": "rise",
    "stretched": "stretch", "photographed": "photograph", "snapped": "snap", "looked": "look", "saw": "see",
}  # fmt: skip
_PAST = re.compile(rf"\b(?:{'|'.join(_PAST_VERBS)})\b", re.IGNORECASE)
_AMOUNTS = {EvidenceKind.LENGTH: "distance_m", EvidenceKind.ANGLE: "degrees"}


@dataclass(frozen=True, slots=True)
class Summary:
    """A text for a report. `text` is empty if there is none: `failed` says why, `problem` what was not found."""

    mind: str
    text: str = ""
    failed: str = ""
    problem: str = ""
    usage: tuple[Usage, ...] = ()

    def as_data(self) -> dict[str, Any]:
        """Return the summary for records and logs."""
        models = [usage.as_data() for usage in self.usage]
        return {"mind": self.mind, "text": self.text, "failed": self.failed, "problem": self.problem, "models": models}


async def summarise(
    model: ChatModel,
    results: Sequence[ActionResult],
    language: Language,
    spent: Sequence[Usage] = (),
    limit_s: float = LIMIT_S,
) -> Summary:
    """Ask a model to describe steps that were all done. Never raises if the model fails."""
    try:
        async with asyncio.timeout(limit_s):
            answer = await model.chat(prompt_file("summary"), _message(results, language), spent=spent)
    except ModelError as e:
        return Summary(model.name, failed=e.kind, usage=e.usage)
    except TimeoutError:
        lost = Usage(model.name, "", latency_ms=limit_s * 1e3, failed="timeout")
        return Summary(model.name, failed="timeout", usage=(lost,))
    text = " ".join(clean(answer.value[: 10 * MOST_CHARS]).split())
    if problem := unfounded(text, results, language):
        return Summary(answer.mind, failed=UNFOUNDED, problem=problem, usage=answer.usage)
    return Summary(answer.mind, text, usage=answer.usage)


def unfounded(text: str, results: Sequence[ActionResult], language: Language) -> str:
    """Return what in a text does not follow from the results, in English; empty if all of it does. Pure."""
    if not results or not all(r.ok for r in results):
        return "not everything was done"
    if any(r.primitive.declared is not None for r in results):
        return "an operation whose words nobody can check"
    if not 0 < len(text) <= MOST_CHARS or _NO_WORDS.search(text):
        return "empty, too long or more than words"
    if language_of(text) != language:
        return "another language"
    present = _PAST.sub(lambda past: _PAST_VERBS[past[0].lower()], text)
    mentions = evidence_in(present)
    for mention in mentions:
        if problem := _invented(mention, results):
            return f"{problem}: {present[mention.start : mention.end]}"
    if stray := _stray_digit(present, mentions):
        return f"a number that cannot be read: {stray}"
    return ""


def _invented(mention: Evidence, results: Sequence[ActionResult]) -> str:
    """Return what is wrong with one statement of a text."""
    match mention.kind:
        case EvidenceKind.LENGTH | EvidenceKind.ANGLE:
            measured = [r.measured[_AMOUNTS[mention.kind]] for r in results if _AMOUNTS[mention.kind] in r.measured]
            return "" if any(_matches(mention.value, m) for m in measured) else "not measured"
        case EvidenceKind.SPEED:
            return "not measured"
        case EvidenceKind.NUMBER | EvidenceKind.TIMES:
            counts = {1, *Counter(r.primitive.op for r in results).values()}
            steps = {len(results)} if mention.kind is EvidenceKind.NUMBER else set()
            return "" if mention.value in counts | steps else "not counted"
        case EvidenceKind.ACTION:
            return "" if any(r.primitive.op is mention.op for r in results) else "not done"
        case EvidenceKind.DIRECTION:
            return "" if any(r.primitive.direction is mention.direction for r in results) else "not this way"
        case EvidenceKind.NOT | EvidenceKind.IF:
            return "no plain statement of what was done"
    return ""


def _matches(said: float, measured: float) -> bool:
    """Return whether it is the figure in the report, within one per cent."""
    return same(said, measured) or same(said, round(measured, 2))


def _stray_digit(text: str, mentions: Sequence[Evidence]) -> str:
    """Return digits outside of every number that was read."""
    for match in re.finditer(r"\d[\d.,/]*", text):
        if not any(m.start <= match.start() < m.end for m in mentions):
            return match[0]
    return ""


def _message(results: Sequence[ActionResult], language: Language) -> str:
    name = {"en": "English", "zh": "Chinese"}.get(language, f"the language {language!r} (ISO 639-1)")
    done = [{"did": _action(r), **_figure(r)} for r in results]
    return f"Write in {name}. All of this was done:\n{json.dumps(done, ensure_ascii=False)}"


def _action(result: ActionResult) -> str:
    """Return the action without its requested amount: only measurements are reported."""
    return f"{operation_name(result.primitive.operation, 'en')} {result.primitive.direction or ''}".strip()


def _figure(result: ActionResult) -> dict[str, str]:
    quantities = [q for q in result.primitive.operation.measured if q.name in result.measured]
    figures = [measured_text(result.measured[q.name], q.unit).replace("°", " degrees") for q in quantities]
    return {"measured": ", ".join(figures)} if figures else {}
