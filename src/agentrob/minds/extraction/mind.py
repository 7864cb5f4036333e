"""The mind that asks a model, and trusts only what the post itself says.

    post ── rules ──► stop, help, status, "never mind": answered without a model
         ── model ──► closed schema ── grounding ──► the post's own numbers ── cross-check with the rules ──► plan
                                          └─► asks back                             └─► asks back

The model sees the part of the post that is for this robot, as data; it has no tools. It can make the robot do only what
the post says, and never what the rules read differently. If no model answers, the rules do.
"""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import replace

from agentrob.language.addressing import part_for
from agentrob.language.messages.catalog import say
from agentrob.language.messages.plan_text import sentence
from agentrob.language.parser.grammar import MAX_CHARS
from agentrob.language.parser.robot_order import ordering_words
from agentrob.language.visible_text import OMITTED
from agentrob.minds.extraction.declared import wants_of
from agentrob.minds.extraction.grounding import Grounded, Ungrounded, claimed, ground
from agentrob.minds.extraction.schema import Wants
from agentrob.minds.extraction.units import same
from agentrob.minds.llm.chat import ChatModel
from agentrob.minds.llm.errors import ModelError
from agentrob.minds.llm.prompt import clean, prompts, shared_prompt, user_message
from agentrob.minds.protocol import Addressee, Reading
from agentrob.minds.rules import RulesMind
from agentrob.minds.usage import Usage
from agentrob.model import Capabilities, Intent, Language, Plan, Primitive, Understanding

#: Intents that the rules answer alone, at once and without cost.
_SETTLED = (Intent.STOP, Intent.HALT, Intent.HELP, Intent.STATUS, Intent.CANCEL)


class ModelMind:
    """Understand free text through a model (or several with fallback), checked against the text itself.

    With `rules_first` the model reads only posts about which the rules ask back. `limit_s` limits a reading by all
    models together; after it the rules answer.
    """

    def __init__(self, model: ChatModel, limit_s: float | None = None, rules_first: bool = False) -> None:
        self.name = model.name
        self.limit_s = model.limit_s if limit_s is None else limit_s
        self._rules_first = rules_first
        self.model = model
        self._rules = RulesMind()

    async def understand(self, text: str, addressee: Addressee, history: Sequence[Plan] = ()) -> Understanding:
        return (await self.read(text, addressee, history)).understanding

    async def read(
        self, text: str, addressee: Addressee, history: Sequence[Plan] = (), spent: Sequence[Usage] = ()
    ) -> Reading:
        """Read a post and report who read it at what cost. Never raises if a model fails: the rules answer."""
        by_rules = await self._rules.understand(text, addressee, history)
        part = clean(part_for(text, addressee.names, addressee.others))
        # A model would read over words that are hidden within a line, and might take a book for a command.
        ordered = ordering_words(
            text, addressee.names, addressee.others
        )  # another robot's end, which nobody here knows
        clear = self._rules_first and by_rules.intent is not Intent.ASK_BACK
        if (
            clear
            or by_rules.intent in _SETTLED
            or ordered
            or OMITTED in part
            or len(part) > MAX_CHARS
            or not part.strip()
        ):
            return Reading(by_rules, self._rules.name)
        try:
            async with asyncio.timeout(self.limit_s):
                system_prompt, begins = prompts(addressee.capabilities, "read", self.model.shares_prompt)
                message = begins + user_message(part, history)
                answer = await self.model.answer(system_prompt, message, wants_of(addressee.capabilities), spent=spent)
        except ModelError as e:
            return Reading(by_rules, self._rules.name, e.usage, fallback=f"{e.kind}")
        except TimeoutError:
            lost = Usage(self.name, "", latency_ms=self.limit_s * 1e3, failed="timeout")
            return Reading(by_rules, self._rules.name, (lost,), fallback="timeout")
        understood = weigh(answer.value, by_rules, part, history, addressee.capabilities)
        failed = [u.failed for u in answer.usage if u.mind == self.name and u.failed]
        return Reading(understood, answer.mind, answer.usage, fallback=failed[-1] if failed else "")

    async def prepare(self) -> None:
        """Load the model's library before the first post, ideally when an agent starts. Never raises."""
        await self.model.prepare()

    async def warm(self, capabilities: Capabilities) -> None:
        """Let a local server process this robot's prompt before the first post. Never raises."""
        if self.model.shares_prompt:
            await self.model.warm(shared_prompt(capabilities))

    async def close(self) -> None:
        await self.model.close()


def weigh(
    wants: Wants,
    by_rules: Understanding,
    part: str,
    history: Sequence[Plan] = (),
    can: Capabilities | None = None,
) -> Understanding:
    """Compare a model's reading with the post itself and with the rules. Pure.

    A cancellation that the rules find ("never mind, …") always holds.
    """
    return replace(_weighed(wants, by_rules, part, history, can), cancels=by_rules.cancels)


def _weighed(
    wants: Wants, by_rules: Understanding, part: str, history: Sequence[Plan], can: Capabilities | None
) -> Understanding:
    language = by_rules.language
    parsed = by_rules.plan.steps if by_rules.intent is Intent.COMMAND else ()
    if wants.intent != "command" or not wants.steps:
        if parsed:  # the rules read a command where the model reads none
            steps = sentence(parsed, language)
            return _ask(language, say("minds.not_a_command", language, steps=steps))
        if wants.intent == "unclear" and by_rules.intent is not Intent.ASK_BACK:
            return _ask(language, say(f"minds.doubt.{wants.doubt}", language))
        return by_rules
    found = ground(wants.steps, part, history, can)
    if parsed:
        return _compare(found, wants, by_rules)
    if isinstance(found, Ungrounded):
        return _ask(language, say(f"minds.{found.lack}", language), _shown(wants, language))
    if by_rules.intent is not Intent.ASK_BACK:  # the rules know every word of it, and none is a wish
        return _ask(language, say("minds.not_a_command", language, steps=sentence(found.plan, language)))
    return Understanding(Intent.COMMAND, language, _noted(found, language))


def _compare(found: Grounded | Ungrounded, wants: Wants, by_rules: Understanding) -> Understanding:
    """Handle two readings as a command: execute if they agree, otherwise ask which is meant."""
    language = by_rules.language
    theirs = Plan(tuple(_claims(wants))) if isinstance(found, Ungrounded) else found.plan
    if agree(theirs, by_rules.plan):
        return by_rules
    one, other = sentence(by_rules.plan, language), sentence(theirs, language)
    return _ask(language, say("minds.disagree", language, one=one, other=other))


def _claims(wants: Wants) -> list[Primitive]:
    return [claimed(step) for step in wants.steps for _ in range(step.times)]


def _shown(wants: Wants, language: Language) -> str:
    """Return the model's reading in our words."""
    return sentence(_claims(wants), language)


def _noted(found: Grounded, language: Language) -> Plan:
    return replace(found.plan, notes=(say("minds.assumed_turn", language),)) if found.assumed_turn else found.plan


def _ask(language: Language, problem: str, understood: str = "") -> Understanding:
    """Ask back: say what was understood, what is wrong with it, and that nothing moved."""
    begin = say("minds.understood", language, steps=understood) if understood else ""
    return Understanding(Intent.ASK_BACK, language, question=f"{begin}{problem}{say('minds.end', language)}")


# ---------------------------------------------------------------------- two readings of one post
def agree(one: Plan, other: Plan) -> bool:
    """Return whether two plans have the same steps in the same order, apart from rounding."""
    return len(one.steps) == len(other.steps) and all(map(_alike, one.steps, other.steps))


def _alike(one: Primitive, other: Primitive) -> bool:
    amounts: Sequence[tuple[float | None, float | None]] = (
        (one.distance_m, other.distance_m),
        (one.degrees, other.degrees),
        (one.speed_mps, other.speed_mps),
    )
    same_action = (one.op, one.direction, one.arguments) == (other.op, other.direction, other.arguments)
    return same_action and all(_equal(a, b) for a, b in amounts)


def _equal(one: float | None, other: float | None) -> bool:
    return one is other if one is None or other is None else same(one, other)
