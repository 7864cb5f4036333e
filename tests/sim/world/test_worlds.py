"""Worlds as files: the shipped ones are usable, a user's own is read, and an invalid one is reported with what is
valid."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import numpy as np
import pytest

from agentrob.errors import SimError
from agentrob.sim.bodies.g1 import G1
from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.server import announce, choose_domains
from agentrob.sim.world import scene
from agentrob.sim.world.scene import load, parse
from agentrob.sim.world.world import World
from agentrob.wiring import app
from tests.sim.served_world import ServedWorld, start_world

pytestmark = pytest.mark.sim

OWN = """
about = "A shed."
[room]
size_m = [5, 4]
floor = "plain"
[start.go2]
at_m = [-1, 0]
[[thing]]
name = "hot stove"
note = "hot"
shape = "box"
at_m = [1.5, 0.0]
size_m = [0.6, 0.4, 0.9]
turned_deg = 45
colour = "darkred"
"""


@pytest.mark.parametrize("name", ["room", "obstacles", "corridor"])
def test_in_a_shipped_world_both_robots_stand_walk_and_do_not_fall(name: str) -> None:
    world = World([Go2(), G1()], load(name))
    starts = [robot.xy_m for robot in world.robots]
    world.run(1.0)
    for robot, start in zip(world.robots, starts, strict=True):
        assert robot.upright > 0.98
        assert robot.touching() == []
        assert np.hypot(*(robot.xy_m - start)) < 0.05
    for robot in world.robots:
        assert isinstance(robot, Go2 | G1)
        robot.walk(np.array([0.3, 0.0, 0.0]))
    world.run(1.5)
    for robot, start in zip(world.robots, starts, strict=True):
        assert robot.upright > 0.98
        assert robot.touching() == []
        assert np.hypot(*(robot.xy_m - start)) > 0.2


def test_the_shipped_worlds_are_those_that_are_named_and_say_what_is_in_them() -> None:
    assert list(scene.shipped()) == ["corridor", "obstacles", "room"]
    described = load("corridor").description()
    assert described["about"].startswith("An office corridor")
    assert {"name": "wet patch", "note": "slippery"} in described["things"]
    assert "at_m" not in json.dumps(described), "what is there, not where"


def test_a_world_of_ones_own_is_a_file(tmp_path: Path) -> None:
    path = tmp_path / "shed.toml"
    path.write_text(OWN)
    shed = load(str(path))
    assert (shed.name, shed.room.size_m) == ("shed", (5, 4))
    world = World([Go2()], shed)
    world.run(0.5)
    assert world.robots[0].xy_m == pytest.approx([-1, 0], abs=0.05)
    stove = world.model.geom("hot_stove")
    assert stove.size == pytest.approx([0.3, 0.2, 0.45])
    assert world.data.geom("hot_stove").xmat[0] == pytest.approx(np.cos(np.pi / 4))
    with pytest.raises(SimError, match="no start for g1; it has one for: go2"):
        World([G1()], shed)


def test_the_world_that_the_documentation_shows_is_one() -> None:
    text = (Path(__file__).parents[3] / "docs/robots/worlds.md").read_text(encoding="utf-8")
    kitchen = parse(tomllib.loads(text.split("```toml")[1].split("```")[0]), "docs/robots/worlds.md")
    assert kitchen.description()["things"] == [{"name": "stove", "note": "hot"}]
    world = World([Go2()], kitchen)
    world.run(0.5)
    assert world.robots[0].upright > 0.98


FAULTY = [
    ("about =", "about_it =", "about_it is not known; valid here: about, camera, light, room, start, thing"),
    ('about = "A shed."', "", "about: Field required"),
    ('floor = "plain"', 'floor = "grass"', "room.floor: Input should be 'planks', 'tiles' or 'plain' (found 'grass')"),
    ("[5, 4]", "[5, -4]", "room.size_m 2: Input should be greater than 0"),
    ("[start.go2]", "[start.go3]", "start.go3: Input should be 'go2' or 'g1'"),
    ("at_m = [-1, 0]", "at_m = [-3, 0]", "start.go2: at_m must be in the room and 0.55 m from its walls"),
    ("at_m = [-1, 0]", "at_m = [1, 0]", "start.go2: hot_stove is 0.16 m away; 0.55 m are needed"),
    ("[start.go2]", "[start.g1]", "start.g1 needs free = { ahead_m"),
    (
        "at_m = [-1, 0]",
        "at_m = [-1, 0]\nfree = { ahead_m = 2, behind_m = 1, left_m = 1, right_m = 1 }",
        "start.go2.free: hot_stove is",
    ),
    (
        "at_m = [-1, 0]",
        "at_m = [-1, 0]\nfree = { ahead_m = 1, behind_m = 2, left_m = 1, right_m = 1 }",
        "start.go2.free: it must end 0.3 m before the walls (found -0.50 m)",
    ),
    ('shape = "box"', 'shape = "cube"', "thing 1 (hot stove).shape: Input should be 'box', 'ball' or 'column'"),
    ('shape = "box"', 'shape = "ball"', "thing 1 (hot stove): a ball has radius_m (found size_m)"),
    ('shape = "box"', "", "thing 1 (hot stove): without a shape no size"),
    ("turned_deg", "turned", "thing 1 (hot stove).turned is not known; valid here: at_m, colour, height_m"),
    ('"darkred"', '"dark"', "thing 1 (hot stove).colour: 'dark' is not a colour; valid: a CSS name such as 'red'"),
    ('name = "hot stove"', 'name = "floor"', "no thing may be named 'floor'"),
    ("0.9]", "nan]", "thing 1 (hot stove).size_m 3: Input should be"),
    ("0.9]", "0.9", "is not valid TOML"),
]


@pytest.mark.parametrize(("right", "wrong", "said"), FAULTY, ids=[said[:40] for *_, said in FAULTY])
def test_a_faulty_world_is_refused_with_what_would_be_valid(tmp_path: Path, right: str, wrong: str, said: str) -> None:
    assert right in OWN
    path = tmp_path / "shed.toml"
    path.write_text(OWN.replace(right, wrong))
    with pytest.raises(SimError) as refused:
        load(str(path))
    assert said in str(refused.value)
    assert str(path) in str(refused.value)


def test_two_things_of_one_name_and_robots_on_top_of_each_other_are_refused() -> None:
    ball = {"name": "ball", "shape": "ball", "at_m": [3, 2], "radius_m": 0.1}
    world: dict[str, Any] = {"about": "x", "start": {"go2": {"at_m": [0, 0]}}, "thing": [ball, ball]}
    with pytest.raises(SimError, match="2 things are named 'ball'"):
        parse(world, "test")
    free = dict.fromkeys(("ahead_m", "behind_m", "left_m", "right_m"), 1)
    both = {"go2": {"at_m": [0, 0]}, "g1": {"at_m": [0.5, 0], "free": free}}
    with pytest.raises(SimError, match="nearer than 1 m"):
        parse({"about": "x", "start": both}, "test")


def test_an_unknown_world_names_those_that_are_there() -> None:
    with pytest.raises(SimError, match=r"no world named 'mars'; valid: corridor, obstacles, room; or give the path"):
        load("mars")
    with pytest.raises(SimError, match=r"cannot read the world no/such\.toml: No such file"):
        load("no/such.toml")


def test_a_simulated_g1_is_fenced_in_where_its_world_says_that_nothing_stands() -> None:
    fence = app.simulated_robot("g1", 3, "corridor").fence
    assert (fence.x_max_m, fence.y_min_m) == (3.6, -0.3)
    assert app.simulated_robot("go2", 3, "corridor").fence.x_max_m == 5.0


# ------------------------------------------------------------------ served
def test_robots_have_their_usual_domains_unless_another_is_given() -> None:
    assert choose_domains([], []) == {"go2": 1}
    assert choose_domains(["go2", "g1"], []) == {"go2": 1, "g1": 2}
    assert choose_domains(["g1"], ["g1=7"]) == {"g1": 7}
    assert choose_domains([], ["g1=7"]) == {"g1": 7}


@pytest.fixture(scope="module")
def shed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedWorld]:
    folder = tmp_path_factory.mktemp("shed")
    (folder / "shed.toml").write_text(OWN)
    world = start_world(folder, "--world", str(folder / "shed.toml"), environment={"MUJOCO_GL": "off"})
    yield world
    world.end()


def test_a_served_world_says_what_it_serves_and_what_is_in_it(shed: ServedWorld) -> None:
    assert shed.ready["world"] == "shed"
    with httpx2.Client(base_url=shed.url, timeout=100) as room:
        described = room.get("/scene").json()
        assert described["things"] == [{"name": "hot stove", "note": "hot"}]
        beyond = room.post("/faults", json={"box_m": [2.6, 0]})
        assert (beyond.status_code, "x within 2.5 m" in beyond.json()["error"]) == (422, True)
    said = announce(shed.ready)
    for words in ("shed", f"go2 on DDS domain {shed.domain}", shed.url):
        assert words in said


def test_a_world_that_cannot_be_served_ends_with_one_line(tmp_path: Path) -> None:
    (tmp_path / "shed.toml").write_text(OWN)
    command = [sys.executable, "-m", "agentrob", "sim", "--world", str(tmp_path / "shed.toml"), "--robot", "g1"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, check=False)
    assert done.returncode == 1
    assert done.stderr == "agentrob: the world 'shed' has no start for g1; it has one for: go2\n"
