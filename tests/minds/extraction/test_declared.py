"""A model may name an operation that the robot declares; what it is to be done with comes from the post."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from agentrob.language.parser.grammar import parse
from agentrob.language.parser.repetition import ParseContext
from agentrob.minds.extraction.declared import wants_of
from agentrob.minds.extraction.grounding import Grounded, Ungrounded, ground
from agentrob.minds.extraction.mind import weigh
from agentrob.minds.extraction.schema import ExtractedStep, Wants
from agentrob.minds.protocol import Addressee
from agentrob.minds.visual_loop.pursuit import goal_for
from agentrob.model import ActionClass, Capabilities, Choice, Intent, Number, Op, Operation, Option, Primitive, Unit

BLOW = Operation(
    "blow_bubbles", ActionClass.GESTURE,
    {"en": "blow bubbles|blow {seconds} of bubbles", "zh": "吹泡泡|吹{seconds}泡泡"},
    (Number("seconds", Unit.SECONDS, 1, 10, 3),),
)  # fmt: skip
GLOW = Operation(
    "glow", ActionClass.GESTURE, {"en": "glow|light up"},
    (Choice("colour", (Option("red", {"en": "red"}), Option("blue", {"en": "blue"}))),),
)  # fmt: skip
CAN = Capabilities("show", frozenset({Op.MOVE, Op.TURN, Op.HELLO}), declared=(BLOW, GLOW))


def steps(*said: tuple[str, str]) -> tuple[ExtractedStep, ...]:
    read = [{"action": action, "words": words} for action, words in said]
    return wants_of(CAN).model_validate({"intent": "command", "steps": read}).steps


@pytest.mark.parametrize(
    ("text", "said", "asked"),
    [
        ("would you blow bubbles for 5 seconds", [("blow_bubbles", "blow bubbles for 5 seconds")], [{"seconds": 5.0}]),
        ("blow 4 seconds of bubbles", [("blow_bubbles", "blow 4 seconds of bubbles")], [{"seconds": 4.0}]),
        ("吹5秒泡泡", [("blow_bubbles", "吹5秒泡泡")], [{"seconds": 5.0}]),
        ("wave and glow red", [("hello", "wave"), ("glow", "glow red")], [{}, {"colour": "red"}]),
        ("blow bubbles, light up blue", [("blow_bubbles", "blow bubbles"), ("glow", "light up blue")],
         [{"seconds": 3.0}, {"colour": "blue"}]),
    ],
)  # fmt: skip
def test_its_arguments_are_those_of_the_post(
    text: str, said: list[tuple[str, str]], asked: list[dict[str, object]]
) -> None:
    found = ground(steps(*said), text, (), CAN)
    assert isinstance(found, Grounded), found
    assert [step.asked() for step in found.plan.steps] == asked


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("wave to the crowd", [("blow_bubbles", "wave")]),
        ("do not blow bubbles", [("blow_bubbles", "blow bubbles")]),
        ("glow", [("glow", "glow")]),
        ("glow green", [("glow", "glow")]),
        ("blow bubbles and glow red", [("blow_bubbles", "blow bubbles")]),
        ("blow bubbles for 5 seconds or 9 seconds", [("blow_bubbles", "blow bubbles")]),
    ],
)
def test_what_the_post_does_not_say_is_not_done(text: str, said: list[tuple[str, str]]) -> None:
    assert isinstance(ground(steps(*said), text, (), CAN), Ungrounded)


def test_the_schema_has_the_names_of_this_robot_only() -> None:
    assert wants_of(Capabilities("go2", frozenset(Op))) is Wants
    with pytest.raises(ValidationError, match="blow_bubbles"):
        steps(("fly", "fly"))
    assert steps(("move", "walk"))[0].action is Op.MOVE


def test_both_readings_must_agree() -> None:
    text = "blow bubbles for 5 seconds"
    by_rules = parse(text, (), (), CAN.ops, ParseContext(can=CAN))
    wants = Wants(intent="command", steps=steps(("blow_bubbles", "blow bubbles for 5 seconds")))
    assert weigh(wants, by_rules, text, (), CAN) == by_rules
    wave = Wants(intent="command", steps=steps(("hello", "blow bubbles")))
    assert weigh(wave, by_rules, text, (), CAN).intent is Intent.ASK_BACK
    assert by_rules.plan.steps == (Primitive("blow_bubbles", arguments=(("seconds", 5.0),)),)


def test_it_stands_beside_a_goal_that_is_pursued() -> None:
    text = "@show turn to the red ball and blow bubbles for 2 seconds"
    can = Capabilities("show", frozenset({Op.MOVE, Op.TURN, Op.GET_FRONT_IMAGE}), declared=(BLOW,))
    by_rules = parse(text, ("show",), (), can.ops, ParseContext(can=can))
    goal = goal_for(text, Addressee(("show",), (), can), by_rules)
    assert goal is not None
    assert [step.asked() for step in goal.steps] == [{"seconds": 2.0}]
    assert parse("blow bubbles", (), (), can.ops).plan.steps == (), "words of a robot that is not told are not known"
