"""Show how a mind reads one text, to try a model before using it. Nothing moves."""

from __future__ import annotations

from agentrob.language.addressing import part_for
from agentrob.language.messages.plan_text import sentence
from agentrob.language.visible_text import mentions, visible_text
from agentrob.minds.extraction.mind import ModelMind
from agentrob.minds.protocol import Addressee, ManagedMind, Mind, Reading, read
from agentrob.minds.rules import RulesMind
from agentrob.minds.safety_review import SafetyReview, apply_review, review_command
from agentrob.model import Account, Capabilities, Decision, Intent, Role, Verdict
from agentrob.screening.screen import screen

#: The author of a trial may command.
_AUTHOR = Account(id="local", name="local", role=Role.OPERATOR)


async def try_mind(mind: Mind, name: str, text: str, robot: str, capabilities: Capabilities) -> list[str]:
    """Read a post body for `robot` (its handle, unless the text mentions one), screen it, and close the mind.

    Returns lines for people. `name` is the mind's name in the configuration.
    """
    visible = visible_text(text)
    called = (*mentions(visible), robot)[0]
    if called not in mentions(visible):
        visible = f"@{called} {visible}"
    addressee = Addressee((called,), (), capabilities)
    if isinstance(mind, ManagedMind):
        await mind.prepare()
    try:
        reading = await read(mind, visible, addressee)
        judged, screened = await _judged(mind, reading, visible, addressee)
    finally:
        if isinstance(mind, ManagedMind):
            await mind.close()
    found, usage = reading.understanding, (*reading.usage, *(screened.usage if screened else ()))
    lines = [f"{found.intent}: {sentence(found.plan, found.language)}".rstrip(": ")]
    lines += [f"  note: {note}" for note in found.plan.notes]
    lines += [f"  it would answer: {found.question}"] if found.question else []
    lines += [f"  read by {reading.mind}" + (f" (instead of {name}: {reading.fallback})" if reading.fallback else "")]
    return [*lines, *judged, *(f"  {one.line()}" for one in usage)]


async def reviewed_verdict(
    mind: Mind,
    reading: Reading,
    by_rules: Verdict,
    text: str,
    addressee: Addressee,
    scene: str = "",
    *,
    required: bool = False,
) -> tuple[Verdict, SafetyReview | None]:
    """Return the verdict on a command after a model's review, like an agent with `screen = "model"`.

    If the rules allow the command and the mind is a model, the model reviews it, and can only refuse. `required` is
    like `screen = "required"`: without a review, ask back.
    """
    found = reading.understanding
    if by_rules.decision is not Decision.ALLOW or not isinstance(mind, ModelMind):
        return apply_review(by_rules, None, found.language, required), None
    if reading.mind == RulesMind.name and reading.fallback:  # nobody answered a moment ago
        screened = SafetyReview(mind.name, failed=reading.fallback)
        return apply_review(by_rules, screened, found.language, required), screened
    part, can = part_for(text, addressee.names, addressee.others), addressee.capabilities
    looking = review_command(mind.model, part, found.plan, can, found.language, scene=scene, spent=reading.usage)
    screened = await looking
    return apply_review(by_rules, screened, found.language, required), screened


async def _judged(
    mind: Mind, reading: Reading, text: str, addressee: Addressee
) -> tuple[list[str], SafetyReview | None]:
    """Return lines about the screen's verdict on a command and the model's review."""
    found, can = reading.understanding, addressee.capabilities
    if found.intent is not Intent.COMMAND:
        return [], None
    verdict = screen(found.plan, text=text, author=_AUTHOR, capabilities=can, language=found.language)
    verdict, screened = await reviewed_verdict(mind, reading, verdict, text, addressee)
    if verdict.decision is not Decision.ALLOW:
        return [f"  {verdict.decision}: {verdict.reason} ({verdict.rule})"], screened
    review = ""
    if screened is not None:
        result = f"could not review it: {screened.failed}" if screened.failed else "does not object"
        review = f"; {screened.mind} {result}"
    return [f"  the rules allow it{review}"], screened
