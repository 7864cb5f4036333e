"""Start the double of model providers (npm @copilotkit/aimock): the OpenAI and Anthropic APIs over HTTP."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Timer
from typing import Any

import httpx2

_CLI = Path(__file__).parent / "double/node_modules/@copilotkit/aimock/dist/cli.js"
LIMIT_S = 60.0


@dataclass
class Double:
    """A running double. `journal` lists its requests, oldest first."""

    url: str

    def journal(self) -> list[dict[str, Any]]:
        entries: list[dict[str, Any]] = httpx2.get(f"{self.url}/__aimock/journal", trust_env=False, timeout=60).json()
        return entries


@contextmanager
def model_double(folder: Path, fixtures: list[dict[str, Any]]) -> Iterator[Double]:
    node = shutil.which("node")
    assert node, "tests of models need Node 20.15 or newer"
    assert _CLI.is_file(), "the double of model providers is not installed: run scripts/model-double"
    file = folder / "fixtures.json"
    file.write_text(json.dumps({"fixtures": fixtures}))
    process = subprocess.Popen(
        [node, str(_CLI), "-f", str(file), "-p", "0"],
        env={**os.environ, "AIMOCK_STRICT_TURN_INDEX": "1"},
        stdout=subprocess.PIPE,
        text=True,
    )
    watch = Timer(LIMIT_S, process.kill)
    watch.start()
    try:
        assert process.stdout is not None
        line = next((x for x in process.stdout if "listening on" in x), "")
        found = re.search(r"http://127\.0\.0\.1:\d+", line)
        assert found, f"the double did not start: {line}"
        watch.cancel()  # a busy machine may need longer for the rest of the request
        yield Double(found[0])
    finally:
        watch.cancel()
        process.kill()
        process.wait(LIMIT_S)
        if process.stdout:
            process.stdout.close()
