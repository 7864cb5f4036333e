"""The rules mind: found by its entry point, a thin layer over the grammar, deterministic."""

from __future__ import annotations

from importlib.metadata import entry_points

import pytest

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


async def test_a_greeting_is_returned_and_a_question_gets_the_usual_answer() -> None:
    for text, said in (("@quadruped hello", "Hello!"), ("@quadruped 你好呀", "你好！")):
        greeted = await RulesMind().understand(text, LISTENER)
        assert greeted.intent is Intent.QUESTION
        assert greeted.question.startswith(said)
    asked = await RulesMind().understand("@quadruped how much do you weigh", LISTENER)
    assert (asked.intent, asked.question) == (Intent.QUESTION, "")


async def test_again_repeats_the_last_command_of_the_thread() -> None:
    done = Plan((Primitive(Op.MOVE, Direction.FORWARD, distance_m=2.0), Primitive(Op.HELLO)))
    understood = await RulesMind().understand("@quadruped and now back", LISTENER, [done])
    assert understood.plan.steps == (Primitive(Op.MOVE, Direction.BACKWARD, distance_m=2.0),)
    assert (await RulesMind().understand("@quadruped and now back", LISTENER)).intent is Intent.ASK_BACK


async def test_a_duration_becomes_a_distance_at_an_allowed_speed() -> None:
    slow = Addressee(("quadruped",), (), Capabilities("x", frozenset(Op), Limits(speed_mps=0.1)))
    (step,) = (await RulesMind().understand("walk forward for 2 seconds", slow)).plan.steps
    assert step == Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.2, speed_mps=0.1)


@pytest.mark.parametrize("text", ["yes", "go ahead", "please", "now", "开始"])
async def test_who_only_assents_is_asked_for_a_command(text: str) -> None:
    understood = await RulesMind().understand(f"@quadruped {text}", LISTENER)
    assert understood.intent is Intent.ASK_BACK
    assert understood.question.startswith(("That does not say what I shall do", "这里没有说要我做什么"))


async def test_steps_have_the_length_that_was_measured() -> None:
    stepping = Addressee(("quadruped",), (), Capabilities("x", frozenset(Op)), step_m=0.3)
    (step,) = (await RulesMind().understand("take two steps back", stepping)).plan.steps
    assert step == Primitive(Op.MOVE, Direction.BACKWARD, distance_m=0.6)
    assert (await RulesMind().understand("take two steps back", LISTENER)).intent is Intent.ASK_BACK


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("who are you?", "I am quadruped, a go2 robot"),
        ("hello, what's your name?", "I am quadruped, a go2 robot"),
        ("tell me a joke", "Why did the robot sit down?"),
        ("can you tell us a joke please", "Why did the robot sit down?"),
        ("good dog!", "Thank you!"),
        ("thanks, good job!", "You are welcome."),
        ("bye bye", "Goodbye!"),
        ("do you speak Chinese?", "I read English and Chinese."),
        ("what do you see?", "Without a vision model I cannot say what I see."),
        ("你是谁", "我是quadruped"),
        ("讲个笑话吧", "我为什么从不拐弯抹角"),
        ("乖狗狗", "谢谢夸奖"),
        ("谢谢你", "不客气"),
        ("再见", "再见"),
        ("你会说中文吗", "我看得懂中文和英文"),
    ],
)
async def test_small_talk_is_answered_with_one_line_and_moves_nothing(text: str, said: str) -> None:
    understood = await RulesMind().understand(f"@quadruped {text}", LISTENER)
    assert understood.intent is Intent.QUESTION
    assert understood.question.startswith(said)
    assert not understood.plan.steps


async def test_small_talk_beside_a_command_is_not_answered_and_drops_nothing() -> None:
    understood = await RulesMind().understand("@quadruped tell me a joke and walk 1 m", LISTENER)
    assert understood.intent is Intent.ASK_BACK


async def test_only_a_robot_with_a_camera_may_answer_with_a_photo() -> None:
    blind = Addressee(("quadruped",), (), Capabilities("go2", frozenset(Op) - {Op.GET_FRONT_IMAGE}))
    for listener, looks in ((LISTENER, True), (blind, False)):
        assert (await RulesMind().understand("@quadruped what do you see?", listener)).looks is looks
