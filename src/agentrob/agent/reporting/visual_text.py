"""What the thread is told of a loop (pure): what was measured, what the model claims, and why it ended.

The model's words come from what a camera read: they stand as escaped code of at most 100 characters each, as the
model's, beside what the robot measured, and never as what is so.
"""

from __future__ import annotations

import json
from collections.abc import Sequence

from agentrob.language import registry
from agentrob.language.messages.catalog import quote
from agentrob.minds.visual_loop.claims import turned_deg, walked_m
from agentrob.minds.visual_loop.loop import LoopCall, LoopRecord
from agentrob.model import ActionResult, Language, Op, Outcome

#: So many calls that were not done are told.
MOST_REFUSED = 3
_SENTENCES = {
    "measured": (
        "Measured in all: {metres:.2f} m walked, {degrees:.0f}° turned. Pictures: {pictures}. "
        "Calls by the model: {calls}.",
        "实测合计：行走 {metres:.2f} 米，转动 {degrees:.0f}°。图片 {pictures} 张，模型调用 {calls} 次。",
    ),
    "unmeasured": (
        "How far it went in {count} of its steps is unknown: its odometry was lost or jumped.",
        "其中 {count} 步的实际位移未知：里程计丢失或跳变。",
    ),
    "saw": ("The model {mind} says that it saw {saw}.", "模型 {mind} 说看到了 {saw}。"),
    "did": ("The model {mind} says of what it did: {did}.", "模型 {mind} 说它做了：{did}。"),
    "unchecked": ("Nobody has checked that.", "以上未经核实。"),
    "denied": ("**That is not so:** {why}.", "**与实测不符：** {why}。"),
    "refused": ("Asked for by the model and not done: {calls}.", "模型要求但没有执行：{calls}。"),
    "calls.asked": ("Called by the model", "模型的调用"),
    "calls.picture": ("picture {number}", "图片 {number}"),
    "calls.problem": ("not done: {problem}", "未执行：{problem}"),
    "calls.claims": ("it says {outcome}", "它说 {outcome}"),
    "calls.words": ("words, no call", "只有文字，没有调用"),
    "calls.more": ("Rows left out here: {count}.", "此处省略 {count} 行。"),
    "end.calls": ("The model used up its calls before it was there.", "模型在达成目标之前用完了调用次数。"),
    "end.time": ("The time for this command was up.", "这个命令的时间已用完。"),
    "end.no_progress": ("The model got nowhere several times in a row.", "模型连续几次没有进展。"),
    "end.tokens": ("The model's budget of tokens or money was used up.", "模型的令牌或费用额度已用完。"),
    "end.model": ("The model did not answer ({fault}).", "模型没有回答（{fault}）。"),
    "end.not_possible": ("The model says that it is not possible.", "模型说无法完成。"),
    "end.unsure": ("The model cannot tell whether it is done.", "模型不能确定是否完成。"),
    "running": ("Step {step}: {doing} … (goal: {goal})", "第 {step} 步：{doing}……（目标：{goal}）"),
    "ask": (
        "I can look for things through my camera, but not as this is said. I know plain wishes and a list of things, "
        "for example `walk to the red ball and tell me what is beside it`. I did not move.",
        "我可以通过摄像头找东西，但没有看懂这句话。我只认简单的说法和一些常见的东西，"
        "例如 `走到红色的球旁边，告诉我它旁边有什么`。我没有动。",
    ),
}  # fmt: skip


def say(key: str, language: Language, **values: object) -> str:
    """The sentence `key`; in a further language as its file says it under `agent.look.KEY`, else in English."""
    english, chinese = _SENTENCES[key]
    if language == "zh":
        return chinese.format(**values)
    further = registry.known().get(language)
    return (further.sentences.get(f"agent.look.{key}", english) if further else english).format(**values)


def paragraphs(
    looked: LoopRecord | None, results: Sequence[ActionResult], language: Language, *, refused: bool = True
) -> list[str]:
    """For a report: the measured sums, the model's claims as such, and, where no table has them, the calls that were
    not done."""
    if looked is None:
        return []
    done = [r for r in results if r.outcome not in (Outcome.SKIPPED, Outcome.REFUSED)]
    measured = say(
        "measured", language, metres=walked_m(done), degrees=turned_deg(done),
        pictures=sum(r.primitive.op is Op.GET_FRONT_IMAGE for r in done), calls=len(looked.turns),
    )  # fmt: skip
    if unknown := sum(bool(r.unmeasured) for r in done):
        measured += ("" if language == "zh" else " ") + say("unmeasured", language, count=unknown)
    return [measured, *_claims(looked, language), *(_refused(looked.turns, language) if refused else [])]


def why(looked: LoopRecord | None, language: Language) -> str:
    """Why a loop ended without success, in a sentence of ours; empty when it was cut off from outside, or succeeded."""
    if looked is None or looked.contradicted:
        return ""
    end = looked.end
    key = f"end.{end.claim}" if end.why == "finished" else f"end.{end.why}"
    return say(key, language, fault=end.fault) if key in _SENTENCES else ""


def _claims(looked: LoopRecord, language: Language) -> list[str]:
    end, mind = looked.end, quote(looked.mind)
    joint = "、" if language == "zh" else ", "
    said = []
    if end.saw:
        said.append(say("saw", language, mind=mind, saw=joint.join(quote(line.rstrip(" .。")) for line in end.saw)))
    if end.did:
        said.append(say("did", language, mind=mind, did=quote(end.did.rstrip(" .。"))))
    if said and not looked.contradicted:
        said.append(say("unchecked", language))
    if looked.contradicted:
        said.append(say("denied", language, why=looked.contradicted))
    return [("" if language == "zh" else " ").join(said)] if said else []


def _refused(turns: Sequence[LoopCall], language: Language) -> list[str]:
    problems = [turn for turn in turns if turn.tool and turn.problem]
    told = [f"{quote(_call(turn))} ({quote(turn.problem)})" for turn in problems[:MOST_REFUSED]]
    if len(problems) > MOST_REFUSED:
        told.append(f"+{len(problems) - MOST_REFUSED}")
    joint = "；" if language == "zh" else "; "
    return [say("refused", language, calls=joint.join(told))] if told else []


def _call(turn: LoopCall) -> str:
    if list(turn.arguments) == ["raw"]:
        return f"{turn.tool} {turn.arguments['raw']}"
    return f"{turn.tool} {json.dumps(turn.arguments, ensure_ascii=False)}"
