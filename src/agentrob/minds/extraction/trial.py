"""What a mind makes of one text, told in lines for people: for trying a model before trusting it. Nothing moves."""

from __future__ import annotations

from agentrob.language.addressing import part_for
from agentrob.language.messages.plan_text import sentence
from agentrob.language.visible_text import mentions, visible_text
from agentrob.minds.extraction.mind import ModelMind
from agentrob.minds.protocol import Listener, LivingMind, Mind, Reading, read
from agentrob.minds.rules import RulesMind
from agentrob.minds.safety_review import Screened, narrowed, screen_by_model
from agentrob.model import Account, Capabilities, Decision, Intent, Role, Verdict
from agentrob.screening.screen import screen

#: Whoever tries a mind may command.
_AUTHOR = Account(id="local", name="local", role=Role.OPERATOR)


async def trial(mind: Mind, name: str, text: str, robot: str, capabilities: Capabilities) -> list[str]:
    """Read a post body for `robot` (its handle, unless the text mentions one), judge it, and close the mind. `name` is
    what the mind is called in the configuration."""
    visible = visible_text(text)
    called = (*mentions(visible), robot)[0]
    if called not in mentions(visible):
        visible = f"@{called} {visible}"
    listener = Listener((called,), (), capabilities)
    if isinstance(mind, LivingMind):
        await mind.prepare()
    try:
        reading = await read(mind, visible, listener)
        judged, screened = await _judged(mind, reading, visible, listener)
    finally:
        if isinstance(mind, LivingMind):
            await mind.close()
    found, usage = reading.understanding, (*reading.usage, *(screened.usage if screened else ()))
    lines = [f"{found.intent}: {sentence(found.plan, found.language)}".rstrip(": ")]
    lines += [f"  note: {note}" for note in found.plan.notes]
    lines += [f"  it would answer: {found.question}"] if found.question else []
    lines += [f"  read by {reading.mind}" + (f" (instead of {name}: {reading.fallback})" if reading.fallback else "")]
    return [*lines, *judged, *(f"  {one.line()}" for one in usage)]


async def second_look(
    mind: Mind,
    reading: Reading,
    by_rules: Verdict,
    text: str,
    listener: Listener,
    scene: str = "",
    *,
    required: bool = False,
) -> tuple[Verdict, Screened | None]:
    """What counts of a command that was read and judged by rules, as for an agent with `screen = "model"`: where the
    rules allow it and the mind is a model, that looks at it once more, and can only refuse. `required`: with `screen =
    "required"`, so it is asked back where no model could look."""
    found = reading.understanding
    if by_rules.decision is not Decision.ALLOW or not isinstance(mind, ModelMind):
        return narrowed(by_rules, None, found.language, required), None
    if reading.mind == RulesMind.name and reading.fallback:  # nobody answered a moment ago
        screened = Screened(mind.name, failed=reading.fallback)
        return narrowed(by_rules, screened, found.language, required), screened
    part, can = part_for(text, listener.names, listener.others), listener.capabilities
    looking = screen_by_model(mind.model, part, found.plan, can, found.language, scene=scene, spent=reading.usage)
    screened = await looking
    return narrowed(by_rules, screened, found.language, required), screened


async def _judged(mind: Mind, reading: Reading, text: str, listener: Listener) -> tuple[list[str], Screened | None]:
    """What the screen says of a command, and what a model adds where the rules allow it."""
    found, can = reading.understanding, listener.capabilities
    if found.intent is not Intent.COMMAND:
        return [], None
    verdict = screen(found.plan, text=text, author=_AUTHOR, capabilities=can, language=found.language)
    verdict, screened = await second_look(mind, reading, verdict, text, listener)
    if verdict.decision is not Decision.ALLOW:
        return [f"  {verdict.decision}: {verdict.reason} ({verdict.rule})"], screened
    looked = ""
    if screened is not None:
        looked = (
            f"; {screened.mind} could not look: {screened.failed}" if screened.failed else f"; {screened.mind} neither"
        )
    return [f"  the rules have nothing against it{looked}"], screened
