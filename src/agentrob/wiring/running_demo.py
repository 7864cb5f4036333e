"""Where the demo keeps its data, and the demo that runs there now."""

from __future__ import annotations

import contextlib
import fcntl
import json
from pathlib import Path
from typing import Any

from agentrob.config import load as configuration


def demo_folder(once: bool) -> Path:
    """Where the demo keeps everything unless told otherwise; a demo of one post has a folder of its own."""
    return configuration.default_data_dir() / ("demo-post" if once else "demo")


def running_demo(data: Path) -> dict[str, Any] | None:
    """What `demo.json` says of the demo that runs with this data folder."""
    with contextlib.suppress(OSError, ValueError), (data / "demo.lock").open() as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:  # held, so the demo lives
            facts: dict[str, Any] = json.loads((data / "demo.json").read_text())
            return facts
    return None
