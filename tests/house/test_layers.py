"""The layers of the code hold, and a planted violation is reported."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def lint(folder: Path) -> subprocess.CompletedProcess[str]:
    """Run import-linter on a copy of the package, without its cache."""
    code = "from importlinter.cli import lint_imports; import sys; sys.exit(lint_imports(no_cache=True))"
    return subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(folder / 'src')!r}); {code}"],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )


def copied(folder: Path) -> Path:
    shutil.copytree(ROOT / "src", folder / "src", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copy(ROOT / "pyproject.toml", folder)
    return folder


def test_the_layers_hold(tmp_path: Path) -> None:
    result = lint(copied(tmp_path))
    assert result.returncode == 0, result.stdout


#: The planted lines, by file, and the import that must be reported as forbidden.
PLANTED = {
    "model/planted.py": "from agentrob import config",
    "board/planted.py": "import agentrob.sim",
    "board/db/planted.py": "import agentrob.board.content.store",
    "forums/planted.py": "import agentrob.agent",
    "screening/planted.py": "import httpx2",
    "robots/control/planted.py": "import agentrob.robots.safety.guard",
    "robots/driver/api.py": "import agentrob.robots.driver.process",
    "sim/world/planted.py": "import agentrob.sim.bodies.go2",
    "agent/reporting/report.py": "import agentrob.agent.store.journal",
}


def plant(folder: Path, file: str, line: str) -> None:
    with (folder / "src/agentrob" / file).open("a") as f:
        f.write(f"\n{line}\n")


@pytest.fixture(scope="module")
def complaints(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Return import-linter's output for all violations at once, because each run takes seconds."""
    folder = copied(tmp_path_factory.mktemp("planted"))
    for file, line in PLANTED.items():
        plant(folder, file, line)
    result = lint(folder)
    assert result.returncode != 0
    return " ".join(result.stdout.split())


@pytest.mark.parametrize("file", PLANTED)
def test_a_planted_violation_is_named(complaints: str, file: str) -> None:
    importer = "agentrob." + file.removesuffix(".py").replace("/", ".")
    imported = PLANTED[file].replace("from agentrob import ", "import agentrob.").removeprefix("import ")
    assert f"{importer} -> {imported} (l." in complaints or f"- {importer} -> {imported}" in complaints, complaints


def test_a_new_room_without_a_layer_is_caught(tmp_path: Path) -> None:
    plant(copied(tmp_path), "new_room.py", "")
    result = lint(tmp_path)
    assert result.returncode != 0, result.stdout
    assert "new_room" in result.stdout
