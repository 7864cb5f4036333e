"""A ROS 2 base keeps the contract that every robot keeps."""

from __future__ import annotations

import pytest

from agentrob.robots.contract import RobotContract

pytestmark = pytest.mark.sim


class TestRos2Base(RobotContract):
    """On the simulated base of the demo, over DDS."""
