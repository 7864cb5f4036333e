"""Every kill point names a function that exists, so that a rename fails here and not only in `make test-long`."""

from __future__ import annotations

import importlib
from typing import Any

import pytest

from tests.kill import test_kill_approval, test_kill_points, test_kill_replay, test_kill_restore, test_kill_world

TARGETS = {
    *(point.order["target"] for point in test_kill_points.POINTS),
    *(target for target, _ in test_kill_points.IN_A_STOP),
    *("agentrob." + point.target for point in test_kill_approval.POINTS),
    *(point["target"] for point in test_kill_replay.POINTS.values()),
    *(order["target"] for order in test_kill_restore.ORDERS),
    *test_kill_world.TARGETS,
}


@pytest.mark.parametrize("target", sorted(TARGETS))
def test_a_kill_point_names_a_function(target: str) -> None:
    module, _, path = target.partition(":")
    owner: Any = importlib.import_module(module)
    *owners, name = path.split(".")
    for part in owners:
        owner = getattr(owner, part)
    assert callable(vars(owner)[name])
