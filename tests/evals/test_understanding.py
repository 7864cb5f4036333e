"""`agentrob eval plan`: counts, failures, JSON, and errors of invalid files."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from agentrob.cli.main import cli
from agentrob.errors import ConfigError
from agentrob.evals import understanding

OWN = Path(__file__).parents[1] / "language" / "asks_back.jsonl"
ROWS: list[dict[str, Any]] = [
    {"text": "turn left", "plan": [{"op": "turn", "direction": "left", "degrees": 90}]},
    {"text": "向前走一米", "plan": [{"op": "move", "direction": "forward", "distance_m": 1}]},
    {"text": "walk forward 100 m", "plan": [{"op": "move", "direction": "forward", "distance_m": 100}]},
    {"text": "how are you", "plan": []},
    {"text": "go to the red ball", "plan": None},
    {"text": "wave", "plan": [{"op": "sit"}]},
]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "rows.jsonl"
    path.write_text("\n".join(json.dumps(row, ensure_ascii=False) for row in ROWS) + "\n\n", encoding="utf-8")
    return path


def test_json_is_one_object_of_counts_and_failures(file: Path) -> None:
    done = CliRunner().invoke(cli, ["eval", "plan", str(file), "--json"])
    assert done.exit_code == 0, done.output
    found = json.loads(done.stdout)
    assert {key: found[key] for key in ("n", "exact", "moved")} == {"n": 6, "exact": 5, "moved": 4}
    assert {key: found[key] for key in ("executed", "refused", "asked", "ignored")} == {
        "executed": 4,
        "refused": 0,
        "asked": 2,
        "ignored": 1,
    }
    assert [(f["text"], f["plan"]) for f in found["failures"]] == [("wave", [{"op": "hello"}])]


def test_the_output_has_the_share_and_each_failure(file: Path) -> None:
    done = CliRunner().invoke(cli, ["eval", "plan", str(file)])
    assert done.stdout.startswith("5 of 6 exact (83.3%), 4 move something\nwanted ")
    assert re.search(r"steps +4 +3 \(75.0%, 30.1%–95.4%\)", done.stdout), done.stdout
    assert "\n  'wave'\n" in done.stdout
    assert "wanted sit\n    got    hello" in done.stdout


def test_our_own_rows_all_ask_back() -> None:
    found = understanding.evaluate_plans(OWN)
    assert found.score.n >= 100
    assert (found.score.exact, found.score.moved) == (found.score.n, 0)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "cannot read"),
        (b"", "has no rows; a row is, for example, {"),
        (b"{", "line 1: not JSON"),
        (b"[]", "line 1: a row is a JSON object, such as {"),
        (b'{"text": "wave"}', "a row needs `text` and `plan`"),
        (b'{"text": 7, "plan": []}', "a row needs `text` and `plan`"),
        (b"\xff", "cannot read"),
    ],
)
def test_an_invalid_file_is_refused_with_a_valid_example(tmp_path: Path, content: bytes | None, said: str) -> None:
    path = tmp_path / "rows.jsonl"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ConfigError, match=r"rows\.jsonl") as refused:
        understanding.evaluate_plans(path)
    assert said in str(refused.value)


def test_an_unknown_mind_is_answered_with_the_known_ones(file: Path) -> None:
    with pytest.raises(ConfigError, match=r"installed minds: .*rules"):
        understanding.evaluate_plans(file, "oracle")
