"""Describe a visual loop: what was measured, what the model claims, and why it ended. Pure.

The model's words may come from text in front of the camera. They are quoted as escaped code of at most 100 characters,
marked as the model's claims, beside the robot's measurements.
"""

from __future__ import annotations

import json
from collections.abc import Sequence

from agentrob.language.messages.catalog import can_say, join_sentences, quote, say
from agentrob.minds.visual_loop.claims import turned_deg, walked_m
from agentrob.minds.visual_loop.loop import LoopCall, LoopRecord
from agentrob.model import ActionResult, Language, Outcome

#: The maximum number of refused calls in a report.
MOST_REFUSED = 3


def paragraphs(
    looked: LoopRecord | None, results: Sequence[ActionResult], language: Language, *, refused: bool = True
) -> list[str]:
    """Return the paragraphs for a report: measured totals, the model's claims and, with `refused`, refused calls."""
    if looked is None:
        return []
    done = [r for r in results if r.outcome not in (Outcome.SKIPPED, Outcome.REFUSED)]
    sentences = [say(
        "visual.measured", language, metres=walked_m(done), degrees=turned_deg(done),
        pictures=sum(r.primitive.operation.picture for r in done), calls=len(looked.turns),
    )]  # fmt: skip
    if unknown := sum(bool(r.unmeasured) for r in done):
        sentences.append(say("visual.unmeasured", language, count=unknown))
    return [
        join_sentences(sentences, language),
        *_claims(looked, language),
        *(_refused(looked.turns, language) if refused else []),
    ]


def why(looked: LoopRecord | None, language: Language) -> str:
    """Return why a loop ended without success, or an empty string if it succeeded or was interrupted."""
    if looked is None or looked.contradicted:
        return ""
    end = looked.end
    key = f"visual.end.{end.claim}" if end.why == "finished" else f"visual.end.{end.why}"
    return say(key, language, fault=end.fault) if can_say(key) else ""


def _claims(looked: LoopRecord, language: Language) -> list[str]:
    end, mind = looked.end, quote(looked.mind)
    joint = "、" if language == "zh" else ", "
    sentences = []
    if end.saw:
        sentences.append(
            say("visual.saw", language, mind=mind, saw=joint.join(quote(line.rstrip(" .。")) for line in end.saw))
        )
    if end.did:
        sentences.append(say("visual.did", language, mind=mind, did=quote(end.did.rstrip(" .。"))))
    if sentences and not looked.contradicted:
        sentences.append(say("visual.unchecked", language))
    if looked.contradicted:
        sentences.append(say("visual.denied", language, why=looked.contradicted))
    return [join_sentences(sentences, language)] if sentences else []


def _refused(turns: Sequence[LoopCall], language: Language) -> list[str]:
    problems = [turn for turn in turns if turn.tool and turn.problem]
    calls = [f"{quote(_call(turn))} ({quote(turn.problem)})" for turn in problems[:MOST_REFUSED]]
    if len(problems) > MOST_REFUSED:
        calls.append(f"+{len(problems) - MOST_REFUSED}")
    joint = "；" if language == "zh" else "; "
    return [say("visual.refused", language, calls=joint.join(calls))] if calls else []


def _call(turn: LoopCall) -> str:
    if list(turn.arguments) == ["raw"]:
        return f"{turn.tool} {turn.arguments['raw']}"
    return f"{turn.tool} {json.dumps(turn.arguments, ensure_ascii=False)}"
