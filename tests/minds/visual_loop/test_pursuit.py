"""Which posts are goals without a model, who pursues them, and what is never one."""

from __future__ import annotations

import pytest

from agentrob.eyes.colours import ColourDetector
from agentrob.language.goal import Aim, Goal, Subgoal
from agentrob.language.registry import language_of
from agentrob.minds.protocol import Addressee
from agentrob.minds.rules import RulesMind
from agentrob.minds.visual_loop.goal import goal_of, goal_sentence
from agentrob.minds.visual_loop.pursuit import for_model, goal_for, judged_plan, without_model
from agentrob.model import Capabilities, Direction, Op, Plan, Primitive
from agentrob.screening.rights import classes_of

CAN = Capabilities("go2", frozenset(Op))
LISTENER = Addressee(("quadruped",), ("humanoid",), CAN)
HOME, COLOURS = Subgoal(Aim.HOME), Subgoal(Aim.COLOURS)
SEE_BALL, FACE_BALL = Subgoal(Aim.SEE, "ball", "red"), Subgoal(Aim.FACE, "ball", "red")
WAVE = Subgoal(Aim.STEP, step=Primitive(Op.HELLO))
GOALS = {
    "come home": [HOME],
    "please come back home!": [HOME],
    "could you go home?": [HOME],
    "go back to where you started": [HOME],
    "return to the start": [HOME],
    "wave and come home": [WAVE, HOME],
    "回家": [HOME],
    "回到起点": [HOME],
    "先挥手，然后回家": [WAVE, HOME],
    "do you see a red ball?": [SEE_BALL],
    "where is the blue box": [Subgoal(Aim.SEE, "box", "blue")],
    "wave and tell me whether you see a red ball": [WAVE, SEE_BALL],
    "你看到红球了吗？": [SEE_BALL],
    "蓝色的箱子在哪里": [Subgoal(Aim.SEE, "box", "blue")],
    "what colours do you see": [COLOURS],
    "which colors can you see?": [COLOURS],
    "你看到哪些颜色": [COLOURS],
    "turn to the red ball": [FACE_BALL],
    "转向红球": [FACE_BALL],
}
NONE = """come home?|don't come home|never go home|when do you come home?|i go home now|my mother comes home
come home if it rains
come home tomorrow|go home or wave|walk 1 m unless you are home|come home with me|follow me home|turn to the red ball?
see the red ball, walk 1 m|there is a red ball, walk 1 m|do you see a red ball, walk 1 m|don't turn to the red ball
别回家|不要回家|回家吗|我要回家|如果下雨就回家|前面有箱子，走一米|看到红球就走一米|有红球|不要转向红球"""


@pytest.mark.parametrize(("text", "tasks"), GOALS.items())
async def test_a_goal_that_needs_no_model(text: str, tasks: list[Subgoal]) -> None:
    goal = goal_of(f"@quadruped {text}", LISTENER, language_of(text))
    assert goal == Goal(tuple(tasks))
    assert without_model(goal, CAN, ColourDetector({}))
    by_rules = await RulesMind().understand(f"@quadruped {text}", LISTENER)
    assert goal_for(f"@quadruped {text}", LISTENER, by_rules) == goal


@pytest.mark.parametrize("text", [text for line in NONE.splitlines() for text in line.split("|")])
def test_law_18_a_question_a_denial_a_condition_and_a_statement_are_no_goals(text: str) -> None:
    assert goal_of(f"@quadruped {text}", LISTENER, language_of(text)) is None


async def test_the_way_back_within_a_thread_keeps_its_meaning() -> None:
    text, walked = "@quadruped go back to where you started", Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0)
    by_rules = await RulesMind().understand(text, LISTENER, [Plan((walked,))])
    assert by_rules.plan.steps == (Primitive(Op.MOVE, Direction.BACKWARD, distance_m=1.0),)
    assert goal_for(text, LISTENER, by_rules) is None


def test_who_can_pursue_what() -> None:
    door = Goal((Subgoal(Aim.FACE, "door"),))
    assert not without_model(door, CAN, ColourDetector({}))
    assert for_model(door, CAN)
    assert not for_model(Goal((HOME,)), CAN)
    assert not without_model(Goal((FACE_BALL,)), CAN, None)
    blind = Capabilities("g1", CAN.ops - {Op.GET_FRONT_IMAGE})
    assert not without_model(Goal((FACE_BALL,)), blind, ColourDetector({}))
    assert without_model(Goal((HOME,)), blind, None)
    assert not without_model(Goal((HOME,)), Capabilities("arm", frozenset({Op.HELLO})), None)


def test_law_7_a_goal_is_judged_by_every_kind_of_step_that_it_needs() -> None:
    def classes(*tasks: Subgoal) -> set[str]:
        return set(map(str, classes_of(judged_plan(Goal(tasks), local=True))))

    assert classes(HOME) == {"move"}
    assert classes(FACE_BALL) == {"photo", "move"}
    assert classes(SEE_BALL) == classes(COLOURS) == {"photo"}
    assert classes(WAVE, HOME) == {"gesture", "move"}


def test_goals_in_words() -> None:
    goal = Goal((FACE_BALL, HOME))
    assert goal_sentence(goal, "en") == "turn towards the red ball, then go home"
    assert goal_sentence(goal, "zh") == "转向红色球，然后回家"
