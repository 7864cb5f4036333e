"""The mind without a model: the grammar as a `Mind`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from agentrob.language.addressing import part_for
from agentrob.language.messages.catalog import say
from agentrob.language.parser.grammar import parse, small_talk_of, talk_topic_of
from agentrob.language.parser.repetition import ParseContext
from agentrob.language.parser.small_talk import SmallTalk
from agentrob.language.previews.reading import speaks_of_preview
from agentrob.minds.protocol import Addressee
from agentrob.model import Intent, Language, Plan, Understanding

#: Speed of "walk for two seconds" without a speed, within the robot's limits.
PACE_MPS = 0.3
#: Questions, greetings and thanks are answered with one line.
_TALK: dict[SmallTalk | None, Intent] = {
    SmallTalk.CANCEL: Intent.CANCEL,
    SmallTalk.QUESTION: Intent.QUESTION,
    SmallTalk.GREETING: Intent.QUESTION,
    SmallTalk.ASSENT: Intent.ASK_BACK,
    SmallTalk.THANKS: Intent.QUESTION,
}
_ANSWERED = (SmallTalk.GREETING, SmallTalk.ASSENT, SmallTalk.THANKS)
#: What is answered even where the grammar finds an ability that robots lack: nobody expects an actor.
_IN_WORDS = ("joke", "who")


class RulesMind:
    """Understand by rules alone: the same post always has the same meaning, within milliseconds.

    Who can preview a command splits off the words that ask for that; where they are left, nothing is to move.
    """

    name = "rules"

    async def understand(self, text: str, addressee: Addressee, history: Sequence[Plan] = ()) -> Understanding:
        can = addressee.capabilities
        pace_mps = min(PACE_MPS, can.limits.speed_mps)
        robots = addressee.names, addressee.others
        background = ParseContext(tuple(history), pace_mps, addressee.step_m, can)
        understood = parse(text, addressee.names, addressee.others, can.ops, background)
        if understood.intent not in (Intent.NOTHING, Intent.COMMAND, Intent.ASK_BACK):
            return understood
        if understood.intent is Intent.COMMAND and speaks_of_preview(part_for(text, *robots), text):
            unclear = say("preview.unclear", understood.language)
            return Understanding(Intent.ASK_BACK, understood.language, question=unclear)
        if understood.intent is Intent.COMMAND:
            talk = small_talk_of(text, addressee.names, addressee.others)
            return _with_cancelled(understood) if talk is SmallTalk.CANCEL else understood
        topic = talk_topic_of(text, addressee.names, addressee.others)
        if understood.intent is Intent.ASK_BACK and topic not in _IN_WORDS:
            return understood
        talk = small_talk_of(text, addressee.names, addressee.others)
        if topic and talk not in (SmallTalk.CANCEL, SmallTalk.PAST):
            return self._answer(topic, understood.language, addressee)
        answer = say(f"talk.{talk}", understood.language) if talk in _ANSWERED else ""
        intent = _TALK.get(talk, Intent.NOTHING)
        return replace(understood, intent=intent, question=answer, cancels=talk is SmallTalk.CANCEL)

    @staticmethod
    def _answer(topic: str, language: Language, addressee: Addressee) -> Understanding:
        """Answer a line of talk with one line from the catalogue."""
        can = addressee.capabilities
        name = min(addressee.names, key=len, default=can.model)
        line = say(f"talk.{topic}", language, name=name, model=can.model)
        sees = any(operation.picture for operation in can.operations)
        return Understanding(Intent.QUESTION, language, question=line, looks=topic == "see" and sees)


def _with_cancelled(understood: Understanding) -> Understanding:
    """Return a command beside a "never mind", which cancels what its author posted before; a note says so."""
    plan = understood.plan
    note = say("note.cancels", understood.language)
    return replace(understood, cancels=True, plan=replace(plan, notes=(*plan.notes, note)))
