"""The nearest of several robots does a part, where all of one room know how far they are from what the post names."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest

from agentrob.agent.media.room_map import RoomMap
from agentrob.config.map import MapConfig
from agentrob.config.robots import RobotConfig
from agentrob.model import Pose
from tests.agent.agent_scene import Driver, robot_settings
from tests.agent.joint.joint_scene import JointScene
from tests.agent.joint.test_one_of_you import done, takes
from tests.waiting import until

#: Where the robots' homes are in the room: further apart than other tests of this module move them.
HOMES = {"quadruped": (0.0, 0.0), "humanoid": (500.0, 0.0)}
THINGS = [
    {"name": "Door", "at_m": [500.0, 1.0], "size_m": [1.0, 0.1]},
    {"name": "red ball", "at_m": [0, 2], "radius_m": 0.2},
]


def settings(robot: str, **more: Any) -> RobotConfig:
    room = {"room": "lab", "home_at_m": HOMES[robot], "things": THINGS, **more}
    return robot_settings(poll_s=3.0, map=room)  # bids may come late on a busy machine


@pytest.fixture(autouse=True)
async def _at_home(drivers: dict[str, Driver]) -> None:
    """A robot whose driver has just begun does not know yet where it is."""
    for driver in drivers.values():
        async with driver.client() as client:
            await until(client.state, lambda state: state.homed)


@asynccontextmanager
async def agents(scene: JointScene, **humanoid: Any) -> AsyncIterator[None]:
    async with (
        scene.agents("quadruped", settings=settings("quadruped")),
        scene.agents("humanoid", settings=settings("humanoid", **humanoid)),
    ):
        yield


@pytest.mark.parametrize(
    ("text", "nearest", "says", "left"),
    [
        (
            "whoever is nearer to the door, wave",
            "humanoid",
            "I am the nearest to `door`: ",
            "which is nearer to `door`",
        ),
        ("谁离红球近谁挥手", "quadruped", "我离 `红球` 最近：", "留给离 `红球` 更近的 `quadruped`"),
    ],
)
async def test_the_nearest_does_it_and_both_say_how_far_they_are(
    scene: JointScene, text: str, nearest: str, says: str, left: str
) -> None:
    async with agents(scene):
        post = await scene.post(f"@quadruped @humanoid {text}")
        await scene.summary(post)
    assert done(scene, post) == takes(scene, post) == [nearest]
    taken = next(p for p in scene.replies(post) if p.card and p.card.takes)
    assert says in taken.raw
    assert taken.card is not None
    assert 0 < taken.card.near_cm < 10_000
    other = next(p for p in scene.replies(post) if p.card and p.card.left_to)
    assert left in other.raw


@pytest.mark.parametrize(
    ("humanoid", "text", "says"),
    [
        ({"things": []}, "whoever is nearer to the door, wave", "Not every robot knows how far it is from `door`"),
        ({"room": "hall"}, "whoever is nearer to the door, wave", "Not every robot knows how far it is from `door`"),
        ({}, "whoever is nearer to the window, wave", "Not every robot knows how far it is from `window`"),
        ({}, "whoever is nearer, wave", "The post does not say nearer to what"),
    ],
)
async def test_where_no_distance_is_known_the_robot_says_so(
    scene: JointScene, humanoid: dict[str, Any], text: str, says: str
) -> None:
    async with agents(scene, **humanoid):
        post = await scene.post(f"@quadruped @humanoid {text}")
        await scene.summary(post)
    (taken,) = [p for p in scene.replies(post) if p.card and p.card.takes]
    assert says in taken.raw
    assert len(done(scene, post)) == 1


def test_distances_are_to_the_outline_of_a_thing_in_the_rooms_frame() -> None:
    things = [
        {"name": "sofa", "at_m": [2, 0], "size_m": [2, 1], "turned_deg": 90},
        {"name": "ball", "at_m": [0, 3], "radius_m": 0.5},
        {"name": "chair", "at_m": [0, 0], "radius_m": 0.1}, {"name": "chair", "at_m": [1, 0], "radius_m": 0.1},
        {"name": "blue ball", "at_m": [9, 9], "radius_m": 0.1},
        {"name": "green column", "at_m": [4, 1], "radius_m": 0.5},
        {"name": "table", "at_m": [4, 4], "size_m": [2, 1]}, {"name": "table", "at_m": [3.1, 3.6], "radius_m": 0.02},
    ]  # fmt: skip
    config = MapConfig.model_validate({"room": "lab", "home_at_m": [0, 1], "home_facing_deg": 90, "things": things})
    room = RoomMap("rex", robot_settings().model_copy(update={"map": config}))
    assert room.metres_to("Ball", Pose(0, 0, 0)) == pytest.approx(1.5)
    assert room.metres_to("ball", Pose(2, 0, 0)) == 0.0
    assert room.metres_to("sofa", Pose(0, 0, 0)) == pytest.approx(1.5)
    assert room.metres_to("sofa", Pose(1, 0, 0)) == pytest.approx((1.5**2 + 1.0) ** 0.5)
    assert room.metres_to("chair", Pose(0, 0, 0)) is None  # which one?
    assert room.metres_to("table", Pose(2.5, -4, 0)) == pytest.approx(0.0)  # its leg is a part of it
    for name in ("column", "the green pillar", "柱子", "绿色的柱子", "绿柱"):
        assert room.metres_to(name, Pose(0, -3.5, 0)) == pytest.approx(0.0), name
    assert room.metres_to("蓝球", Pose(0, 0, 0)) == pytest.approx((81 + 64) ** 0.5 - 0.1)
    assert room.metres_to("球", Pose(0, 0, 0)) is None  # which one?
    assert room.metres_to("红色的球", Pose(0, 0, 0)) is None  # the colour of the ball is not known
    assert room.metres_to("window", Pose(0, 0, 0)) is None
