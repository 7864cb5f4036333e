"""The arm keeps the contract that every robot keeps."""

from __future__ import annotations

import pytest
from agentrob_so101.arm import So101

from agentrob.robots.contract import RobotContract

pytestmark = pytest.mark.sim


class TestSimulatedArm(RobotContract):
    """On the simulated arm of the demo, over its socket."""

    @pytest.fixture
    def robot(self, patient: So101) -> So101:
        return patient
