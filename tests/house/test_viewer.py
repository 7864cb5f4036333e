"""The bundled 3D view is what `scripts/viewer` makes of its source, and its licence is beside it."""

from __future__ import annotations

import json
import subprocess

from tests.house.sources import ROOT

STATIC = ROOT / "src/agentrob/board/web/static"


def test_the_script_reproduces_the_bundle() -> None:
    done = subprocess.run(
        [ROOT / "scripts/viewer", "--check"], capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_versions_are_pinned_by_hashes_and_the_licence_is_beside_the_bundle() -> None:
    lock = json.loads((ROOT / "viewer/package-lock.json").read_text())
    packages = {name: entry for name, entry in lock["packages"].items() if name}
    assert packages["node_modules/three"]["version"]
    assert all(entry["integrity"].startswith("sha512-") for entry in packages.values())
    licence = (STATIC / "viewer3d.LICENSE.txt").read_text()
    assert "MIT License" in licence
    assert "three.js authors" in licence
    assert "SPDX-License-Identifier: MIT" in (STATIC / "viewer3d.js").read_text()
