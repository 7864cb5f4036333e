"""Places of the configuration are understood in both languages, from the declaration alone."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from agentrob_ros2.base import Ros2Base
from agentrob_ros2.navigation import GO

from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError
from agentrob.model import Capabilities, Intent
from agentrob.wiring import app

PLACES: dict[str, Any] = {
    "kitchen": {"x_m": 4.2, "y_m": -1.0, "words": {"en": "kitchen|galley", "zh": "厨房"}},
    "front_door": {"x_m": 0.0, "y_m": 0.0, "words": {"zh": "大门"}},
}


def capabilities(places: dict[str, Any]) -> Capabilities:
    return Ros2Base.describe(RobotConfig(model="ros2", options={"places": places}))


@pytest.mark.parametrize(
    ("text", "steps"),
    [
        ("go to the kitchen", [GO]),
        ("please drive to the galley", [GO]),
        ("drive forward 1 m, then go to the front door", ["move", GO]),
        ("去厨房", [GO]),
        ("前进1米，然后去大门", ["move", GO]),
    ],
)
def test_a_place_is_understood(text: str, steps: list[str]) -> None:
    understood = asyncio.run(app.understand(text, "turtle", capabilities(PLACES)))
    assert understood.intent is Intent.COMMAND, understood.question
    assert [step.op for step in understood.plan.steps] == steps
    assert understood.plan.steps[-1].value("place") in PLACES


def test_a_place_that_is_not_configured_moves_nothing() -> None:
    for text in ("go to the bathroom", "去浴室"):
        assert asyncio.run(app.understand(text, "turtle", capabilities(PLACES))).intent is not Intent.COMMAND


def test_without_places_it_does_not_offer_to_go_anywhere() -> None:
    assert GO not in capabilities({}).ops


@pytest.mark.parametrize(
    ("places", "words"),
    [
        ({"Kitchen": {"x_m": 1.0, "y_m": 1.0}}, "Kitchen"),
        ({"kitchen": {"x_m": 1.0}}, "places.kitchen.y_m: Field required"),
        ({"kitchen": {"x_m": 1.0, "y_m": 1.0, "words": {"zh": "厨房", "en": ""}}}, "places: "),
    ],
)
def test_a_place_that_is_wrong_is_told(places: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigError, match="options of a ROS 2 base") as error:
        capabilities(places)
    assert words in str(error.value)
