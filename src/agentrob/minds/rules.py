"""The mind that needs no model: a thin face of the grammar."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from agentrob.language.messages.catalog import say
from agentrob.language.parser.grammar import parse, talk_of
from agentrob.language.parser.repetition import Background
from agentrob.language.parser.small_talk import Talk
from agentrob.minds.protocol import Listener
from agentrob.model import Intent, Plan, Understanding

#: How fast a robot walks "for two seconds" when no speed is said, if its limits allow.
PACE_MPS = 0.3
#: Who greets or thanks is answered as one who asks, with a greeting or a welcome.
_TALK: dict[Talk | None, Intent] = {
    Talk.CANCEL: Intent.CANCEL,
    Talk.QUESTION: Intent.QUESTION,
    Talk.GREETING: Intent.QUESTION,
    Talk.THANKS: Intent.QUESTION,
}


class RulesMind:
    """Understands by rules alone: the same post always means the same, within milliseconds."""

    name = "rules"

    async def understand(self, text: str, listener: Listener, history: Sequence[Plan] = ()) -> Understanding:
        can = listener.capabilities
        pace_mps = min(PACE_MPS, can.limits.speed_mps)
        background = Background(tuple(history), pace_mps, listener.step_m, can)
        understood = parse(text, listener.names, listener.others, can.ops, background)
        if understood.intent not in (Intent.NOTHING, Intent.COMMAND):
            return understood
        talk = talk_of(text, listener.names, listener.others)
        if understood.intent is Intent.COMMAND:
            return replace(understood, cancels=talk is Talk.CANCEL)
        answer = say(f"talk.{talk}", understood.language) if talk in (Talk.GREETING, Talk.THANKS) else ""
        intent = _TALK.get(talk, Intent.NOTHING)
        return replace(understood, intent=intent, question=answer, cancels=talk is Talk.CANCEL)
