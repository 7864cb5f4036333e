"""A declaration cannot take words that stop, approve, or mean something else."""

from __future__ import annotations

import pytest

from agentrob.errors import ConfigError
from agentrob.language.operations.clashes import clashes, refuse_clashes
from agentrob.model import BUILT_IN, ActionClass, Capabilities, Number, Op, Operation, Unit

SHINE = Operation("shine", ActionClass.GESTURE, {"en": "shine", "zh": "发光"})


SHARE = Number("share", Unit.PERCENT, 0, 100, 50)


def robot(words: dict[str, str], *more: Operation, arguments: tuple[Number, ...] = ()) -> Capabilities:
    own = Operation("puff", ActionClass.GESTURE, words, arguments)
    return Capabilities("lamp", frozenset({Op.MOVE, Op.HELLO}), declared=(own, *more))


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ({"en": "stop the show"}, "“stop the show”, which stops robots"),
        ({"en": "hold on"}, "which stops robots"),
        ({"en": "puff", "zh": "别动"}, "“别动”, which stops robots"),
        ({"en": "approve"}, "which approves or denies commands"),
        ({"en": "puff", "zh": "同意"}, "which approves or denies commands"),
        ({"en": "wave"}, "which already means “wave”"),
        ({"en": "puff|say hello"}, "“say hello”, which already means “wave”"),
        ({"en": "puff", "zh": "挥手"}, "which already means “打个招呼”"),
        ({"en": "dance"}, "which already means “"),
        ({"en": "walk forward"}, "whose words all mean something else already"),
        ({"en": "left"}, "whose words all mean something else already"),
        ({"en": "look left"}, "which already means “turn left 90 degrees”"),
        ({"en": "look"}, "whose words all mean something else already"),
        ({"en": "and"}, "whose words all mean something else already"),
        ({"en": "puff, then wave"}, "whose words all mean something else already"),
        ({"en": "help"}, "which already asks for help"),
        ({"en": "battery"}, "which already asks for status"),
        ({"en": "tell a joke"}, "which robots already answer"),
        ({"en": "every day"}, "which already says when something is to be done"),
        ({"en": "shine"}, "the operations 'puff' and 'shine' are both asked for by “shine”"),
    ],
)
def test_words_that_mean_something_are_named(words: dict[str, str], why: str) -> None:
    can = robot(words, SHINE)
    found = list(clashes(can))
    assert any(why in clash for clash in found), found
    with pytest.raises(ConfigError, match="the robot 'lamp' cannot start: the operation"):
        refuse_clashes(can)


@pytest.mark.parametrize(
    ("words", "arguments"),
    [
        ({"en": "puff"}, ()),
        ({"en": "look up|look down", "zh": "抬头"}, ()),  # no robot turns up or down
        ({"en": "sing|sing a song", "zh": "唱歌"}, ()),  # what robots cannot do today
        ({"en": "open the gripper to {share}|open the gripper", "zh": "张开夹爪"}, (SHARE,)),
        ({"en": "puff {seconds}|puff", "zh": "喷{seconds}"}, (Number("seconds", Unit.SECONDS, 1, 9),)),
    ],
)  # fmt: skip
def test_free_words_are_taken(words: dict[str, str], arguments: tuple[Number, ...]) -> None:
    assert list(clashes(robot(words, SHINE, arguments=arguments))) == []


def test_a_robot_with_built_in_operations_only_is_not_checked_against_them() -> None:
    assert list(clashes(Capabilities("go2", frozenset(Op)))) == []
    assert list(clashes(Capabilities("go2", frozenset(Op), declared=(BUILT_IN["hello"],)))) == []
