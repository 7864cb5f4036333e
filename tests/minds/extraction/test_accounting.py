"""Law 18 with a model: its plan for a post that the rules ask back drops no action, adds none and moves none.

The model here quotes the whole post for each step, so only the check of clauses can tell a wrong plan from a right one.
"""

from __future__ import annotations

import random
from collections.abc import Iterator

from agentrob.minds.extraction.mind import weigh
from agentrob.minds.extraction.schema import ExtractedStep, Wants
from agentrob.model import Intent
from tests.language.parser import generated_posts
from tests.language.parser.generated_posts import Steps, merged
from tests.language.saying import read, short
from tests.sizes import size

_DIRECTIONS = {"F": "forward", "B": "backward", "L": "left", "R": "right"}


def _extracted(step: str, words: str) -> ExtractedStep:
    """Return a step ("F1", "l90", "hello") as a model's answer."""
    said: dict[str, object] = {"action": {"photo": "get_front_image"}.get(step, step)}
    if step[1:2].isdigit():
        action, unit = ("move", "m") if step[0].isupper() else ("turn", "deg")
        direction = _DIRECTIONS[step[0].upper()]
        said = {"action": action, "direction": direction, "amount": float(step[1:]), "unit": unit}
    return ExtractedStep.model_validate({**said, "words": words[:300]})


def _answers(plan: Steps, rng: random.Random) -> Iterator[Steps]:
    """Yield a plan as it is, with a step left out, in reverse order, and with a step added."""
    yield plan
    if len(plan) > 1:
        at = rng.randrange(len(plan))
        yield plan[:at] + plan[at + 1 :]
        yield plan[::-1]
    yield (*plan, rng.choice(["hello", "photo", "F1", "l90"]))


def test_law_18_no_action_of_a_generated_post_is_dropped_added_or_moved() -> None:
    rng = random.Random(18)
    done, wrong = 0, []
    for post in generated_posts.posts(size(600, 20_000)):
        by_rules = read(post.text)
        if by_rules.intent is not Intent.ASK_BACK or not post.plans:
            continue
        for plan in _answers(min(post.plans), rng):
            steps = tuple(_extracted(step, post.text) for step in plan)
            understood = weigh(Wants(intent="command", steps=steps), by_rules, post.text)
            if understood.intent is not Intent.COMMAND:
                continue
            done += 1
            if merged(short(understood.plan).split()) not in {merged(one) for one in post.plans}:
                wrong.append((post.text, plan))
    assert wrong == []
    assert done > 3
