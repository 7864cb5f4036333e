"""Find the demo's data folder and the demo that runs there."""

from __future__ import annotations

import contextlib
import fcntl
import json
from pathlib import Path
from typing import Any

from agentrob.config import load as configuration


def demo_folder(once: bool) -> Path:
    """The demo's default data folder; a demo of one post has its own."""
    return configuration.default_data_dir() / ("demo-post" if once else "demo")


def running_demo(data: Path) -> dict[str, Any] | None:
    """The content of `demo.json` of the demo that runs with this data folder."""
    with contextlib.suppress(OSError, ValueError), (data / "demo.lock").open() as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:  # held, so the demo lives
            facts: dict[str, Any] = json.loads((data / "demo.json").read_text())
            return facts
    return None
