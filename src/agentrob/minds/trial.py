"""What a mind makes of one text, told in lines for people: for trying a model before trusting it. Nothing moves."""

from __future__ import annotations

from agentrob.judge.screen import screen
from agentrob.language.addressing import part_for
from agentrob.language.render import sentence
from agentrob.language.visible import mentions, visible_text
from agentrob.minds.mind import Listener, LivingMind, Mind, Reading, read
from agentrob.minds.model_mind import ModelMind
from agentrob.minds.screening import Screened, narrowed, screen_by_model
from agentrob.model import Account, Capabilities, Decision, Intent, Role

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


async def _judged(mind: Mind, reading: Reading, text: str, listener: Listener) -> tuple[list[str], Screened | None]:
    """What the screen says of a command, and what a model adds where the rules allow it."""
    found, can = reading.understanding, listener.capabilities
    if found.intent is not Intent.COMMAND:
        return [], None
    verdict = screen(found.plan, text=text, author=_AUTHOR, capabilities=can, language=found.language)
    screened = None
    if verdict.decision is Decision.ALLOW and isinstance(mind, ModelMind) and not reading.fallback:
        part = part_for(text, listener.names, listener.others)
        screened = await screen_by_model(mind.model, part, found.plan, can, found.language, spent=reading.usage)
        verdict = narrowed(verdict, screened, found.language)
    if verdict.decision is not Decision.ALLOW:
        return [f"  {verdict.decision}: {verdict.reason} ({verdict.rule})"], screened
    looked = ""
    if screened is not None:
        looked = (
            f"; {screened.mind} could not look: {screened.failed}" if screened.failed else f"; {screened.mind} neither"
        )
    return [f"  the rules have nothing against it{looked}"], screened
