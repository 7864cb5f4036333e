"""The floors of the house hold, and a planted violation is caught."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def lint(folder: Path) -> subprocess.CompletedProcess[str]:
    """import-linter over a copy of the package, without its cache."""
    code = "from importlinter.cli import lint_imports; import sys; sys.exit(lint_imports(no_cache=True))"
    return subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(folder / 'src')!r}); {code}"],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    shutil.copytree(ROOT / "src", tmp_path / "src", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def test_the_house_keeps_its_floors(copy: Path) -> None:
    result = lint(copy)
    assert result.returncode == 0, result.stdout


@pytest.mark.parametrize(
    ("file", "line"),
    [
        ("model/planted.py", "from agentrob import config"),
        ("board/planted.py", "import agentrob.sim"),
        ("board/db/planted.py", "import agentrob.board.content.store"),
        ("forums/planted.py", "import agentrob.agent"),
        ("new_room.py", ""),
        ("screening/planted.py", "import httpx2"),
        ("robots/control/planted.py", "import agentrob.robots.safety.guard"),
        ("robots/driver/api.py", "import agentrob.robots.driver.process"),
        ("sim/world/planted.py", "import agentrob.sim.bodies.go2"),
        ("agent/reporting/report.py", "import agentrob.agent.store.journal"),
    ],
)
def test_a_planted_violation_is_caught(copy: Path, file: str, line: str) -> None:
    with (copy / "src/agentrob" / file).open("a") as f:
        f.write(f"\n{line}\n")
    result = lint(copy)
    assert result.returncode != 0, result.stdout
