"""The doctor examines a base that no driver holds: the domain, topics, QoS and state."""

from __future__ import annotations

import pytest
from agentrob_ros2 import examination
from agentrob_ros2.base import Ros2Base
from agentrob_ros2.simulator import Simulator

from agentrob.config.load import Config
from agentrob.config.robots import RobotConfig
from agentrob.robots.diagnostics.findings import Finding, Status
from agentrob.robots.diagnostics.protocol import Examinable
from agentrob.wiring.doctor import robot as doctor

pytestmark = pytest.mark.sim


def examined(domain: int, **options: object) -> dict[str, Finding]:
    settings = RobotConfig(model="ros2", domain=domain, owner="olga", options=options)
    return {one.check: one for one in doctor.examine("turtle", settings, Config(robots={"turtle": settings}))}


def test_the_class_says_what_it_needs() -> None:
    assert isinstance(Ros2Base, Examinable)


def test_a_healthy_base_is_reported(domain: int, simulator: Simulator) -> None:
    found = examined(domain)
    assert Status.BAD not in {one.status for one in found.values()}, found
    assert found["position"].found == "/odom comes"
    assert found["odometry"].found.startswith("x 0.")
    assert found["commands"].found == "/cmd_vel has a subscriber"
    assert found["scan"].found == "/scan comes"


def test_a_base_on_another_domain_is_named_with_the_command(
    domain: int, simulator: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(examination, "DOMAINS", (domain,))
    empty = 229
    found = examined(empty)["domain"]
    assert found.status is Status.BAD
    assert found.found == f"nothing is published on ROS domain {empty}, but /odom is published on domain {domain}"
    assert f"domain = {domain}" in found.advice
    assert found.command.endswith(f"--domain {domain}")


def test_a_base_that_is_nowhere_is_told_with_what_to_check(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(examination, "DOMAINS", ())
    found = examined(228)["domain"]
    assert found.status is Status.BAD
    assert "ROS_DOMAIN_ID" in found.advice
    assert found.command.startswith("ros2 topic list")


def test_topics_in_a_namespace_are_found(domain: int, simulator: Simulator) -> None:
    found = examined(domain, namespace="tb4")
    assert found["domain"].status is Status.BAD
    assert "/odom" in found["domain"].found
    assert found["position"].found.startswith("Nobody publishes /tb4/odom (nav_msgs/msg/Odometry)")
    assert found["commands"].status is Status.BAD


def test_a_qos_and_a_type_that_do_not_match_are_told(domain: int, simulator: Simulator) -> None:
    pose = {"durability": "transient_local", "reliability": "reliable"}
    found = examined(domain, pose=pose, cmd_vel={"stamped": True})
    assert found["domain"].status is Status.OK
    assert "offered as volatile and wanted as transient_local; set durability" in found["position"].found
    assert "subscribed as geometry_msgs/msg/Twist, and this publishes" in found["commands"].found
    assert all(one.command for one in found.values() if one.status is not Status.OK)
