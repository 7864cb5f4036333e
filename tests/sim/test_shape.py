"""The shape of a robot without a world is the same as in one, without the room."""

from __future__ import annotations

import io
import sys

import pytest

from agentrob.errors import SimError
from agentrob.sim import shape
from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.rendering.geometry import geometry
from agentrob.sim.world.world import World
from tests.sim.rendering.test_geometry import read

pytestmark = pytest.mark.sim


def test_a_shape_from_the_installed_model_is_that_of_the_simulated_robot() -> None:
    world = World([Go2()])
    alone, _ = read(shape.shape("go2"))
    there, _ = read(geometry(world.model, world.robots[0], world.scene))
    assert alone["bodies"][1:] == there["bodies"][1:]
    assert [geom["body"] for geom in alone["geoms"]] == [geom["body"] for geom in there["geoms"]]
    assert (alone["room"], alone["floor"]) == ([], [])


def test_another_kind_and_missing_models_are_one_clear_line(monkeypatch: pytest.MonkeyPatch) -> None:
    errors = io.StringIO()
    monkeypatch.setattr(sys, "stderr", errors)
    assert shape.main(["spot"]) == 1
    assert errors.getvalue() == "there is no model of a 'spot'; valid: go2, g1\n"
    monkeypatch.setattr(shape.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(SimError, match="install agentrob with its 'sim' extra"):
        shape.shape("g1")
