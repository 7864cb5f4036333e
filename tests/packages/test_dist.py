"""`make dist`: the wheels and sdists, and that the demo runs from them without our locks."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from email import message_from_bytes
from email.message import Message
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROJECTS = sorted(path.parent for path in ROOT.glob("pyproject.toml")) + sorted(
    path.parent for folder in ("packages", "plugins") for path in (ROOT / folder).glob("*/pyproject.toml")
)
#: Of an environment with agentrob[sim], ours included. Eight of them are matplotlib and what it needs.
MOST_PACKAGES, MOST_MB = 83, 400


def sums(folder: Path) -> dict[str, str]:
    """Return the SHA-256 of each file."""
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.glob("agentrob*"))}


@pytest.fixture(scope="module")
def dist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("dist")
    done = subprocess.run([ROOT / "scripts/dist", folder], capture_output=True, text=True, timeout=200, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def metadata(wheel: Path) -> Message:
    with zipfile.ZipFile(wheel) as archive:
        name = next(name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        return message_from_bytes(archive.read(name))


def test_each_project_has_a_wheel_and_an_sdist(dist: Path) -> None:
    for project in PROJECTS:
        facts = tomllib.loads((project / "pyproject.toml").read_text(encoding="utf-8"))["project"]
        stem = f"{facts['name'].replace('-', '_')}-{facts['version']}"
        assert (dist / f"{stem}-py3-none-any.whl").exists()
        assert (dist / f"{stem}.tar.gz").exists()


def test_the_core_needs_no_simulator_plots_or_models_and_its_wheel_carries_the_licence(dist: Path) -> None:
    (wheel,) = dist.glob("agentrob-*.whl")
    wanted = metadata(wheel).get_all("Requires-Dist") or []
    core = [line for line in wanted if "extra ==" not in line]
    heavy = ("mujoco", "onnxruntime", "matplotlib", "openai", "anthropic", "pydantic-ai", "opencv", "agentrob-world")
    assert core
    assert not [line for line in core if line.lower().startswith(heavy)]
    assert {"sim", "models", "postgres", "images", "semantic"} <= set(metadata(wheel).get_all("Provides-Extra") or [])
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
    assert {Path(name).name for name in names if "/licenses/" in name} == {"LICENSE", "NOTICE"}
    assert not [name for name in names if name.startswith(("tests/", "docs/", "packages/"))]


def test_a_later_build_of_a_copy_gives_the_same_bytes(dist: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    copy.mkdir(mode=0o700)
    for name in ("pyproject.toml", "README.md", "CHANGELOG.md", "LICENSE", "NOTICE", ".gitignore"):
        shutil.copyfile(ROOT / name, copy / name)  # with other times than the originals
    for name in ("src", "packages", "plugins", "scripts"):
        ignored = shutil.ignore_patterns("__pycache__", ".venv*")
        shutil.copytree(ROOT / name, copy / name, ignore=ignored, copy_function=shutil.copyfile)
    (copy / "scripts/dist").chmod(0o755)
    (copy / ".venv").symlink_to(sys.prefix)
    out = tmp_path / "out"
    subprocess.run([copy / "scripts/dist", out], capture_output=True, timeout=200, check=True, umask=0o077)
    again = {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(out.glob("agentrob*"))}
    assert again == {
        path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(dist.glob("agentrob*"))
    }


def test_the_sdist_builds_the_same_wheel(dist: Path, tmp_path: Path) -> None:
    (sdist,) = dist.glob("agentrob-*.tar.gz")
    with tarfile.open(sdist) as archive:
        archive.extractall(tmp_path, filter="data")
    (folder,) = tmp_path.iterdir()
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", tmp_path / "wheel"],
        cwd=folder,
        capture_output=True,
        timeout=100,
        check=True,
    )
    (wheel,) = (tmp_path / "wheel").glob("*.whl")
    assert wheel.read_bytes() == (dist / wheel.name).read_bytes()


# ---------------------------------------------------------------------- without our locks
@pytest.fixture(scope="module")
def environment(dist: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return an environment with agentrob[sim] from the wheels, and what they need from the package index."""
    folder = tmp_path_factory.mktemp("environment") / "env"
    subprocess.run([sys.executable, "-m", "venv", folder], check=True, timeout=200)
    pip = [folder / "bin/python", "-m", "pip", "install", "--no-compile", "--disable-pip-version-check"]
    done = subprocess.run(
        [*pip, "--find-links", dist, "agentrob[sim]"], capture_output=True, text=True, timeout=800, check=False
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return folder


@pytest.mark.slow
@pytest.mark.sim
@pytest.mark.timeout(1200)
def test_the_demo_runs_from_the_wheels_without_our_locks(environment: Path, tmp_path: Path) -> None:
    words = "@quadruped walk forward 0.5 metres, turn left 45 degrees and take a photo"
    variables = {key: value for key, value in os.environ.items() if not key.startswith(("PYTHON", "VIRTUAL_ENV"))}
    done = subprocess.run(
        [environment / "bin/agentrob", "demo", "--post", words, "--json", "--data", tmp_path / "data"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=variables,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    told = json.loads(done.stdout.splitlines()[-1])
    assert [step["outcome"] for step in told["steps"]] == ["done"] * 3
    assert len(told["images"]) == 2, "a photo and the path"


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_the_demo_needs_few_packages_and_little_space(environment: Path) -> None:
    script = "import importlib.metadata as m; print(len({d.name for d in m.distributions()} - {'pip', 'setuptools'}))"
    python = environment / "bin/python"
    count = int(subprocess.run([python, "-c", script], capture_output=True, text=True, check=True, timeout=60).stdout)
    files = [path for path in (environment / "lib").rglob("*") if path.is_file() and path.suffix != ".pyc"]
    assert count <= MOST_PACKAGES
    assert sum(path.stat().st_size for path in files) / 1e6 <= MOST_MB
