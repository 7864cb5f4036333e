"""The operations that a robot declares are understood in the words of its declaration, with their arguments."""

from __future__ import annotations

from dataclasses import replace

import pytest

from agentrob.language.messages.plan_text import sentence
from agentrob.language.parser.grammar import parse
from agentrob.language.parser.repetition import ParseContext
from agentrob.model import (
    BUILT_IN,
    PHOTO,
    ActionClass,
    Capabilities,
    Choice,
    Intent,
    Number,
    Op,
    Operation,
    Option,
    Understanding,
    Unit,
)

GESTURE = ActionClass.GESTURE
BLOW = Operation(
    "blow", GESTURE, {"en": "blow bubbles|blow {seconds} of bubbles", "zh": "吹泡泡|吹{seconds}泡泡"},
    (Number("seconds", Unit.SECONDS, 1, 10, 3),),
)  # fmt: skip
COLOURS = Option("red", {"en": "red|crimson", "zh": "红"}), Option("blue", {"en": "blue", "zh": "蓝"})
GLOW = Operation(
    "glow", GESTURE, {"en": "glow|light up", "zh": "发{colour}光"},
    (Choice("colour", COLOURS), Number("strength", Unit.PERCENT, 0, 100, 50)),
)  # fmt: skip
SIDES = Option("left", {"en": "left", "zh": "左"}), Option("up", {"en": "up", "zh": "上"})
AIM = Operation("aim", GESTURE, {"en": "aim the arm", "zh": "举臂"}, (Choice("side", SIDES),))
LIFT = Operation("lift", GESTURE, {"en": "lift the arm", "zh": "抬臂"}, (Number("height_m", Unit.METRES, 0.1, 1.0),))
CAN = Capabilities("show", frozenset({Op.MOVE, Op.TURN, Op.HELLO}), declared=(BLOW, GLOW, AIM, LIFT))


def read(text: str) -> Understanding:
    return parse(text, ("show",), (), CAN.ops, ParseContext(can=CAN))


@pytest.mark.parametrize(
    ("text", "steps"),
    [
        ("blow bubbles", [{"op": "blow", "seconds": 3.0}]),
        ("Could you blow bubbles for half a minute?", [{"op": "blow", "seconds": 30.0}]),
        ("for 5 seconds blow bubbles", [{"op": "blow", "seconds": 5.0}]),
        ("blow four seconds of bubbles please", [{"op": "blow", "seconds": 4.0}]),
        ("请吹三秒钟泡泡", [{"op": "blow", "seconds": 3.0}]),
        ("吹泡泡5秒", [{"op": "blow", "seconds": 5.0}]),
        ("glow crimson at 80 %", [{"op": "glow", "colour": "red", "strength": 80.0}]),
        ("light up in blue", [{"op": "glow", "colour": "blue", "strength": 50.0}]),
        ("发蓝光，百分之三十", [{"op": "glow", "colour": "blue", "strength": 30.0}]),
        ("aim the arm to the left", [{"op": "aim", "side": "left"}]),
        ("aim the arm up, then wave", [{"op": "aim", "side": "up"}, {"op": "hello"}]),
        ("lift the arm 30 cm", [{"op": "lift", "height_m": 0.3}]),
        ("抬臂半米", [{"op": "lift", "height_m": 0.5}]),
        ("blow bubbles twice", [{"op": "blow", "seconds": 3.0}] * 2),
        ("blow bubbles and do that again", [{"op": "blow", "seconds": 3.0}] * 2),
        ("walk 1 m, blow bubbles for 2 s and turn left 45 degrees",
         [{"op": "move", "direction": "forward", "distance_m": 1.0}, {"op": "blow", "seconds": 2.0},
          {"op": "turn", "direction": "left", "degrees": 45.0}]),
        ("don't wave, blow bubbles", [{"op": "blow", "seconds": 3.0}]),
        ("blow bubbles and stop", [{"op": "blow", "seconds": 3.0}]),
    ],
)  # fmt: skip
def test_a_post_becomes_steps_and_the_robots_own_sentence_means_the_same(
    text: str, steps: list[dict[str, object]]
) -> None:
    understood = read(text)
    assert understood.plan.as_data() == steps, understood.question
    assert all(step.op in BUILT_IN or step.declared is not None for step in understood.plan.steps)
    assert read(sentence(understood.plan, understood.language)).plan.steps == understood.plan.steps


@pytest.mark.parametrize(
    ("text", "ops"),
    [
        ("wave and blow bubbles, take a photo after each", ["hello", PHOTO, "blow", PHOTO]),
        ("walk 1 m, blow bubbles, take a photo after each move", ["move", PHOTO, "blow"]),
    ],
)
def test_photos_are_taken_after_its_own_operations_too(text: str, ops: list[str]) -> None:
    understood = parse(
        text,
        ("show",),
        (),
        frozenset({*CAN.ops, PHOTO}),
        ParseContext(can=replace(CAN, ops=frozenset({*CAN.ops, PHOTO}))),
    )
    assert [step.op for step in understood.plan.steps] == ops, understood.question


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("glow", "is meant in `glow`? It can be red, blue."),
        ("lift the arm", "is meant in `lift the arm`? It can be 0.1 to 1 m."),
        ("举臂", "可以是：左、上。"),
        ("blow bubbles for 3 metres", "What shall I do with `3 metres`?"),
        ("blow bubbles if it rains", "conditions"),
        ("blow bubbles at the wall", "I did not understand"),
        ("lift the arm 30 degrees", "It can be 0.1 to 1 m."),
        ("blow bubbles for 3 seconds, no, wait", ""),
    ],
)
def test_what_is_not_complete_is_asked_about(text: str, said: str) -> None:
    understood = read(text)
    assert understood.intent is not Intent.COMMAND
    assert said in understood.question


@pytest.mark.parametrize(
    "text", ["don't blow bubbles", "why did you blow bubbles?", "yesterday it blew bubbles", "不要吹泡泡"]
)
def test_what_is_denied_or_told_is_not_done(text: str) -> None:
    assert read(text).plan.steps == ()


def test_a_word_that_is_also_the_robots_name_keeps_its_meaning() -> None:
    for name in ("bubbles", "Arm"):
        assert parse("blow bubbles", (name,), (), CAN.ops, ParseContext(can=CAN)).intent is Intent.COMMAND
        assert parse("lift the arm 50 cm", (name,), (), CAN.ops, ParseContext(can=CAN)).intent is Intent.COMMAND


def test_a_robot_without_the_operation_does_not_know_its_words() -> None:
    plain = Capabilities("go2", frozenset({Op.MOVE}))
    assert parse("blow bubbles", (), (), plain.ops, ParseContext(can=plain)).plan.steps == ()
    assert parse("glow red", (), (), plain.ops).plan.steps == ()
