"""The rules mind: found by its entry point, thin over the grammar, the same answer every time."""

from __future__ import annotations

from importlib.metadata import entry_points

from agentrob.minds.protocol import Addressee, Mind
from agentrob.minds.rules import RulesMind
from agentrob.model import Capabilities, Direction, Intent, Limits, Op, Plan, Primitive

LISTENER = Addressee(("quadruped",), ("dog2",), Capabilities("go2", frozenset(Op)))


def test_the_mind_is_found_by_its_entry_point() -> None:
    (found,) = entry_points(group="agentrob.minds", name="rules")
    mind: Mind = found.load()()
    assert isinstance(mind, RulesMind)
    assert mind.name == "rules"


async def test_it_reads_the_part_for_its_listener() -> None:
    understood = await RulesMind().understand("@dog2 wave @quadruped walk forward 1 m", LISTENER)
    assert understood.intent is Intent.COMMAND
    assert understood.plan.steps == (Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0),)


async def test_it_asks_back_in_the_language_of_the_post() -> None:
    understood = await RulesMind().understand("@quadruped 向前走", LISTENER)
    assert understood.intent is Intent.ASK_BACK
    assert understood.language == "zh"


async def test_a_greeting_is_greeted_and_a_question_is_left_to_the_usual_answer() -> None:
    for text, said in (("@quadruped hello", "Hello!"), ("@quadruped 你好呀", "你好！")):
        greeted = await RulesMind().understand(text, LISTENER)
        assert greeted.intent is Intent.QUESTION
        assert greeted.question.startswith(said)
    asked = await RulesMind().understand("@quadruped who are you", LISTENER)
    assert (asked.intent, asked.question) == (Intent.QUESTION, "")


async def test_it_takes_again_from_the_thread() -> None:
    done = Plan((Primitive(Op.MOVE, Direction.FORWARD, distance_m=2.0), Primitive(Op.HELLO)))
    understood = await RulesMind().understand("@quadruped and now back", LISTENER, [done])
    assert understood.plan.steps == (Primitive(Op.MOVE, Direction.BACKWARD, distance_m=2.0),)
    assert (await RulesMind().understand("@quadruped and now back", LISTENER)).intent is Intent.ASK_BACK


async def test_a_time_is_walked_at_a_pace_that_the_robot_may_go() -> None:
    slow = Addressee(("quadruped",), (), Capabilities("x", frozenset(Op), Limits(speed_mps=0.1)))
    (step,) = (await RulesMind().understand("walk forward for 2 seconds", slow)).plan.steps
    assert step == Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.2, speed_mps=0.1)


async def test_steps_have_the_length_that_was_measured() -> None:
    stepping = Addressee(("quadruped",), (), Capabilities("x", frozenset(Op)), step_m=0.3)
    (step,) = (await RulesMind().understand("take two steps back", stepping)).plan.steps
    assert step == Primitive(Op.MOVE, Direction.BACKWARD, distance_m=0.6)
    assert (await RulesMind().understand("take two steps back", LISTENER)).intent is Intent.ASK_BACK
