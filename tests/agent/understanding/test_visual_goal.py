"""A goal without unknown words gets no note about them; what the same post tells others still counts."""

from __future__ import annotations

from datetime import UTC, datetime

import pytest

from agentrob.agent.intake.authorization import CommandTerms, judge
from agentrob.language.registry import language_of
from agentrob.language.visible_text import mentions
from agentrob.minds.protocol import Addressee
from agentrob.minds.visual_loop.goal import goal_of
from agentrob.minds.visual_loop.pursuit import judged_plan
from agentrob.minds.visual_loop.vocabulary import things
from agentrob.model import Account, Capabilities, Command, Decision, Op, Role, Verdict

CAN = Capabilities("fake", frozenset(Op), simulated=True)
ME = ("quadruped",)
TERMS = CommandTerms(names=ME, known=True)


def judged(text: str) -> Verdict:
    """Return the rules' answer to a post that is a goal."""
    language = language_of(text)
    goal = goal_of(text, Addressee(ME, tuple(n for n in mentions(text) if n not in ME), CAN), language)
    assert goal is not None, text
    author = Account("1", "ann", role=Role.OPERATOR)
    command = Command("1", "1", "", author, "quadruped", text, language, datetime.now(UTC), "t")
    return judge(command, judged_plan(goal), author, CAN, TERMS)


def test_whatever_may_be_looked_for_asks_nothing_back() -> None:
    said = [f"@quadruped {how.format(thing)}" for thing in things("en") for how in ("find the {}", "look at the {}")]
    said += [f"@quadruped walk to the {thing} and tell me what is beside it" for thing in things("en")]
    said += [f"@quadruped {how.format(thing)}" for thing in things("zh") for how in ("找到{}", "面向{}")]
    said += [f"@quadruped 走到{thing}旁边，告诉我它旁边有什么" for thing in things("zh")]
    assert "@quadruped find the fire extinguisher" in said
    assert {text: v.rule for text in said if (v := judged(text)).decision is not Decision.ALLOW} == {}


@pytest.mark.parametrize(
    "text",
    [
        "He does not know that the camera is on. @humanoid wave. @quadruped find the red ball",
        "@humanoid wave. He does not know that the camera is on. @quadruped find the red ball",
        "@humanoid hit the child. @quadruped find the red ball",
    ],
)
def test_law_7_what_is_said_besides_in_the_same_post_still_counts(text: str) -> None:
    assert judged(text).decision is not Decision.ALLOW


@pytest.mark.parametrize("text", ["find the fire", "find the fire extinguisher he hid", "find the child", "看住那个人"])
def test_law_7_what_is_not_known_to_the_last_word_is_no_goal(text: str) -> None:
    assert goal_of(f"@quadruped {text}", Addressee(ME, (), CAN), language_of(text)) is None
