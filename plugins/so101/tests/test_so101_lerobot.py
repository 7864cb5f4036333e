"""The real arm through LeRobot: the robot contract on a double of its class, and what is wrong when it is."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import lerobot_double
import pytest
from agentrob_so101.arm import So101
from agentrob_so101.follower import OpenCVCamera, load_lerobot, open_follower
from agentrob_so101.options import So101Options
from so101_world import LIMIT_S, until

from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError, RobotError, RobotUnreachable
from agentrob.model import ActionResult, Op, Outcome, Primitive
from agentrob.robots.contract import RobotContract, go_on

OPTIONS = So101Options(port="/dev/ttyACM0", calibration="my_follower")
SETTINGS = RobotConfig(model="so101", options={"port": "/dev/ttyACM0", "camera": {"source": 0}})


@pytest.fixture
def follower() -> Any:
    return open_follower(OPTIONS, lerobot_double)


@pytest.fixture
def arm(follower: Any) -> Iterator[So101]:
    robot = So101(SETTINGS, follower, OpenCVCamera(So101Options.model_validate(SETTINGS.options), lerobot_double))
    yield robot
    robot.close()


class TestRealArm(RobotContract):
    """On the double: an arm that is reached without a world."""

    @pytest.fixture
    def robot(self, follower: Any) -> Iterator[So101]:
        robot = So101(RobotConfig(model="so101"), follower)
        yield robot
        robot.close()


def test_it_is_opened_in_degrees_with_a_second_limit_and_keeps_its_torque(follower: Any) -> None:
    config = follower.config
    assert (config.port, config.id, config.use_degrees) == ("/dev/ttyACM0", "my_follower", True)
    assert config.max_relative_target == 30.0
    assert not config.disable_torque_on_disconnect


def test_its_camera_gives_a_photo(arm: So101) -> None:
    result = arm.step(Primitive(Op.GET_FRONT_IMAGE), go_on)
    assert result.outcome is Outcome.DONE
    assert (result.image or b"").startswith(b"\xff\xd8")


def test_nothing_is_sent_before_it_is_asked_for(arm: So101, follower: Any) -> None:
    until(lambda: arm.state().age_s < 0.5, "a state")
    assert follower.sent == []


def test_a_stop_sends_where_it_is_and_nothing_follows(arm: So101, follower: Any) -> None:
    results: list[ActionResult] = []
    running = threading.Thread(target=lambda: results.append(arm.step(Primitive(Op.HELLO), go_on)))
    running.start()
    until(lambda: len(follower.sent) > 20, "motion")
    stopped = arm.stop()
    running.join(LIMIT_S)
    assert stopped.confirmed, stopped.message
    (_, last), (_, before) = follower.sent[-1], follower.sent[-3]
    assert max(abs(last[key] - before[key]) for key in last) < 6.0
    assert results[0].reason == "stop"


def test_a_lost_packet_is_no_loss_and_a_pulled_cable_ends_the_step(arm: So101, follower: Any) -> None:
    results: list[ActionResult] = []
    running = threading.Thread(target=lambda: results.append(arm.step(Primitive(Op.HELLO), go_on)))
    running.start()
    until(lambda: len(follower.sent) > 5, "motion")
    follower.lose = 3
    until(lambda: follower.lose == 0, "they are lost")
    sent = len(follower.sent)
    until(lambda: len(follower.sent) > sent + 5, "it goes on")
    follower.broken = OSError("[Errno 5] Input/output error")
    running.join(LIMIT_S)
    assert (results[0].outcome, results[0].reason) == (Outcome.STOPPED, "stale_state")
    assert "Input/output error" in results[0].message
    assert not arm.stop().confirmed


# ------------------------------------------------------------------ what is wrong at the start
def test_without_a_port_it_says_what_to_set() -> None:
    with pytest.raises(ConfigError, match="port must name the serial port of the arm, such as /dev/ttyACM0"):
        So101(RobotConfig(model="so101"))


def test_without_lerobot_it_says_what_to_install() -> None:
    with pytest.raises(RobotError, match=r"a real SO-101 needs LeRobot on this machine: pip install 'lerobot\[feet"):
        load_lerobot()
    with pytest.raises(RobotError, match="the camera of a real SO-101 needs LeRobot"):
        OpenCVCamera(OPTIONS)


def test_an_arm_that_is_not_calibrated_is_told_with_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lerobot_double.SO101Follower, "calibrated", False)
    with pytest.raises(RobotError, match=r"not calibrated as 'my_follower': run lerobot-calibrate .*ttyACM0"):
        open_follower(OPTIONS, lerobot_double)


def test_a_port_without_an_arm_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lerobot_double.SO101Follower, "plugged_in", False)
    with pytest.raises(RobotUnreachable, match="does not answer on /dev/ttyACM0: ConnectionError"):
        open_follower(OPTIONS, lerobot_double)


def test_a_version_of_lerobot_that_does_not_know_degrees_is_told() -> None:
    old = SimpleNamespace(SO101FollowerConfig=lambda port, id: None, SO101Follower=None)
    with pytest.raises(RobotError, match="this version of LeRobot is not supported"):
        open_follower(OPTIONS, old)


def test_a_camera_that_cannot_be_opened_is_told() -> None:
    with pytest.raises(RobotError, match="the camera /dev/video9 cannot be opened: ConnectionError"):
        OpenCVCamera(So101Options.model_validate({"camera": {"source": "/dev/video9"}}), lerobot_double)
