"""A model's summary of a command contains only measured facts, or it is discarded."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agentrob.minds.extraction.summary import MOST_CHARS, summarise, unfounded
from agentrob.model import ActionResult, Direction, Op, Outcome, Primitive
from tests.minds.scripted_model import ScriptedModel, running_scripted_model

pytestmark = pytest.mark.usefixtures("model_libraries")


@pytest.fixture
def scripted_model() -> Iterator[ScriptedModel]:
    with running_scripted_model() as made:
        yield made


def did(op: Op, direction: Direction | None = None, **measured: float) -> ActionResult:
    asked = {key: round(value) for key, value in measured.items()}
    return ActionResult(Primitive(op, direction, **asked), Outcome.DONE, measured)  # type: ignore[arg-type]


WALK = did(Op.MOVE, Direction.FORWARD, distance_m=0.98)
TURN = did(Op.TURN, Direction.LEFT, degrees=89.2)
DONE = [WALK, TURN, did(Op.HELLO), did(Op.HELLO)]


@pytest.mark.parametrize(
    "text",
    [
        "I walked forward 0.98 m, turned left 89.2 degrees and waved twice.",
        "I moved ahead by 98 cm, then I rotated left by 89.2°, and waved two times.",
        "I did all 4 steps, a short walk forward first and a wave last.",
        "All done.",
        "我向前走了0.98米，向左转了89.2度，然后挥手两次。",
    ],
)
def test_a_summary_of_measured_facts_is_kept(text: str) -> None:
    assert unfounded(text, DONE, "zh" if "我" in text else "en") == ""


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("I walked forward 1 m.", "not measured: 1 m"),
        ("I walked forward 0.98 km.", "not measured: 0.98 km"),
        ("I turned left 360 degrees.", "not measured: 360 degrees"),
        ("I walked at 0.5 m/s.", "not measured: 0.5 m/s"),
        ("I walked backward.", "not this way: backward"),
        ("I waved three times.", "not counted: three times"),
        ("I waved and sat down.", "not done: sit down"),
        ("I met 7 people.", "not counted: 7"),
        ("I walked 1,000 m forward.", "a number that cannot be read: 1,000"),
        ("I walked between 0.98-5 m forward.", "a number that cannot be read"),
        ("I walked forward and hit nobody, not even the cat.", "no plain statement of what was done: not"),
        ("我向前走了5米。", "another language"),
        ("I walked forward. @bob [see](http://x.example)", "empty, too long or more than words"),
        ("", "empty, too long or more than words"),
        ("word " * 100, "empty, too long or more than words"),
    ],
)
def test_law_18_a_summary_beyond_the_results_is_discarded(text: str, problem: str) -> None:
    assert unfounded(text, DONE, "en").startswith(problem)


@pytest.mark.parametrize("outcome", [o for o in Outcome if o is not Outcome.DONE])
def test_law_18_steps_that_were_not_executed_are_not_summarised(outcome: Outcome) -> None:
    failed = ActionResult(WALK.primitive, outcome, WALK.measured)
    assert unfounded("I walked forward 0.98 m.", [WALK, failed], "en") == "not everything was done"
    assert unfounded("All done.", [], "en") == "not everything was done"


@settings(max_examples=150)
@given(
    measured=st.floats(0.05, 20),
    told=st.decimals(0, 50, places=2),
    unit=st.sampled_from(["m", "metres", "cm", "ft", "米"]),
    frame=st.sampled_from(["I walked forward {}.", "So {} it was, forward.", "{}!"]),
)
def test_law_18_no_text_with_another_distance_than_measured_passes(
    measured: float, told: object, unit: str, frame: str
) -> None:
    factor = {"cm": 0.01, "ft": 0.3048}.get(unit, 1.0)
    text = frame.format(f"{told} {unit}")
    language = "zh" if unit == "米" and frame == "{}!" else "en"
    result = [did(Op.MOVE, Direction.FORWARD, distance_m=measured)]
    if abs(float(str(told)) * factor - measured) > 0.011 * max(measured, float(str(told)) * factor) + 0.006:
        assert unfounded(text, result, language)


async def test_the_summary_prompt_has_only_measurements(scripted_model: ScriptedModel, tmp_path: Path) -> None:
    scripted_model.summary = "I walked forward 0.98 m."
    model = scripted_model.model(tmp_path)
    summary = await summarise(model, [WALK, TURN], "en")
    assert (summary.text, summary.failed, summary.mind) == (scripted_model.summary, "", "clever")
    assert len(summary.usage) == 1
    (told,) = scripted_model.prompts("summary")
    assert set(re.findall(r"\d[\d.]*", told)) == {"0.98", "89.2"}
    assert "Write in English." in told
    (body,) = scripted_model.server.requests
    assert "tools" not in body
    scripted_model.summary = "我向前走了0.98米。"
    assert (await summarise(model, [WALK], "zh")).text == scripted_model.summary
    assert "Write in Chinese." in scripted_model.prompts("summary")[1]
    await model.close()


async def test_a_model_that_fails_is_slow_or_invents_gives_no_summary(
    scripted_model: ScriptedModel, tmp_path: Path
) -> None:
    model = scripted_model.model(tmp_path, retries=0)
    scripted_model.summary = lambda handler: handler.send(500, b"{}")
    assert (await summarise(model, [WALK], "en")).failed == "server"
    scripted_model.summary = lambda handler: handler.hang()
    late = await summarise(model, [WALK], "en", limit_s=0.2)
    assert (late.failed, late.text, [u.failed for u in late.usage]) == ("timeout", "", ["timeout"])
    scripted_model.summary = "I walked forward 3 m."
    lied = await summarise(model, [WALK], "en")
    assert (lied.failed, lied.text, lied.problem) == ("unfounded", "", "not measured: 3 m")
    scripted_model.summary = "x" * 100 * MOST_CHARS
    assert (await summarise(model, [WALK], "en")).failed == "unfounded"
    await model.close()
