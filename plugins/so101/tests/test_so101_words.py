"""Posts to the arm are understood in both languages, from its declarations alone."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from agentrob_so101.arm import So101

from agentrob.agent.reporting.report import reason_text
from agentrob.config.robots import RobotConfig
from agentrob.model import ActionResult, Intent, Op, Outcome, Primitive
from agentrob.wiring import app

CAN = So101.describe(RobotConfig(model="so101", simulated=True))
WORDS: list[tuple[str, list[tuple[str, dict[str, Any]]]]] = [
    ("wave", [("hello", {})]),
    ("挥挥手", [("hello", {})]),
    ("go home", [("rest_pose", {})]),
    ("归位", [("rest_pose", {})]),
    ("point left", [("point", {"way": "left", "angle": 60.0})]),
    ("point to the right", [("point", {"way": "right", "angle": 60.0})]),
    ("point up 30 degrees", [("point", {"way": "up", "angle": 30.0})]),
    ("指向左边", [("point", {"way": "left", "angle": 60.0})]),
    ("往右指", [("point", {"way": "right", "angle": 60.0})]),
    ("指上面", [("point", {"way": "up", "angle": 60.0})]),
    ("open the gripper", [("open_gripper", {"opening": 100.0})]),
    ("open the gripper to 40 percent", [("open_gripper", {"opening": 40.0})]),
    ("夹爪张开到40%", [("open_gripper", {"opening": 40.0})]),
    ("close the gripper", [("close_gripper", {})]),
    ("合上夹爪", [("close_gripper", {})]),
    ("pick up the red cube", [("pick_up_cube", {})]),
    ("拿起红色方块", [("pick_up_cube", {})]),
    ("take a photo", [("get_front_image", {})]),
    ("拍张照片", [("get_front_image", {})]),
    (
        "point left, then wave, then go home",
        [("point", {"way": "left", "angle": 60.0}), ("hello", {}), ("rest_pose", {})],
    ),
    ("张开夹爪，然后归位", [("open_gripper", {"opening": 100.0}), ("rest_pose", {})]),
]


@pytest.mark.parametrize(("text", "steps"), WORDS, ids=[text for text, _ in WORDS])
def test_it_is_understood(text: str, steps: list[tuple[str, dict[str, Any]]]) -> None:
    understood = asyncio.run(app.understand(text, "arm", CAN))
    assert understood.intent is Intent.COMMAND, understood.question
    assert [(step.op, dict(step.arguments)) for step in understood.plan.steps] == steps


@pytest.mark.parametrize("text", ["point down", "point", "pick up the red cube", "拿起红色方块"])
def test_what_a_real_arm_does_not_offer_is_asked_about(text: str) -> None:
    real = So101.describe(RobotConfig(model="so101"))
    assert asyncio.run(app.understand(text, "arm", real)).intent is not Intent.COMMAND


REASONS = ("keep_out", "joint_limits", "out_of_reach", "not_seen", "missed", "inaccurate", "restless")


@pytest.mark.parametrize("reason", REASONS)
def test_chinese_replies_say_in_chinese_why_a_step_did_not_end_well(reason: str) -> None:
    result = ActionResult(Primitive(Op.HELLO), Outcome.FAILED, reason=reason, message="An English sentence.")
    said = reason_text(result, "zh")
    assert said
    assert said.isascii() is False
    assert "English" not in said
    assert reason_text(result, "en") == "An English sentence."
