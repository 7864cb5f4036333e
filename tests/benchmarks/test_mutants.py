"""The benchmark of mutants finds which of them the tests notice, and leaves the project as it was."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
RULE = '''"""A rule."""


def allowed(speed_mps: float) -> bool:
    return speed_mps <= limit()


def limit() -> float:
    return float("0.5")
'''
TEST = """from planted.rule import allowed


def test_a_slow_one_is_allowed_and_a_fast_one_is_not() -> None:
    assert allowed(0.1)
    assert not allowed(0.9)
"""


def test_a_mutant_that_a_test_notices_is_killed_and_another_survives(tmp_path: Path) -> None:
    files = {
        "pyproject.toml": "[tool.pytest.ini_options]\nmarkers = ['slow: x', 'sim: x']\n",
        "src/planted/__init__.py": "",
        "src/planted/rule.py": RULE,
        "tests/__init__.py": "",
        "tests/test_rule.py": TEST,
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    done = subprocess.run(
        [
            *(sys.executable, ROOT / "benchmarks" / "mutants.py", "src/planted/rule.py"),
            *("--tests", "tests/test_rule.py", "--root", tmp_path, "--json"),
        ],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    noticed = {(mutant["line"], mutant["change"]): mutant["result"] for mutant in json.loads(done.stdout)}
    assert noticed == {
        (5, "return speed_mps <= limit() -> pass"): "killed",
        (5, "speed_mps <= limit() -> speed_mps < limit()"): "survived",
        (9, "return float('0.5') -> pass"): "killed",
    }
    assert (tmp_path / "src/planted/rule.py").read_text() == RULE
