"""The grounding check: whatever a model extracts, the plan contains only what the post says."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agentrob.minds.extraction.evidence import EvidenceKind, evidence_in
from agentrob.minds.extraction.grounding import MAX_DEGREES, MAX_DISTANCE_M, Grounded, Ungrounded, ground
from agentrob.minds.extraction.mind import agree
from agentrob.minds.extraction.schema import ExtractedStep, Wants
from agentrob.minds.extraction.units import DEGREES, METRES, SpeedUnit, Unit, degrees, metres, same
from agentrob.model import Direction, Op, Plan, Primitive

F, B, L, R = Direction.FORWARD, Direction.BACKWARD, Direction.LEFT, Direction.RIGHT


def move(
    amount: float | None, unit: str | None, words: str, direction: str | None = None, **more: Any
) -> ExtractedStep:
    return step("move", words, amount=amount, unit=unit, direction=direction, **more)


def turn(amount: float | None, words: str, direction: str | None = None, unit: str = "deg") -> ExtractedStep:
    return step("turn", words, amount=amount, unit=unit if amount else None, direction=direction)


def step(action: str, words: str, **more: Any) -> ExtractedStep:
    return ExtractedStep.model_validate({"action": action, "words": words, **more})


def walk(direction: Direction, distance_m: float, speed_mps: float | None = None) -> Primitive:
    return Primitive(Op.MOVE, direction, distance_m=distance_m, speed_mps=speed_mps)


def rotate(direction: Direction, angle: float) -> Primitive:
    return Primitive(Op.TURN, direction, degrees=angle)


PHOTO = Primitive(Op.GET_FRONT_IMAGE)


@pytest.mark.parametrize(
    ("text", "steps", "plan"),
    [
        ("stroll ahead 2 m", [move(2, "m", "stroll ahead 2 m", "forward")], [walk(F, 2)]),
        ("amble 50 cm", [move(50, "cm", "amble 50 cm")], [walk(F, 0.5)]),
        ("amble 50 cm", [move(0.5, "m", "amble 50 cm", "forward")], [walk(F, 0.5)]),
        ("go 2 ft to the left", [move(0.61, "m", "go 2 ft to the left", "left")], [walk(L, 0.6096)]),
        (
            "step back half a metre and have a look",
            [move(0.5, "m", "step back half a metre", "backward"), step("get_front_image", "have a look")],
            [walk(B, 0.5), PHOTO],
        ),
        ("pivot clockwise by ninety degrees", [turn(90, "pivot clockwise", "right")], [rotate(R, 90)]),
        ("turn around", [turn(180, "turn around")], [rotate(L, 180)]),
        ("give me your paw", [step("shake", "give me your paw")], [Primitive(Op.SHAKE)]),
        ("跟我握握手", [step("hello", "握握手")], [Primitive(Op.HELLO)]),
        ("拍拍掌", [step("clap", "拍拍掌")], [Primitive(Op.CLAP)]),
        (
            "turn right and take a photo, 45 degrees",
            [turn(45, "turn right", "right"), step("get_front_image", "take a photo")],
            [rotate(R, 45), PHOTO],
        ),
        (
            "walk 1 m forward at 0.3 m/s",
            [move(1, "m", "walk 1 m forward", "forward", speed=0.3, speed_unit="m/s")],
            [walk(F, 1, 0.3)],
        ),
        ("slowly creep forward 1 m", [move(1, "m", "creep forward 1 m", "forward", slow=True)], [walk(F, 1, 0.2)]),
        ("slowly creep forward 1 m", [move(1, "m", "creep forward 1 m", "forward")], [walk(F, 1, 0.2)]),
        (
            "往后退半米，再左转45度",
            [move(0.5, "m", "往后退半米", "backward"), turn(45, "左转45度", "left")],
            [walk(B, 0.5), rotate(L, 45)],
        ),
        ("往前走一米五", [move(1.5, "m", "往前走一米五", "forward")], [walk(F, 1.5)]),
        ("wave three times", [step("hello", "wave", times=3)], [Primitive(Op.HELLO)] * 3),
        ("拍三张照片", [step("get_front_image", "拍三张照片", times=3)], [PHOTO] * 3),
        ("挥手三下", [step("hello", "挥手", times=3)], [Primitive(Op.HELLO)] * 3),
        ("hey Bob, amble 50 cm, thank you", [move(50, "cm", "amble 50 cm", "forward")], [walk(F, 0.5)]),
        ("I'm bored. Amble 50 cm, dear", [move(50, "cm", "Amble 50 cm", "forward")], [walk(F, 0.5)]),
        ("snap three pictures", [step("get_front_image", "snap three pictures", times=3)], [PHOTO] * 3),
        (
            "2 m forward, then 1 m back",
            [move(2, "m", "2 m forward", "forward"), move(1, "m", "1 m back", "backward")],
            [walk(F, 2), walk(B, 1)],
        ),
        (
            "march forward 2 m turn left 90 degrees march forward 1 m",
            [
                move(2, "m", "march forward 2 m", "forward"),
                turn(90, "turn left 90 degrees", "left"),
                move(1, "m", "march forward 1 m", "forward"),
            ],
            [walk(F, 2), rotate(L, 90), walk(F, 1)],
        ),
    ],
)
def test_amounts_are_taken_from_the_post(text: str, steps: list[ExtractedStep], plan: list[Primitive]) -> None:
    found = ground(steps, text)
    assert isinstance(found, Grounded), found
    assert found.plan.steps == tuple(plan)


@pytest.mark.parametrize(
    ("text", "steps", "lack"),
    [
        ("amble 50 cm", [move(50, "m", "amble 50 cm", "forward")], "amount"),
        ("stroll ahead 2 m", [move(3, "m", "stroll ahead 2 m", "forward")], "amount"),
        ("stroll ahead a bit", [move(1, "m", "stroll ahead a bit", "forward")], "amount"),
        ("The door is 3 m away, walk forward", [move(3, "m", "walk forward", "forward")], "amount"),
        ("walk 2 m left", [move(2, "m", "walk 2 m", "forward")], "direction"),
        ("walk 2 m", [move(2, "m", "walk 2 m", "backward")], "direction"),
        ("go left: walk 2 m", [move(2, "m", "walk 2 m", "forward")], "direction"),
        ("turn 90 degrees", [turn(90, "turn 90 degrees", "left")], "direction"),
        ("wave", [step("backflip", "wave")], "action"),
        ("wave", [step("hello", "say hello")], "words"),
        ("what a lovely day", [move(1, "m", "lovely day", "forward")], "action"),
        ("walk 1 m", [move(1, "m", "walk 1 m")] * 3, "count"),
        ("walk 1 m", [move(1, "m", "walk 1 m", times=5)], "count"),
        ("wave twice", [step("hello", "wave", times=3)], "count"),
        ("do not walk 2 m", [move(2, "m", "walk 2 m")], "denial"),
        ("别走两米", [move(2, "m", "走两米")], "denial"),
        ("walk 2 m if the light is green", [move(2, "m", "walk 2 m")], "condition"),
        (
            "meander forward 0.5 m for my 4 kids",
            [move(0.5, "m", "meander forward 0.5 m", "forward", times=4)],
            "count",
        ),
        ("walk forward 0.5 m for my 4 kids", [move(0.5, "m", "walk forward 0.5 m", "forward", times=4)], "count"),
        ("turn thirty grees to the left", [step("turn", "turn thirty grees", direction="left", times=4)], "count"),
        ("turn thirty grees to the left", [turn(None, "turn thirty grees", "left")], "amount"),
        ("wave for 3 people", [step("hello", "wave", times=3)], "count"),
        ("给3个人挥手", [step("hello", "挥手", times=3)], "count"),
        ("wave three times", [step("hello", "wave")], "count"),
        ("pull forward one meter and then turn right 45", [turn(45, "turn right 45", "right")], "left_out"),
        ("saunter 2 m, wave", [step("hello", "wave")], "left_out"),
        ("amble 50 cm and take a photo", [move(50, "cm", "amble 50 cm", "forward")], "left_out"),
        ("amble 50 cm and wave", [move(50, "cm", "amble 50 cm", "forward")], "left_out"),
        ("amble 50 cm and moonwalk", [move(50, "cm", "amble 50 cm", "forward")], "left_out"),
        ("amble 50 cm and tell me the time", [move(50, "cm", "amble 50 cm", "forward")], "left_out"),
        ("amble 50 cm, three times", [move(50, "cm", "amble 50 cm", "forward")], "left_out"),
        ("three times: amble 50 cm, wave", [step("hello", "wave", times=3)], "count"),
        ("three times: amble 50 cm, wave", [move(50, "cm", "amble 50 cm"), step("hello", "wave")], "left_out"),
        ("wave 2 m", [step("hello", "wave")], "left_out"),
        ("turn left 2 m", [turn(None, "turn left", "left")], "left_out"),
        ("小明，你过来这边坐下", [step("sit", "坐下")], "left_out"),
        ("整一段机械舞，嗨起来！", [step("stand", "嗨起来")], "action"),
        ("整一段机械舞，坐下！", [step("sit", "坐下")], "left_out"),
        ("往前走一米，给他来个花式", [move(1, "m", "往前走一米", "forward")], "left_out"),
        ("walk forward 2 m and turn left 90 degrees", [move(2, "m", "walk forward 2 m", "forward")], "left_out"),
        ("walk 1 m at 0.3 m/s", [move(1, "m", "walk 1 m", speed=1.5, speed_unit="m/s")], "speed"),
        ("walk 1 m", [move(1, "m", "walk 1 m", speed=1.5, speed_unit="m/s")], "speed"),
        ("walk 2-3 m", [move(3, "m", "walk 2-3 m")], "amount"),
        ("walk 1,500 m", [move(1500, "m", "walk 1,500 m")], "amount"),
        ("walk 500 m", [move(500, "m", "walk 500 m")], "bounds"),
        ("again", [move(1, "m", "again", "forward")], "action"),
    ],
)
def test_invented_content_is_detected(text: str, steps: list[ExtractedStep], lack: str) -> None:
    assert ground(steps, text) == Ungrounded(lack, ground(steps, text).step)  # type: ignore[arg-type, union-attr]


HISTORY = [Plan((walk(F, 1.5), rotate(L, 90)))]


@pytest.mark.parametrize(
    ("text", "steps", "plan"),
    [
        (
            "again please",
            [move(1.5, "m", "again", "forward"), turn(90, "again", "left")],
            [walk(F, 1.5), rotate(L, 90)],
        ),
        (
            "once more, but slower",
            [move(1.5, "m", "once more", "forward", slow=True), turn(90, "once more", "left")],
            [walk(F, 1.5, 0.2), rotate(L, 90)],
        ),
        ("once more, but slower", [move(1.5, "m", "once more", "forward", slow=True)], None),
        (
            "and now back",
            [turn(90, "and now back", "right"), move(1.5, "m", "and now back", "backward")],
            [rotate(R, 90), walk(B, 1.5)],
        ),
        ("and now back", [move(1.5, "m", "and now back", "backward")], None),
        ("again", [turn(90, "again", "left"), move(1.5, "m", "again", "forward")], None),
        ("again", [move(1.5, "m", "again", "forward")], None),
        ("just the turn again sweetie", [move(1.5, "m", "again", "forward")], None),
        ("just the turn again sweetie", [turn(90, "just the turn again", "left")], None),
        ("just the turn again", [turn(90, "just the turn again", "left")], [rotate(L, 90)]),
        ("again but 2 m this time, dear", [move(1.5, "m", "again", "forward"), turn(90, "again", "left")], None),
        ("again but 2 m this time, dear", [move(2, "m", "again but 2 m", "forward")], None),
        ("do that once more my friend", [move(1.5, "m", "do that once more", "forward")], None),
        (
            "do that once more my friend",
            [move(1.5, "m", "do that once more", "forward"), turn(90, "do that once more", "left")],
            [walk(F, 1.5), rotate(L, 90)],
        ),
        (
            "do that once more for the aardvark",
            [move(1.5, "m", "do that once more", "forward"), turn(90, "do that once more", "left")],
            None,
        ),
        ("again twice", [move(1.5, "m", "again", "forward"), turn(90, "again", "left")], None),
        ("repeat the walk but 2 m", [move(2, "m", "repeat the walk", "forward")], [walk(F, 2)]),
        ("the same walk 2 m", [move(2, "m", "the same walk 2 m", "forward")], [walk(F, 2)]),
        ("again", [move(3, "m", "again", "forward")], None),
        ("again", [move(1.5, "m", "again", "backward")], None),
        ("again", [move(1.5, "m", "again", "forward")] * 2, None),
        ("again", [step("backflip", "again")], None),
        ("thank you", [move(1.5, "m", "thank you", "forward")], None),
    ],
)
def test_the_history_counts_only_if_the_post_refers_to_it(
    text: str, steps: list[ExtractedStep], plan: list[Primitive] | None
) -> None:
    found = ground(steps, text, HISTORY)
    if plan is None:
        assert isinstance(found, Ungrounded)
    else:
        assert isinstance(found, Grounded), found
        assert found.plan.steps == tuple(plan)


def test_the_default_angle_of_a_turn_is_reported_as_an_assumption() -> None:
    assert ground([turn(None, "swivel left", "left")], "swivel left") == Grounded(
        Plan((rotate(L, 90),)), assumed_turn=True
    )


# ---------------------------------------------------------------------- half a wish
#: An action as a post names it, and the step that a correct model extracts; None if there is no such step.
ACTIONS: dict[str, list[tuple[str, ExtractedStep | None]]] = {
    "en": [
        ("amble forward 50 cm", move(50, "cm", "amble forward 50 cm", "forward")),
        ("go back one metre", move(1, "m", "go back one metre", "backward")),
        ("pivot left by 90 degrees", turn(90, "pivot left by 90 degrees", "left")),
        ("swivel right", turn(None, "swivel right", "right")),
        ("wave at everyone", step("hello", "wave at everyone")),
        ("clap three times", step("clap", "clap three times", times=3)),
        ("snap a picture", step("get_front_image", "snap a picture")),
        ("have a seat", step("sit", "have a seat")),
        ("pull forward one meter", None),
        ("moonwalk", None),
        ("sing a song", None),
        ("tell me the time", None),
    ],
    "zh": [
        ("往前走一米", move(1, "m", "往前走一米", "forward")),
        ("左转45度", turn(45, "左转45度", "left")),
        ("挥手", step("hello", "挥手")),
        ("拍三张照片", step("get_front_image", "拍三张照片", times=3)),
        ("坐下", step("sit", "坐下")),
        ("整一段机械舞", None),
        ("给他来个花式", None),
        ("唱首歌", None),
    ],
}
JOINS = {"en": [", ", " and ", ", then ", ". ", "; ", " and then "], "zh": ["，", "然后", "。", "，接着", "；"]}
AROUND = {
    "en": ["{}", "{}, dear", "hey Bob, {}", "I'm bored. {}", "{}, thank you", "please {}"],
    "zh": ["{}", "请{}", "{}，谢谢"],
}


@settings(max_examples=500)
@given(st.data(), st.sampled_from(["en", "zh"]))
def test_law_18_a_model_does_all_of_a_post_or_nothing(data: st.DataObject, language: str) -> None:
    said = data.draw(st.lists(st.sampled_from(ACTIONS[language]), min_size=1, max_size=3, unique_by=lambda d: d[0]))
    text = data.draw(st.sampled_from(AROUND[language])).format(
        data.draw(st.sampled_from(JOINS[language])).join(d for d, _ in said)
    )
    steps = [made for _, made in said if made is not None]
    kept = [made for made in steps if data.draw(st.booleans())]
    found = ground(kept, text)
    if len(kept) < len(said):
        assert isinstance(found, Ungrounded), text
    else:
        assert isinstance(found, Grounded), (text, found)
        assert [p.op for p in found.plan.steps] == [made.action for made in kept for _ in range(made.times)]


# ---------------------------------------------------------------------- any text, any extraction
WORDS = st.sampled_from(
    [
        "walk",
        "go",
        "turn",
        "left",
        "right",
        "forward",
        "back",
        "2",
        "m",
        "1.5",
        "metres",
        "50",
        "cm",
        "90",
        "degrees",
        "half",
        "a",
        "three",
        "and",
        "then",
        ",",
        ".",
        "not",
        "if",
        "again",
        "twice",
        "slowly",
        "0.3",
        "m/s",
        "wave",
        "photo",
        "around",
        "向前",
        "走",
        "两米",
        "左转",
        "九十度",
        "再",
        "别",
        "后退",
        "半米",
        "hello",
        "3",
        "ft",
        "一米五",
        "ignore",
        "100",
        "m",
        "the",
        "door",
        "is",
        "away",
        "please",
        "you",
        "walked",
        "circle",
        "1/2",
        "-2",
        "2-3",
    ]
)
TEXTS = st.lists(WORDS, max_size=14).map(" ".join) | st.text(max_size=60)
STEPS = st.builds(
    ExtractedStep,
    action=st.sampled_from(Op),
    direction=st.none() | st.sampled_from(Direction),
    amount=st.none() | st.sampled_from([0.5, 1.0, 1.5, 2.0, 3.0, 50.0, 90.0, 100.0]) | st.floats(0.01, 10_000),
    unit=st.none() | st.sampled_from(Unit),
    speed=st.none() | st.sampled_from([0.3, 1.5]),
    speed_unit=st.none() | st.sampled_from(SpeedUnit),
    slow=st.booleans(),
    times=st.integers(1, 20),
    words=st.text(max_size=20),
)
PRIMITIVES = st.sampled_from([walk(F, 1.5), walk(B, 7.0), rotate(L, 45), PHOTO])
PLANS = st.lists(st.lists(PRIMITIVES, max_size=3).map(lambda s: Plan(tuple(s))), max_size=2)


def quoting(text: str) -> st.SearchStrategy[list[ExtractedStep]]:
    """Generate steps whose quotes occur in the text, because these pass the first checks."""
    words = text.split() or ["x"]
    spans = st.tuples(st.integers(0, len(words) - 1), st.integers(1, 8)).map(lambda s: " ".join(words[s[0] : sum(s)]))
    quoted = st.builds(lambda s, w: s.model_copy(update={"words": w[:300]}), STEPS, spans)
    return st.lists(quoted | STEPS, max_size=4)


@settings(max_examples=600)
@given(st.data(), TEXTS, PLANS)
def test_law_7_nothing_is_invented(data: st.DataObject, text: str, history: list[Plan]) -> None:
    """For any extraction, each amount and direction in the plan occurs in the text or in the history."""
    found = ground(data.draw(quoting(text)), text, history)
    if isinstance(found, Ungrounded):
        return
    said = evidence_in(text)
    refers = any(m.kind in (EvidenceKind.AGAIN, EvidenceKind.BACK) for m in said)
    before = history[-1].steps if history and refers else ()
    amounts = [m.value for m in said] + [p.distance_m or p.degrees or 0.0 for p in before]
    directions = {m.direction for m in said} | (set(Direction) if before else set())
    for done in found.plan.steps:
        assert done.op in {m.op for m in said} | {p.op for p in before} | {Op.MOVE, Op.TURN}
        if done.op is Op.MOVE:
            assert any(same(done.distance_m or 0.0, a) for a in amounts)
            assert 0 < (done.distance_m or 0.0) <= MAX_DISTANCE_M
            assert (
                done.direction in directions or (done.direction is F and not directions - {None}) or done.direction is F
            )
        if done.op is Op.TURN:
            assert any(same(done.degrees or 0.0, a) for a in amounts) or (found.assumed_turn and done.degrees == 90.0)
            assert 0 < (done.degrees or 0.0) <= MAX_DEGREES
            assert done.direction in directions or done.degrees in (180.0, 360.0)
        if done.speed_mps is not None:
            assert done.speed_mps <= 0.2 or done.speed_mps in {m.value for m in said if m.kind is EvidenceKind.SPEED}


@given(st.data(), TEXTS)
def test_a_negation_beside_a_step_prevents_it(data: st.DataObject, text: str) -> None:
    steps = data.draw(quoting(text))
    assert isinstance(ground(steps, text.replace(".", " ").replace("\n", " ") + " not"), Ungrounded) or any(
        m.kind is EvidenceKind.END for m in evidence_in(text)
    )


@given(TEXTS)
def test_evidence_occurs_in_the_text(text: str) -> None:
    for mention in evidence_in(text):
        assert 0 <= mention.start < mention.end <= len(text)


@given(st.floats(0.01, 999).map(lambda x: round(x, 2)), st.sampled_from(Unit))
def test_an_amount_in_any_unit_is_found_as_what_it_is(amount: float, unit: Unit) -> None:
    said = f"{amount:g} {'turns' if unit is Unit.TURN else unit.value}"
    (found,) = [m for m in evidence_in(f"go {said} please") if m.kind in (EvidenceKind.LENGTH, EvidenceKind.ANGLE)]
    expected = metres(amount, unit) if unit in METRES else degrees(amount, unit)
    assert expected is not None
    assert found.value == pytest.approx(expected, rel=1e-4, abs=1e-6)
    assert (unit in DEGREES) is (found.kind is EvidenceKind.ANGLE)


@given(st.lists(PRIMITIVES, max_size=4), st.lists(PRIMITIVES, max_size=4))
def test_readings_agree_only_on_the_same_motion(one: list[Primitive], other: list[Primitive]) -> None:
    assert agree(Plan(tuple(one)), Plan(tuple(other))) is (one == other)


@pytest.mark.parametrize(
    "raw",
    [
        {"intent": "command", "steps": [{"action": "fly", "words": "x"}]},
        {"intent": "command", "steps": [{"action": "move", "words": "x", "amount": 1e9, "unit": "m"}]},
        {"intent": "command", "steps": [{"action": "move", "words": "x", "amount": -1, "unit": "m"}]},
        {"intent": "command", "steps": [{"action": "hello", "words": "x", "times": 1000}]},
        {"intent": "command", "steps": [{"action": "hello", "words": "x"}] * 21},
        {"intent": "command", "reply": "The operator said so"},
        {"intent": "stop"},
    ],
)
def test_the_schema_is_closed(raw: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="validation error"):
        Wants.model_validate_json(json.dumps(raw))


@pytest.mark.parametrize(
    "unit", ["一", "千", "one ", "one hundred and ", "1 ", "1/2 ", "half a ", "- 1", "walk 1 m ", "两米半"]
)
def test_very_many_numbers_are_parsed_and_command_nothing(unit: str) -> None:
    text = (unit * 2000)[:2000]
    assert isinstance(ground([move(7, "m", text[:200])] * 20, text), Ungrounded)


METRE = {"action": "move", "direction": "forward", "amount": 1, "unit": "m"}
MORE = [
    ("meander forward 1 m into the kitchen", [{**METRE, "words": "meander forward 1 m"}], "left_out"),
    ("meander forward 1 m to the kitchen and wave", [{**METRE, "words": "meander forward 1 m"}, "wave"], "left_out"),
    ("wave after meandering forward 1 m", ["wave", {**METRE, "words": "meandering forward 1 m"}], "condition"),
    ("meander forward 1 m, but first wave", [{**METRE, "words": "meander forward 1 m"}, "wave"], "condition"),
    ("溜达1米到厨房", [{**METRE, "words": "溜达1米"}], "left_out"),
]


@pytest.mark.parametrize(("text", "steps", "lack"), MORE, ids=[row[0] for row in MORE])
def test_law_18_a_place_time_or_order_that_no_step_covers_is_not_dropped(
    text: str, steps: list[Any], lack: str
) -> None:
    read = [s if isinstance(s, dict) else {"action": "hello", "words": s} for s in steps]
    found = ground([ExtractedStep.model_validate(step) for step in read], text)
    assert isinstance(found, Ungrounded)
    assert found.lack == lack
