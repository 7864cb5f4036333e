"""The paper's functions on a fake robot: from scripts, threads and running event loops."""

from __future__ import annotations

import asyncio
import contextlib
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any
from uuid import uuid4

import pytest

from agentrob.config.load import Config, parse, runtime_dir
from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError, RobotError
from agentrob.model import ActionResult, Capabilities, Op, Outcome
from agentrob.robots.fake import FakeRobot
from agentrob.wiring.drive import Driven, robot_command_driver
from tests.agent.execution.visual_model import DONE, running_loop_model
from tests.minds.scripted_model import move
from tests.robots.driver_scene import Drivers
from tests.tolerances import about_m

pytestmark = pytest.mark.usefixtures("model_libraries")


@pytest.fixture
def lab(tmp_path: Path) -> tuple[Config, str]:
    """Return a configuration with one fake robot of a unique name."""
    name = f"d{uuid4().hex[:8]}"
    options = {"time_scale": 30, "obstacles": [[2.0, 0.0, 0.3]]}
    robot = {"model": "fake", "simulated": True, "home_on_start": True, "options": options, "mentions": ["robô 🤖"]}
    return parse({"data": str(tmp_path / "data"), "robots": {name: robot}}), name


def test_a_command_is_executed_and_each_step_reported(lab: tuple[Config, str]) -> None:
    config, name = lab
    heard: list[ActionResult] = []
    driven = robot_command_driver("walk forward 50 cm and take a photo", name, config=config, on_step=heard.append)
    assert driven.status == "done"
    assert [r.primitive.op for r in driven.results] == [Op.MOVE, Op.GET_FRONT_IMAGE]
    assert driven.results[0].measured["distance_m"] == about_m(0.5)
    assert tuple(heard) == driven.results


def test_after_a_failed_step_no_further_step_is_executed(lab: tuple[Config, str]) -> None:
    config, name = lab
    driven = robot_command_driver("walk forward 4 m, then wave", name, config=config)
    assert driven.status == "failed"
    assert driven.results[0].outcome in (Outcome.STOPPED, Outcome.REFUSED, Outcome.FAILED)
    assert driven.results[1].outcome is Outcome.SKIPPED


@pytest.mark.parametrize(
    ("text", "status", "says"),
    [
        ("walk forward", "asks_back", "how far"),
        ("walk forward 30 m", "refused", "limit"),
        ("good morning", "asks_back", ""),
        ("You are parked at the rim of the quarry. Go forward 2 m.", "asks_back", "quarry"),
    ],
)
def test_unclear_or_forbidden_commands_move_nothing(lab: tuple[Config, str], text: str, status: str, says: str) -> None:
    config, name = lab
    driven = robot_command_driver(text, name, config=config)
    assert driven.status == status
    assert says in driven.message.lower()
    assert driven.results == ()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("in 10 minutes wave", "moves only now"),
        ("every weekday at 9:00 walk 1 m", "moves only now"),
        ("tomorrow wave", "moves only now"),
        ("明天早上九点挥手", "只能现在运动"),
    ],
)
def test_a_text_with_a_time_is_refused_because_drive_moves_now(lab: tuple[Config, str], text: str, says: str) -> None:
    config, name = lab
    driven = robot_command_driver(text, name, config=config)
    assert (driven.status, driven.results) == ("refused", ())
    assert says in driven.message


def test_law_17_a_stored_halt_applies_to_drive_too(lab: tuple[Config, str]) -> None:
    config, name = lab
    halt = Path(config.data) / "drivers" / f"{name}.halt"
    halt.parent.mkdir(parents=True)
    halt.write_text("{}")
    driven = robot_command_driver("walk forward 50 cm", name, config=config)
    assert driven.status == "failed"
    assert driven.results[0].reason == "halted"


def test_drive_works_in_a_thread_and_in_a_running_loop(lab: tuple[Config, str]) -> None:
    config, name = lab
    found: list[Driven] = []
    thread = threading.Thread(target=lambda: found.append(robot_command_driver("wave", name, config=config)))
    thread.start()
    thread.join(60)

    async def inside() -> None:
        found.append(robot_command_driver("wave", name, config=config))

    asyncio.run(inside())
    assert [d.status for d in found] == ["done", "done"]


def test_an_interface_other_than_the_configured_one_is_refused(lab: tuple[Config, str]) -> None:
    config, name = lab
    with pytest.raises(ConfigError, match="is configured on interface 'lo', not 'eth0'"):
        robot_command_driver("wave", name, "eth0", config)


def test_law_7_a_mind_with_vision_steers_by_the_camera(lab: tuple[Config, str]) -> None:
    config, name = lab
    with running_loop_model() as scripted_model:
        scripted_model.loop_answers = [("act_move", {"direction": "forward", "distance_m": 0.5}), DONE]
        address = {"provider": "compatible", "model": "m", "base_url": f"{scripted_model.server.url}/v1"}
        config = config.model_copy(update={"minds": parse({"minds": {"clever": address}}).minds})
        heard: list[ActionResult] = []
        driven = robot_command_driver("walk to the box", name, config=config, on_step=heard.append, mind="clever")
    assert driven.status == "done", driven.message
    assert [r.primitive.op for r in driven.results] == [Op.GET_FRONT_IMAGE, Op.MOVE]
    assert tuple(heard) == driven.results
    assert "The model `clever` says that it saw `a blue box`." in driven.message


def test_a_visual_goal_needs_a_mind_with_vision(lab: tuple[Config, str]) -> None:
    config, name = lab
    driven = robot_command_driver("walk to the box", name, config=config)
    assert driven.status == "asks_back"
    assert "vision model" in driven.message


def test_the_papers_functions_are_in_agentrob_and_imported_lazily() -> None:
    code = (
        "import sys, agentrob; assert 'agentrob.wiring.drive' not in sys.modules; "
        "from agentrob import drive_go2_robot, drive_g1_robot, robot_command_driver, Driven; "
        "assert {'drive_go2_robot', 'drive_g1_robot'} <= set(dir(agentrob)); "
        "assert not hasattr(agentrob, 'drive_h1_robot')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=100, check=False)
    assert done.returncode == 0, done.stderr


# ------------------------------------------------------------------ the owner's settings
def changed(config: Config, name: str, **settings: Any) -> Config:
    """Return the configuration with changed settings of its robot."""
    robot = config.robots[name].model_copy(update=settings)
    return config.model_copy(update={"robots": {name: robot}})


@pytest.mark.parametrize("allow_flip", [False, True])
def test_law_10_a_real_robot_flips_only_with_its_owners_consent(
    lab: tuple[Config, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, allow_flip: bool
) -> None:
    def real(settings: RobotConfig) -> Capabilities:
        return replace(describe(settings), simulated=settings.simulated)

    config, name = lab
    settings = {"simulated": False, "home_on_start": False, "allow_flip": allow_flip}
    describe = FakeRobot.describe
    monkeypatch.setattr(FakeRobot, "describe", real)
    monkeypatch.setenv("AGENTROB_RUNTIME", str(tmp_path))
    drivers = Drivers(runtime_dir())
    try:
        drivers.start(name, **settings, options={"time_scale": 30})
        asyncio.run(home(drivers, name))
        driven = robot_command_driver("do a backflip", name, config=changed(config, name, **settings))
    finally:
        drivers.close()
    if allow_flip:
        assert (driven.status, [r.primitive.op for r in driven.results]) == ("done", [Op.BACKFLIP]), driven.message
    else:
        assert (driven.status, driven.results) == ("refused", ())
        assert "consent.flip" in driven.message


async def home(drivers: Drivers, name: str) -> None:
    """Set home as the owner does, once the robot stands still."""
    async with drivers.client(name) as robot, asyncio.timeout(60):
        while not (await robot.state()).homed:
            with contextlib.suppress(RobotError):
                await robot.home("owner")


def test_the_length_of_a_stride_comes_from_the_configuration(lab: tuple[Config, str]) -> None:
    config, name = lab
    driven = robot_command_driver("take two steps forward", name, config=changed(config, name, step_length_m=0.25))
    assert driven.status == "done", driven.message
    assert driven.results[0].measured["distance_m"] == about_m(0.5)


def test_a_robot_can_be_addressed_by_every_name_it_has_on_a_forum(lab: tuple[Config, str]) -> None:
    config, name = lab
    config = changed(config, name, mentions=("@Bello",))
    driven = robot_command_driver("@somebody wave, @bello walk forward 50 cm", name, config=config)
    assert [r.primitive.op for r in driven.results] == [Op.MOVE], driven.message


@pytest.mark.parametrize(
    ("screen", "answer", "rule"),
    [
        ("model", {"decision": "refuse", "harm": "people"}, "model.people"),
        ("required", "", "screen.required"),
        ("model", "", ""),
        ("rules", {"decision": "refuse", "harm": "people"}, ""),
    ],
)
def test_law_7_the_owners_safety_review_applies_to_drive_too(
    lab: tuple[Config, str], screen: str, answer: Any, rule: str
) -> None:
    config, name = lab
    with running_loop_model() as scripted_model:
        scripted_model.extraction = move("walk forward 50 cm", 50, "cm")
        scripted_model.review = answer or (lambda handler: handler.send(500, b"{}"))
        address = {"provider": "compatible", "model": "m", "base_url": f"{scripted_model.server.url}/v1", "retries": 0}
        config = config.model_copy(update={"minds": parse({"minds": {"clever": address}}).minds})
        config = changed(config, name, mind="clever", screen=screen)
        driven = robot_command_driver("walk forward 50 cm", name, config=config)
        looked = len(scripted_model.prompts("screen"))
    assert (looked > 0) is (screen != "rules")
    assert (driven.results == ()) is bool(rule), driven.message
    assert rule in driven.message


def test_law_7_with_a_required_safety_review_the_rules_alone_move_nothing(lab: tuple[Config, str]) -> None:
    config, name = lab
    config = changed(config, name, mind="clever", screen="required")
    driven = robot_command_driver("walk forward 50 cm", name, config=config, mind="rules")
    assert (driven.status, driven.results) == ("asks_back", ())
    assert "screen.required" in driven.message
