"""What a mind and the screen together do with one text, and how such outcomes are counted."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from agentrob import app
from agentrob.config import Config
from agentrob.judge.harm import harm_of
from agentrob.judge.scene import harm_in_scene
from agentrob.judge.screen import prepare, screen
from agentrob.language.visible import mentions, visible_text
from agentrob.minds.mind import Listener, Mind
from agentrob.minds.model_mind import ModelMind
from agentrob.model import Account, Capabilities, Decision, Intent, Limits, Plan, Role, Verdict

#: Limits are lifted: what is measured is the meaning, and a dangerous command is not to be stopped by its length.
LIFTED = Limits(10, 3600, 100, 3600, 100, 3600, 100)
#: Whoever posts may command.
AUTHOR = Account("1", "author", role=Role.OPERATOR)
NAME = "robot"


@dataclass(frozen=True, slots=True)
class Outcome:
    """`kind`: executed, refused (by a rule), asked (not understood, or in doubt) or ignored (not taken for a command).

    `rule` names the rule that refused or asked, `said` is what is answered, `plan` what moves or would have moved.
    """

    kind: str
    rule: str = ""
    said: str = ""
    plan: Plan = Plan()


def capabilities_of(robot: str) -> Capabilities:
    """What a kind of robot (`go2`, `g1`) can do, simulated and without limits of distance, angle, speed and time."""
    return replace(app.capabilities_of(robot), limits=LIFTED, simulated=True)


def outcomes(posts: Sequence[tuple[str, str]], mind: str, robot: str, config: Config | None = None) -> list[Outcome]:
    """What comes of each (body of a post, description of the scene or empty); the same way as the agent judges.

    Raises `ConfigError` for an unknown mind or robot, `MindError` when the mind cannot answer at all.
    """
    prepare()
    return asyncio.run(_all(posts, app.make_mind(mind, config), capabilities_of(robot)))


async def _all(posts: Sequence[tuple[str, str]], mind: Mind, can: Capabilities) -> list[Outcome]:
    known: dict[tuple[str, str], Outcome] = {}
    try:
        for post in posts:
            if post not in known:
                known[post] = await _one(*post, mind, can)
        return [known[post] for post in posts]
    finally:
        if isinstance(mind, ModelMind):
            await mind.close()


async def _one(body: str, scene: str, mind: Mind, can: Capabilities) -> Outcome:
    text = visible_text(body)
    listener = Listener((NAME,), tuple(name for name in mentions(text) if name != NAME), can)
    found = await mind.understand(text, listener)
    if found.intent is Intent.COMMAND:
        verdict = screen(found.plan, text=text, author=AUTHOR, capabilities=can, language=found.language, scene=scene)
        return _judged(verdict, found.plan)
    if found.intent is not Intent.ASK_BACK:
        return Outcome("ignored", said=str(found.intent))
    refused = harm_of(text, found.language) or harm_in_scene(text, scene, None, found.language)
    return _judged(refused, Plan()) if refused else Outcome("asked", said=found.question)


def _judged(verdict: Verdict, plan: Plan) -> Outcome:
    kinds = {Decision.ALLOW: "executed", Decision.ASK_BACK: "asked"}
    return Outcome(kinds.get(verdict.decision, "refused"), verdict.rule, verdict.reason, plan)


def wilson(count: int, n: int, z: float = 1.96) -> tuple[float, float]:
    """The 95 % Wilson interval of a share, both ends in 0..1; (0, 1) of nothing."""
    if n == 0:
        return 0.0, 1.0
    share = count / n
    middle = (share + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * math.sqrt(share * (1 - share) / n + z * z / (4 * n * n))
    return max(0.0, middle - half), min(1.0, middle + half)


def cell(count: int, n: int) -> str:
    """A count with its share and interval, for a table: "3 (1.5%, 0.5–4.3%)"."""
    low, high = wilson(count, n)
    return f"{count} ({count / n if n else 0:.1%}, {low:.1%}–{high:.1%})"


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of columns, each as wide as its widest cell."""
    widths = [max(len(row[at]) for row in (header, *rows)) for at in range(len(header))]
    return [
        "  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip()
        for row in (header, *rows)
    ]
