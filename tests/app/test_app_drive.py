"""The calls that the paper names, on a fake robot: from scripts, threads and running event loops."""

from __future__ import annotations

import asyncio
import subprocess
import sys
import threading
from pathlib import Path
from uuid import uuid4

import pytest

from agentrob.config import Config, parse
from agentrob.drive import Driven, robot_command_driver
from agentrob.errors import ConfigError
from agentrob.minds import provider  # noqa: F401 (loaded here, so that no test's time limit counts it)
from agentrob.model import ActionResult, Op, Outcome

sys.path.append(str(Path(__file__).parents[1] / "agent"))
from look_brain import DONE, driving_brain


@pytest.fixture
def lab(tmp_path: Path) -> tuple[Config, str]:
    """A configuration with one fake robot of a name that nobody else uses."""
    name = f"d{uuid4().hex[:8]}"
    options = {"time_scale": 30, "obstacles": [[2.0, 0.0, 0.3]]}
    robot = {"model": "fake", "simulated": True, "home_on_start": True, "options": options, "mentions": ["robô 🤖"]}
    return parse({"data": str(tmp_path / "data"), "robots": {name: robot}}), name


def test_a_command_is_driven_and_each_step_is_heard_of(lab: tuple[Config, str]) -> None:
    config, name = lab
    heard: list[ActionResult] = []
    driven = robot_command_driver("walk forward 50 cm and take a photo", name, config=config, on_step=heard.append)
    assert driven.status == "done"
    assert [r.primitive.op for r in driven.results] == [Op.MOVE, Op.GET_FRONT_IMAGE]
    assert driven.results[0].measured["distance_m"] == pytest.approx(0.5, abs=0.05)
    assert tuple(heard) == driven.results


def test_after_a_failed_step_nothing_more_is_done(lab: tuple[Config, str]) -> None:
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
def test_what_is_not_clear_or_not_allowed_moves_nothing(
    lab: tuple[Config, str], text: str, status: str, says: str
) -> None:
    config, name = lab
    driven = robot_command_driver(text, name, config=config)
    assert driven.status == status
    assert says in driven.message.lower()
    assert driven.results == ()


def test_law_17_a_halt_that_is_kept_holds_for_drive_too(lab: tuple[Config, str]) -> None:
    config, name = lab
    halt = Path(config.data) / "drivers" / f"{name}.halt"
    halt.parent.mkdir(parents=True)
    halt.write_text("{}")
    driven = robot_command_driver("walk forward 50 cm", name, config=config)
    assert driven.status == "failed"
    assert driven.results[0].reason == "halted"


def test_it_works_from_a_thread_and_inside_a_running_loop(lab: tuple[Config, str]) -> None:
    config, name = lab
    found: list[Driven] = []
    thread = threading.Thread(target=lambda: found.append(robot_command_driver("wave", name, config=config)))
    thread.start()
    thread.join(60)

    async def inside() -> None:
        found.append(robot_command_driver("wave", name, config=config))

    asyncio.run(inside())
    assert [d.status for d in found] == ["done", "done"]


def test_another_interface_than_the_configured_one_is_refused(lab: tuple[Config, str]) -> None:
    config, name = lab
    with pytest.raises(ConfigError, match="is configured on interface 'lo', not 'eth0'"):
        robot_command_driver("wave", name, "eth0", config)


def test_law_7_a_mind_with_eyes_looks_and_steers(lab: tuple[Config, str]) -> None:
    config, name = lab
    with driving_brain() as brain:
        brain.drives = [("act_move", {"direction": "forward", "distance_m": 0.5}), DONE]
        address = {"provider": "compatible", "model": "m", "base_url": f"{brain.server.url}/v1"}
        config = config.model_copy(update={"minds": parse({"minds": {"clever": address}}).minds})
        heard: list[ActionResult] = []
        driven = robot_command_driver("walk to the box", name, config=config, on_step=heard.append, mind="clever")
    assert driven.status == "done", driven.message
    assert [r.primitive.op for r in driven.results] == [Op.GET_FRONT_IMAGE, Op.MOVE]
    assert tuple(heard) == driven.results
    assert "The model `clever` says that it saw `a blue box`." in driven.message


def test_without_a_mind_with_eyes_it_says_that_it_needs_one(lab: tuple[Config, str]) -> None:
    config, name = lab
    driven = robot_command_driver("walk to the box", name, config=config)
    assert driven.status == "asks_back"
    assert "vision model" in driven.message


def test_the_calls_of_the_paper_are_in_agentrob_itself_and_nothing_is_loaded_before_they_are_asked_for() -> None:
    code = (
        "import sys, agentrob; assert 'agentrob.drive' not in sys.modules; "
        "from agentrob import drive_go2_robot, drive_g1_robot, robot_command_driver, Driven; "
        "assert {'drive_go2_robot', 'drive_g1_robot'} <= set(dir(agentrob)); "
        "assert not hasattr(agentrob, 'drive_h1_robot')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
