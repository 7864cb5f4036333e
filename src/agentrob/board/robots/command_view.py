"""Build the view of a command page from the record that the robot's agent sent, tolerating malformed records."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any

from agentrob.board.db.reader import Reader
from agentrob.board.db.records import Image, StoredPost, from_text
from agentrob.board.robots.abilities import op_in_words
from agentrob.board.robots.commands import CommandRecord, record_pictures
from agentrob.language.messages.plan_text import step_label
from agentrob.model import BUILT_IN, AccountKind, Capabilities, CommandState, Primitive
from agentrob.model.plans import step_of

_UNITS = {
    "distance_m": "{:z.2f} m",
    "sideways_m": "{:z.2f} m sideways",
    "degrees": "{:z.1f}°",
    "heading_deg": "{:z.1f}° off",
    "drift_m": "{:z.2f} m drifted",
    "speed_mps": "{:z.2f} m/s",
    "seconds": "{:z.1f} s",
}
#: Hidden if they round to zero.
_ASIDE = frozenset({"sideways_m", "heading_deg", "drift_m"})
_MOMENTS = {"seen": "seen by the robot's agent", "first_motion": "first motion", "done": "at rest, all steps done"}
_PICTURES = {
    "step": "Photo of step",
    "path": "Path that was measured",
    "preview": "Paths of the preview",
    "recording": "Recording",
}
MOST = 60
#: A larger amount is shown as it is.
MOST_AMOUNT = 1e4


@dataclass(frozen=True, slots=True)
class StepView:
    """One step: what was asked beside what was measured, in words; `outcome` is a bare word, `why` a sentence."""

    asked: str
    measured: str
    outcome: str
    why: str
    seconds: str


@dataclass(frozen=True, slots=True)
class ModelView:
    """One model that was asked: who, how many tokens, how long, and what failed."""

    name: str
    tokens: str
    seconds: str
    failed: str


@dataclass(frozen=True, slots=True)
class CallView:
    """One call of a tool by a model, and what came of it; `step` is the robot's step that it was, if any."""

    tool: str
    arguments: str
    step: str
    outcome: str
    words: str
    seconds: str


@dataclass(frozen=True, slots=True)
class CommandView:
    """One robot's side of a command. `verdict` is (decision, rule, reason); `timeline` (what, when, how much later than
    the first moment).

    `facts` are (name, value): who read the words, who else looked at them, who stopped it. `steps` are those that were
    tried or, when there were none (`planned`), those that were asked for. `links` are pictures kept elsewhere:
    (what, address, until when it is good).
    """

    robot: str
    reply: StoredPost | None
    status: str
    message: str
    trace_id: str
    verdict: tuple[str, str, str]
    timeline: tuple[tuple[str, datetime, str], ...]
    steps: tuple[StepView, ...]
    planned: bool
    facts: tuple[tuple[str, str], ...]
    models: tuple[ModelView, ...]
    calls: tuple[CallView, ...]
    pictures: tuple[tuple[str, Image, str], ...]
    links: tuple[tuple[str, str, datetime | None], ...]


def command_view(post: StoredPost, kept: CommandRecord, can: Capabilities | None = None) -> CommandView:
    """The view of one record; fields of the wrong type are left out. `can`: what the robot can do today, for the words
    of the operations that it declares."""
    record = kept.record
    verdict = _map(record.get("verdict"))
    looked, run = _map(record.get("looked")), _map(record.get("run"))
    summary = _map(record.get("summary"))
    usage = (*_list(record.get("models")), *_list(looked.get("usage")), *_list(summary.get("models")))
    done, planned = _list(record.get("steps")), _list(record.get("plan"))
    return CommandView(
        robot=kept.robot,
        reply=kept.reply,
        status=_text(record.get("status"), 24),
        message=_message(record),
        trace_id=_text(record.get("trace_id"), 64),
        verdict=(_text(verdict.get("decision"), 24), _text(verdict.get("rule"), 80), _text(verdict.get("reason"), 600)),
        timeline=_timeline(
            _first(post, run),
            kept.reply,
            _map(record.get("timings_ms")),
            _map(record.get("approval")),
        ),
        steps=tuple(_step(_map(step), can) for step in done) or tuple(_asked(_map(step), can) for step in planned),
        planned=not done,
        facts=tuple(_facts(record, looked, summary)),
        models=tuple(_model(_map(model)) for model in usage),
        calls=tuple(_call(_map(turn)) for turn in _list(looked.get("turns"))),
        pictures=_pictures(kept.reply, _list(record.get("pictures"))),
        links=tuple(filter(None, map(_link, _list(record.get("links"))))),
    )


def _message(record: Mapping[str, Any]) -> str:
    """The robot's message, without Markdown; empty for a stopped command, whose facts say who stopped it."""
    return "" if record.get("status") == CommandState.STOPPED else _text(record.get("message"), 600).replace("**", "")


def _first(post: StoredPost, run: Mapping[str, Any]) -> tuple[str, datetime]:
    """The moment from which times are counted: that of the post, or when a run of a schedule was due."""
    due = from_text(run.get("at"))
    if due is None or abs(post.created_at - due) > timedelta(days=1):
        return "posted", post.created_at
    return "due", due


def _timeline(
    first: tuple[str, datetime], reply: StoredPost | None, timings: Mapping[str, Any], approval: Mapping[str, Any]
) -> tuple[tuple[str, datetime, str], ...]:
    ms = {name: number for name, value in timings.items() if (number := _number(value)) is not None}
    moments = [(ms[name], words) for name, words in _MOMENTS.items() if name in ms]
    if reply is not None:
        reported_at = reply.edited_at or reply.created_at
        moments.append(((reported_at - first[1]).total_seconds() * 1000, "reported in the thread"))
    if (decided_at := from_text(approval.get("at"))) is not None:
        decision = "approved" if approval.get("approved") is True else "denied"
        moments.append(((decided_at - first[1]).total_seconds() * 1000, decision))
    moments.sort(key=lambda moment: moment[0])
    entries = tuple(
        (words, first[1] + timedelta(milliseconds=max(-1e9, min(at, 1e9))), f"+{at / 1000:.2f}\u00a0s")
        for at, words in moments
    )
    return ((*first, ""), *entries)


def _step(step: Mapping[str, Any], can: Capabilities | None) -> StepView:
    seconds = _number(step.get("duration_s"))
    why = _text(step.get("message"), 300) or _text(step.get("reason"), 60)
    return StepView(
        asked=_action(step, _map(step.get("asked")), can),
        measured=_amounts(_map(step.get("measured"))) or _unmeasured(_text(step.get("unmeasured"), 40)),
        outcome=_text(step.get("outcome"), 24),
        why=why,
        seconds="" if seconds is None else f"{seconds:.1f} s",
    )


def _unmeasured(why: str) -> str:
    """Shown instead of an amount; `why` is a stable word (`odometry_lost`), empty if nothing is measured."""
    return f"unknown: {why.replace('_', ' ')}" if why else "–"


def _asked(step: Mapping[str, Any], can: Capabilities | None) -> StepView:
    """A step of a plan that was not carried out."""
    return StepView(_action(step, {k: v for k, v in step.items() if k != "op"}, can), "–", "not started", "", "")


def _action(step: Mapping[str, Any], amounts: Mapping[str, Any], can: Capabilities | None) -> str:
    """A step as reports and replays show it; a step that this version does not know, by its operation and amounts."""
    try:
        read = step_of({"op": step.get("op"), **amounts})
    except (ValueError, TypeError):
        read = None
    read = can.bound(read) if read is not None and can is not None else read
    if read is None or not _plain(read):
        return f"{op_in_words(_text(step.get('op'), 40), can)} {_amounts(amounts)}".strip()
    return step_label(read, "en")


def _plain(step: Primitive) -> bool:
    """Whether a step has a direction where it needs one, and amounts of a usual size."""
    amounts = [a for a in (step.distance_m, step.degrees, step.speed_mps) if a is not None]
    known = step.op in BUILT_IN or step.declared is not None
    directed = step.direction is not None or not step.walks
    return known and directed and all(0 < amount < MOST_AMOUNT for amount in amounts)


def _amounts(amounts: Mapping[str, Any]) -> str:
    texts = []
    for name, value in list(amounts.items())[:8]:
        number = _number(value)
        if number is not None and name in _UNITS:
            words = _UNITS[name].format(number)
            if name not in _ASIDE or any(digit in words for digit in "123456789"):
                texts.append(words)
        elif number is not None:
            texts.append(f"{name.replace('_', ' ')[:40]} {number:g}")
        else:
            texts.append(_text(value, 60))
    return ", ".join(filter(None, texts))


def _facts(record: Mapping[str, Any], looked: Mapping[str, Any], summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    screened, stop, end = _map(record.get("screened")), _map(record.get("stop")), _map(looked.get("end"))
    refusal = _map(screened.get("refusal"))
    latency = _number(stop.get("latency_ms"))
    approval = _map(record.get("approval"))
    approver = _text(approval.get("by"), 80)
    facts = [
        ("Run", _run(_map(record.get("run")))),
        ("Read by", _text(record.get("mind"), 80)),
        ("Because", _text(record.get("fallback"), 300)),
        ("Also reviewed by", _text(screened.get("mind"), 80)),
        ("It objected", _text(refusal.get("reason"), 300) or _text(screened.get("why"), 300)),
        ("It failed", _text(screened.get("failed"), 200)),
        ("Looked for", _text(looked.get("goal"), 300)),
        ("The loop ended", _text(end.get("why"), 40).replace("_", " ")),
        ("The model claims", _text(end.get("claim"), 40).replace("_", " ")),
        ("It says it saw", ", ".join(_text(saw, 100) for saw in _list(end.get("saw"))[:8])),
        ("It says it did", _text(end.get("did"), 300)),
        ("The model failed", _text(end.get("fault"), 200)),
        ("Summed up by", _text(summary.get("mind"), 80)),
        ("Its words were left out", _text(summary.get("failed"), 200) or _text(summary.get("problem"), 200)),
        ("Contradicted by measurement", _text(looked.get("contradicted"), 300)),
        ("Approved by" if approval.get("approved") is True else "Denied by", approver),
        ("Stopped by", _text(record.get("stopped_by"), 80)),
        ("Stop took", "" if latency is None else f"{latency:.0f} ms"),
        ("Stop confirmed", "" if not stop else "yes" if stop.get("confirmed") is True else "no"),
        ("Notes", " ".join(_text(note, 200) for note in _list(record.get("notes"))[:8]).replace("`", '"')),
        ("Shortened", "the record was too long to be sent whole" if record.get("shortened") is True else ""),
    ]
    return [(name, value) for name, value in facts if value]


def _run(run: Mapping[str, Any]) -> str:
    """Which run of its schedule it was."""
    number, of = _number(run.get("number")), _number(run.get("of"))
    if not number or not of:
        return ""
    return f"{number:.0f} of {'at most ' if run.get('limited') is True else ''}{of:.0f}"


def _model(usage: Mapping[str, Any]) -> ModelView:
    tokens = [_number(usage.get(key)) for key in ("input_tokens", "output_tokens")]
    latency, cost = _number(usage.get("latency_ms")), _number(usage.get("cost"))
    counts = " + ".join("?" if n is None else f"{n:.0f}" for n in tokens) + " tokens"
    money = "" if cost is None else f", {cost:.4f} {_text(usage.get('currency'), 8)}"
    name = f"{_text(usage.get('mind'), 60)} ({_text(usage.get('model'), 80)})"
    return ModelView(
        name, counts + money, "" if latency is None else f"{latency / 1000:.2f} s", _text(usage.get("failed"), 200)
    )


def _call(turn: Mapping[str, Any]) -> CallView:
    arguments = ", ".join(f"{_text(k, 40)}={_text(v, 80)}" for k, v in list(_map(turn.get("arguments")).items())[:8])
    outcome = _text(turn.get("outcome"), 60) or _text(turn.get("problem"), 300)
    step, latency = _number(turn.get("step")), _number(turn.get("latency_ms"))
    return CallView(
        tool=_text(turn.get("tool"), 60),
        arguments=arguments,
        step=f"step {step:.0f}" if step else "",
        outcome=outcome.replace("_", " "),
        words=_text(turn.get("words"), 300),
        seconds=f"{latency / 1000:.2f} s" if latency else "",
    )


def _pictures(reply: StoredPost | None, kinds: Sequence[Any]) -> tuple[tuple[str, Image, str], ...]:
    """The reply's pictures with captions and kinds; generic ones if the record lists another number of pictures."""
    if reply is None:
        return ()
    named = len(kinds) == len(reply.images)
    shown = []
    for n, image in enumerate(reply.images):
        kind = _map(kinds[n]) if named else {}
        words = _picture(kind, "Recording" if image.moving else "Picture")
        shown.append((words, image, _text(kind.get("kind"), 20)))
    return tuple(shown)


def captions(reader: Reader, posts: Iterable[StoredPost]) -> dict[str, tuple[tuple[str, str], ...]]:
    """(words, kind) of each picture of robots' replies, by post, as far as records name all of them.

    A command that waits for an approval has no record yet; its pictures are those of its preview.
    """
    shown = {p.id: p for p in posts if p.images and p.author.kind is AccountKind.ROBOT_AGENT}
    preview = (_PICTURES["preview"], "preview")
    waiting = {key: post for key, post in shown.items() if _map(post.card).get("state") == CommandState.WAITING}
    found = {key: (preview,) * len(post.images) for key, post in waiting.items()}
    for post_id, entries in record_pictures(reader, [int(post_id) for post_id in shown]).items():
        kinds = [_map(kind) for kind in _list(entries)]
        if len(kinds) == len(shown[post_id].images):
            found[post_id] = tuple((_picture(kind, "Picture"), _text(kind.get("kind"), 20)) for kind in kinds)
    return found


def _picture(kind: Mapping[str, Any], otherwise: str) -> str:
    words, step = _PICTURES.get(_text(kind.get("kind"), 20), otherwise), _number(kind.get("step"))
    return f"{words} {step:.0f}" if step else words


def _link(kept: object) -> tuple[str, str, datetime | None] | None:
    """A picture that is stored elsewhere; None if its address is not a web URL."""
    link = _map(kept)
    address = link.get("url")
    if not isinstance(address, str) or not re.fullmatch(r"https?://[^\s<>\"']{1,2000}", address):
        return None
    return _picture(link, "Data of the recording"), address, from_text(link.get("until"))


def _map(value: object) -> Mapping[str, Any]:
    return value if isinstance(value, Mapping) else {}


def _list(value: object) -> Sequence[Any]:
    return value[:MOST] if isinstance(value, (list, tuple)) else ()


def _number(value: object) -> float | None:
    try:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            return None
    except OverflowError:
        return None
    return float(value)


def _text(value: object, most: int) -> str:
    if value is None or isinstance(value, (Mapping, list, tuple)):
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return text if len(text) <= most else text[: most - 1] + "…"
