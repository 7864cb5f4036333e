"""The text about parts of posts in replies (pure)."""

from __future__ import annotations

from collections.abc import Sequence

from agentrob.agent.joint.evidence import PartStatus, measurable
from agentrob.language.joint.parts import Choice, JointCommand, JointPart
from agentrob.language.messages.catalog import can_say, join_sentences, quote, say
from agentrob.language.messages.durations import duration
from agentrob.model import CommandState, Language, StatusCard


def named(part: JointPart, language: Language, robot: str = "") -> str:
    """Return who does a part and its number: "`quadruped` (part 1)"."""
    robots = (robot,) if robot else part.robots
    who = say("joint.or", language).join(quote(name) for name in robots)
    return say("joint.named", language, who=who, part=part.number)


def waits_text(parts: Sequence[JointPart], seconds: float, language: Language) -> str:
    """Say for whom a part waits, and how long at most."""
    who = say("agent.list.joint", language).join(named(part, language) for part in parts)
    return say("joint.waits", language, who=who, wait=duration(max(1.0, seconds), language))


def bid_text(part: JointPart, bid: StatusCard, language: Language) -> str:
    """Return what a robot bids: how far it is, if that was asked and it knows, and how soon it could be done."""
    key = "joint.bids.near" if bid.near_cm else "joint.bids"
    return say(key, language, seconds=bid.bid_s, metres=bid.near_cm / 100, thing=quote(part.near))


def takes_text(part: JointPart, bid: StatusCard, bids: Sequence[StatusCard], language: Language) -> str:
    """Say that a robot does a part, and why: its own `bid` among all that are known."""
    takes = say("joint.takes", language, part=part.number, seconds=bid.bid_s)
    if part.choice is not Choice.NEAREST:
        return takes
    if not part.near:
        return join_sentences([takes, say("joint.takes.nowhere", language)], language)
    key = "joint.takes.unmeasured"
    if measurable(part, bids):
        nearest = all(bid.near_cm <= other.near_cm for other in bids)
        key = "joint.takes.nearest" if nearest else "joint.takes.second"
    why = say(key, language, metres=bid.near_cm / 100, thing=quote(part.near))
    return join_sentences([takes, why], language)


def ended_because(part: JointPart, state: str, language: Language) -> str:
    """Say why a part is cancelled: how the part before it ended, or that it did not end in time."""
    return say("joint.because", language, who=named(part, language), how=how(state, language))


def left_because(
    part: JointPart, robot: str, theirs: StatusCard | None, own: StatusCard | None, language: Language
) -> str:
    """Say which robot does a part instead, and why: by distance where both say it, else by time."""
    who = quote(robot)
    if theirs is None or own is None:
        return say("joint.left", language, who=who)
    if measurable(part, (theirs, own)) and theirs.near_cm <= own.near_cm:
        metres, own_m = theirs.near_cm / 100, own.near_cm / 100
        return say("joint.left.near", language, who=who, metres=metres, own_m=own_m, thing=quote(part.near))
    return say("joint.left.why", language, who=who, seconds=theirs.bid_s, own_s=own.bid_s)


def how(state: str, language: Language) -> str:
    """Return how far a part came, in words."""
    key = f"joint.state.{state or 'silent'}"
    return say(key if can_say(key) else "joint.state.open", language)


def summary(joint: JointCommand, statuses: Sequence[PartStatus], language: Language) -> str:
    """Return how all parts ended, with the count of those that are done."""
    done = sum(status.state == CommandState.DONE for status in statuses)
    lines = []
    for part, status in zip(joint.parts, statuses, strict=True):
        robots = (status.robot,) if status.robot else part.robots
        who = say("joint.or", language).join(quote(name) for name in robots)
        said = how(status.state, language)
        lines.append(say("joint.summary.part", language, part=part.number, who=who, how=said, words=quote(part.text)))
    return "\n".join([say("joint.summary", language, done=done, count=len(joint.parts)), "", *lines])
