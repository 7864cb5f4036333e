"""The options of a ROS 2 base: names in a namespace, and errors that say what is valid."""

from __future__ import annotations

from typing import Any

import pytest
from agentrob_ros2.base import Ros2Base
from agentrob_ros2.network import config, readable
from agentrob_ros2.options import Ros2Options

from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError
from agentrob.model import Direction, Op


def settings(**options: Any) -> RobotConfig:
    return RobotConfig(model="ros2", options=options)


def test_names_are_inside_the_namespace_unless_they_are_absolute() -> None:
    options = Ros2Options(namespace="tb4")
    assert options.absolute("scan") == "/tb4/scan"
    assert options.absolute("/scan") == "/scan"
    assert options.pose_topic == "/tb4/odom"
    assert Ros2Options.model_validate({"pose": {"source": "tf"}}).pose_topic == "/tf"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"scna": {}}, "scna is not a setting; valid here: battery, body, cmd_vel"),
        ({"scan": {"qos": "x"}}, "scan.qos is not a setting; valid here: durability, mount_deg, mount_m"),
        ({"scan": {"reliability": "maybe"}}, "scan.reliability: Input should be 'reliable' or 'best_effort'"),
        ({"namespace": "a b"}, "namespace: not a ROS name"),
        ({"cmd_vel": {"topic": ""}}, "cmd_vel: topic must name where velocities are published"),
        ({"body": {"length_m": 34}}, "body.length_m: Input should be less than or equal to 3"),
        ({"pose": {"source": "gps"}}, "pose.source: Input should be 'odom' or 'tf'"),
        ({"peers": ["<x>"]}, "peers.0: String should match pattern"),
    ],
)
def test_a_wrong_option_is_told_with_what_is_valid(options: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigError, match="options of a ROS 2 base") as error:
        Ros2Base.describe(settings(**options))
    assert words in str(error.value)


def test_what_it_can_do_follows_from_its_options() -> None:
    plain = Ros2Base.describe(settings())
    assert plain.ops == {Op.MOVE, Op.TURN}
    assert plain.move_directions == {Direction.FORWARD, Direction.BACKWARD}
    full = Ros2Base.describe(settings(holonomic=True, image={"topic": "image_raw"}))
    assert full.ops == {Op.MOVE, Op.TURN, Op.GET_FRONT_IMAGE}
    assert full.move_directions == set(Direction)


def test_peers_are_in_the_configuration_of_cyclone_dds() -> None:
    assert '<Peer Address="192.168.1.7"/>' in config("wlan0", ("192.168.1.7",))
    assert "<Discovery>" not in config("wlan0")
    assert 'autodetermine="true"' in config("")


def test_types_are_told_as_ros_writes_them() -> None:
    assert readable("sensor_msgs::msg::dds_::LaserScan_") == "sensor_msgs/msg/LaserScan"
