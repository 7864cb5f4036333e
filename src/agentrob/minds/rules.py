"""The mind without a model: the grammar as a `Mind`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from agentrob.language.messages.catalog import say
from agentrob.language.parser.grammar import parse, small_talk_of
from agentrob.language.parser.repetition import ParseContext
from agentrob.language.parser.small_talk import SmallTalk
from agentrob.minds.protocol import Addressee
from agentrob.model import Intent, Plan, Understanding

#: Speed of "walk for two seconds" without a speed, within the robot's limits.
PACE_MPS = 0.3
#: Greetings and thanks are answered like questions.
_TALK: dict[SmallTalk | None, Intent] = {
    SmallTalk.CANCEL: Intent.CANCEL,
    SmallTalk.QUESTION: Intent.QUESTION,
    SmallTalk.GREETING: Intent.QUESTION,
    SmallTalk.THANKS: Intent.QUESTION,
}


class RulesMind:
    """Understand by rules alone: the same post always has the same meaning, within milliseconds."""

    name = "rules"

    async def understand(self, text: str, addressee: Addressee, history: Sequence[Plan] = ()) -> Understanding:
        can = addressee.capabilities
        pace_mps = min(PACE_MPS, can.limits.speed_mps)
        background = ParseContext(tuple(history), pace_mps, addressee.step_m, can)
        understood = parse(text, addressee.names, addressee.others, can.ops, background)
        if understood.intent not in (Intent.NOTHING, Intent.COMMAND):
            return understood
        talk = small_talk_of(text, addressee.names, addressee.others)
        if understood.intent is Intent.COMMAND:
            return replace(understood, cancels=talk is SmallTalk.CANCEL)
        answer = say(f"talk.{talk}", understood.language) if talk in (SmallTalk.GREETING, SmallTalk.THANKS) else ""
        intent = _TALK.get(talk, Intent.NOTHING)
        return replace(understood, intent=intent, question=answer, cancels=talk is SmallTalk.CANCEL)
