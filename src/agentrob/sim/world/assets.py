"""Finds the robots' models and walking policies in the package agentrob-world."""

from __future__ import annotations

import importlib.util
from pathlib import Path

from agentrob.errors import SimError

_PACKAGE, _DISTRIBUTION = "agentrob_world", "agentrob-world"


def model(robot: str) -> Path:
    """The MuJoCo model of a `go2` or `g1` (BSD-3-Clause), its meshes in `assets` beside it. Raises `SimError`."""
    return _file(f"{robot}/{robot}.xml")


def policy(robot: str) -> Path:
    """The walking policy of a `go2` or `g1` (ONNX, Apache-2.0); that of the G1 has names and gains of the joints in its
    metadata. Raises `SimError`."""
    return _file(f"{robot}/policy/policy.onnx")


def _file(name: str) -> Path:
    spec = importlib.util.find_spec(_PACKAGE)
    if spec is None or not spec.submodule_search_locations:
        raise SimError(
            f"the simulated world needs the package {_DISTRIBUTION}: install AgentRob with its 'sim' extra, "
            "pip install 'agentrob[sim]'"
        )
    path = Path(next(iter(spec.submodule_search_locations))) / name
    if not path.is_file():
        raise SimError(f"{path} is missing: install the package {_DISTRIBUTION} again")
    return path
