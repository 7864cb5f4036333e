"""A file that survives a power failure: its content is on the disk before it gets its name, and then its name is."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from agentrob.robots.safety.durable_file import write_json


def test_law_17_the_content_is_on_the_disk_before_the_file_is_replaced_and_then_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "new" / "folder" / "rex.halt"
    write_json(path, {"by": "ann"})
    synced: list[tuple[str, object, object]] = []
    sync = os.fsync

    def fsync(opened: int) -> None:
        file = Path(f"/proc/self/fd/{opened}").readlink()
        in_file = None if file.is_dir() else json.loads(file.read_text(encoding="utf-8"))
        synced.append((file.name, in_file, json.loads(path.read_text(encoding="utf-8"))))
        sync(opened)

    monkeypatch.setattr(os, "fsync", fsync)
    opened = len(os.listdir("/proc/self/fd"))
    write_json(path, {"by": "bob"})
    assert synced == [("rex.halt.new", {"by": "bob"}, {"by": "ann"}), ("folder", None, {"by": "bob"})]
    assert len(os.listdir("/proc/self/fd")) == opened
    assert [file.name for file in path.parent.iterdir()] == ["rex.halt"]
