"""Decide whether a whole command is allowed, possible and within limits, and why not (laws 2, 7 and 10).

Pure rules, checked before queueing and again immediately before motion. The first rule that objects decides. Its name
(`limit.command_distance`, `harm.collide`, `rights.operator`, …) is stable, because reports and records contain it.

Not covered here:
- where the robot is and what obstructs it (the guard checks every step, in the driver's process);
- what is harmful only in this place, unless the post or a description of the scene says so;
- harm in words that no rule knows, in another language, or spread over several posts;
- whether a requested distance is the one that was meant, and whether an authorised account is in the right hands;
- rate limits, freshness and repetition (the agent), the robot's battery and health (the guard).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator

from agentrob.language.messages.catalog import can_say, say
from agentrob.language.messages.plan_text import (
    amount_of,
    operation_name,
    operation_names,
    range_of,
    sentence,
    step_sentence,
)
from agentrob.model import (
    Account,
    Capabilities,
    Decision,
    Language,
    Number,
    Operation,
    Plan,
    Primitive,
    RobotRights,
    Verdict,
)
from agentrob.model.estimate import seconds_of, step_seconds
from agentrob.screening.rights import classes_of, may
from agentrob.screening.text import described_hazards, elsewhere, harm, side_remarks
from agentrob.screening.text import scene as places
from agentrob.screening.text.described_hazards import hazard_in_path
from agentrob.screening.text.harm import clear_harm_of, doubt_of, harm_of
from agentrob.screening.text.scene import harm_in_scene
from agentrob.screening.text.side_remarks import doubtful_remark


def prepare() -> None:
    """Compile all patterns (about half a second) before a process begins to serve.

    Without it the screen gives the same results, but compiles patterns for each text as needed.
    """
    for room in (harm, described_hazards, side_remarks, elsewhere, places):
        room.prepare()


def screen(
    plan: Plan,
    *,
    text: str,
    author: Account,
    capabilities: Capabilities,
    language: Language,
    consents: Collection[str] = (),
    step_s: float = math.inf,
    scene: str = "",
    part: str | None = None,
    rights: RobotRights | None = None,
) -> Verdict:
    """Check the whole command against today's state.

    `text` is the visible text it was parsed from and `author` the account as it is now. `consents` is what the owner
    consents to (`Operation.needed_consent`), which simulated robots do not need. `step_s` is the longest step in
    seconds on forums that cannot be polled often (law 16). `scene` describes the place in English, if known. `part` is
    the part of a text to several robots that concerns this one's place (`agentrob.screening.audience`); by default the
    whole text. `rights` is what the forum stores about who may command this robot; a required approval is the last
    thing to be reported. The reason is a sentence in `language`.
    """
    simulated = capabilities.simulated
    granted = may(
        author, "command", language, rights=rights, classes=classes_of(plan, capabilities), simulated=simulated
    )
    if granted.decision not in (Decision.ALLOW, Decision.NEEDS_APPROVAL):
        return granted
    for rule, reason in _objections(plan, capabilities, consents, language):
        return Verdict(Decision.REFUSE, rule, reason)
    if (longest_s := max(step_seconds(step, capabilities) for step in plan.steps)) > step_s:
        rule, reason = _over("step_time", longest_s, step_s, language)
        return Verdict(Decision.REFUSE, rule, reason)
    heard = text if part is None else part
    return (
        harm_of(text, language)
        or hazard_in_path(heard, plan, language)
        or harm_in_scene(text, scene, plan, language)
        or doubt_of(text, language)
        or doubtful_remark(heard, plan, language)
        or (granted if granted.decision is Decision.NEEDS_APPROVAL else Verdict(Decision.ALLOW, "screen.passed"))
    )


def harm_in_words(text: str, scene: str, language: Language) -> Verdict | None:
    """Refuse a post without a plan if its words name a harmful action, or one that is harmful in this place."""
    return clear_harm_of(text, language) or harm_in_scene(text, scene, None, language)


def _objections(
    plan: Plan, capabilities: Capabilities, consents: Collection[str], language: Language
) -> Iterator[tuple[str, str]]:
    """Yield (rule, reason) for everything that speaks against the plan, the plainest first."""
    if not plan.steps:
        yield "plan.empty", say("refuse.empty", language)
    yield from _impossible(plan, capabilities, language)
    for step in plan.steps:
        if not _well_formed(step, capabilities):
            yield "plan.malformed", say("refuse.malformed", language, steps=step_sentence(step, language))
    yield from _without_consent(plan, capabilities, consents, language)
    yield from _beyond_arguments(plan, capabilities, language)
    yield from _beyond_a_step(plan, capabilities, language)
    yield from _beyond_a_command(plan, capabilities, language)


def _impossible(plan: Plan, capabilities: Capabilities, language: Language) -> Iterator[tuple[str, str]]:
    missing = [step for step in dict.fromkeys(plan.steps) if step.op not in capabilities.ops]
    if missing:
        known = operation_names(capabilities.operations, language)
        yield "ops.unknown", say("refuse.ops", language, steps=sentence(missing, language), can=known)
    for step in plan.steps:
        if step.translates and step.direction not in capabilities.move_directions:
            can = [say(f"direction.{d}", language) for d in sorted(capabilities.move_directions)]
            yield (
                "ops.direction",
                say(
                    "refuse.directions",
                    language,
                    direction=say(f"direction.{step.direction}", language) if step.direction else "?",
                    can=say("list.joint", language).join(can),
                ),
            )


def _without_consent(
    plan: Plan, capabilities: Capabilities, consents: Collection[str], language: Language
) -> Iterator[tuple[str, str]]:
    for step in plan.steps:
        needed = _declaration(step, capabilities).needed_consent
        if needed and needed not in consents and not capabilities.simulated:
            key = f"refuse.{needed}" if can_say(f"refuse.{needed}") else "refuse.risky"
            yield f"consent.{needed}", say(key, language, step=operation_name(step.operation, language))


def _beyond_arguments(plan: Plan, capabilities: Capabilities, language: Language) -> Iterator[tuple[str, str]]:
    for step in plan.steps:
        wrong = None if step.walks else _declaration(step, capabilities).objection(step.arguments)
        if wrong is not None and isinstance(argument := wrong[0], Number) and isinstance(asked := wrong[1], float):
            yield "limit.argument", say(
                "refuse.argument", language, step=operation_name(step.operation, language),
                asked=amount_of(asked, argument.unit, language), range=range_of(argument, language),
            )  # fmt: skip


def _declaration(step: Primitive, capabilities: Capabilities) -> Operation:
    """Return how the robot itself declares the operation of a step, whatever the plan says of it."""
    return capabilities.operation(step.op) or step.operation


def _well_formed(step: Primitive, capabilities: Capabilities) -> bool:
    """Return whether a step has what belongs to it and nothing else, since plans may not come from the grammar.
    `_beyond_arguments` reports a number that is out of bounds."""
    wrong = None if step.walks else _declaration(step, capabilities).objection(step.arguments)
    out_of_bounds = (
        wrong is not None and isinstance(wrong[0], Number) and isinstance(wrong[1], float) and math.isfinite(wrong[1])
    )
    return step.well_formed and (wrong is None or out_of_bounds)


def _beyond_a_step(plan: Plan, capabilities: Capabilities, language: Language) -> Iterator[tuple[str, str]]:
    limits = capabilities.limits
    for step in plan.steps:
        for rule, asked, limit in (
            ("step_distance", step.travel_m, limits.step_m),
            ("step_degrees", step.degrees, limits.step_deg),
            ("speed", step.speed_mps, limits.speed_mps),
        ):
            if asked is not None and not asked <= limit + _ROUNDING:
                yield _over(rule, asked, limit, language)


def _beyond_a_command(plan: Plan, capabilities: Capabilities, language: Language) -> Iterator[tuple[str, str]]:
    limits = capabilities.limits
    for rule, asked, limit in (
        ("command_steps", float(len(plan.steps)), float(limits.command_steps)),
        ("command_distance", plan.distance_m, limits.command_m),
        ("command_time", math.ceil(seconds_of(plan, capabilities)), limits.command_s),
    ):
        if not asked <= limit + _ROUNDING:
            yield _over(rule, asked, limit, language)


#: Tolerance for converted feet and inches: a tenth of a millimetre above a limit is within it.
_ROUNDING = 1e-4


def _over(rule: str, asked: float, limit: float, language: Language) -> tuple[str, str]:
    return f"limit.{rule}", say(f"refuse.{rule}", language, asked=f"{asked:.4g}", limit=f"{limit:.4g}")
