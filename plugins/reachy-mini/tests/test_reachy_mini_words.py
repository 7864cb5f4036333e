"""Posts to a Reachy Mini are understood in both languages, from the declarations alone."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from agentrob_reachy_mini.robot import ReachyMini

from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError
from agentrob.language.operations.clashes import clashes
from agentrob.model import Capabilities, Intent
from agentrob.wiring import app

CHEER = {"dataset": "someone/moves", "move": "cheer_1", "words": {"en": "cheer", "zh": "欢呼"}}


def capabilities(**options: Any) -> Capabilities:
    return ReachyMini.describe(RobotConfig(model="reachy-mini", options=options))


@pytest.mark.parametrize(
    ("text", "steps"),
    [
        ("nod", [("nod", {})]),
        ("nod your head twice", [("nod", {}), ("nod", {})]),
        ("shake your head", [("shake_head", {})]),
        ("look up", [("look_up", {"angle_deg": 20.0})]),
        ("look down by 15 degrees", [("look_down", {"angle_deg": 15.0})]),
        ("glance to the right", [("glance", {"side": "right", "angle_deg": 30.0})]),
        ("tilt your head left", [("tilt_head", {"side": "left", "angle_deg": 15.0})]),
        ("center your head", [("center_head", {})]),
        ("wiggle your antennas", [("wiggle_antennas", {})]),
        ("turn left 30 degrees", [("turn", {"direction": "left", "degrees": 30.0})]),
        ("turn your body right 45 degrees", [("turn", {"direction": "right", "degrees": 45.0})]),
        ("look left", [("turn", {"direction": "left", "degrees": 90.0})]),
        ("wave", [("hello", {})]),
        ("sway for 5 seconds", [("sway", {"seconds": 5.0})]),
        ("groove", [("groove", {"seconds": 6.0})]),
        ("look up, then nod", [("look_up", {"angle_deg": 20.0}), ("nod", {})]),
        ("点点头", [("nod", {})]),
        ("摇摇头", [("shake_head", {})]),
        ("抬头20度", [("look_up", {"angle_deg": 20.0})]),
        ("低头", [("look_down", {"angle_deg": 20.0})]),
        ("瞥左边", [("glance", {"side": "left", "angle_deg": 30.0})]),
        ("向右歪头", [("tilt_head", {"side": "right", "angle_deg": 15.0})]),
        ("头摆正", [("center_head", {})]),
        ("动动天线", [("wiggle_antennas", {})]),
        ("把身体向左转30度", [("turn", {"direction": "left", "degrees": 30.0})]),
        ("打个招呼", [("hello", {})]),
        ("左右摇摆5秒", [("sway", {"seconds": 5.0})]),
        ("先抬头，然后点点头", [("look_up", {"angle_deg": 20.0}), ("nod", {})]),
    ],
)
def test_what_is_asked_for_is_understood(text: str, steps: list[tuple[str, dict[str, Any]]]) -> None:
    understood = asyncio.run(app.understand(text, "rosie", capabilities()))
    assert understood.intent is Intent.COMMAND, understood.question
    assert [(step.op, step.asked()) for step in understood.plan.steps] == steps


@pytest.mark.parametrize("text", ["dance", "跳舞"])
def test_a_dance_is_made_of_what_it_can_do(text: str) -> None:
    understood = asyncio.run(app.understand(text, "rosie", capabilities()))
    assert {str(step.op) for step in understood.plan.steps} == {"turn", "hello", "nod"}


def test_no_word_of_it_means_something_else() -> None:
    assert list(clashes(capabilities(moves={"cheer": CHEER}))) == []


def test_a_recorded_move_of_the_configuration_is_understood() -> None:
    for text in ("cheer", "欢呼"):
        understood = asyncio.run(app.understand(text, "rosie", capabilities(moves={"cheer": CHEER})))
        assert [step.op for step in understood.plan.steps] == ["play_cheer"]


def test_it_has_a_photo_only_where_its_owner_named_a_camera() -> None:
    assert "get_front_image" not in capabilities().ops
    assert "get_front_image" in capabilities(camera="http://127.0.0.1:8090/snapshot.jpg").ops
    assert "move" not in capabilities().ops


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"url": "192.168.1.30"}, "url: not an address: http://HOST:PORT"),
        ({"head_dps": 900}, "head_dps"),
        ({"port": 8000}, "port is not a setting; valid here: antennas_dps, camera, head_dps, moves, url"),
        ({"moves": {"cheer": {**CHEER, "dataset": "moves"}}}, "moves.cheer.dataset"),
        ({"moves": {"cheer": {**CHEER, "words": {"zh": "欢呼"}}}}, "moves: the operation 'play_cheer' needs words in"),
    ],
)
def test_options_that_are_wrong_are_told_with_what_is_valid(options: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigError, match="options of a Reachy Mini") as error:
        capabilities(**options)
    assert words in str(error.value)
