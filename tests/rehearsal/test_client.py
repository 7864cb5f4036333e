"""The process of a preview: it answers, fails, is too slow or is cancelled; and previews without the simulator."""

from __future__ import annotations

import asyncio
import importlib.util
import os
import signal
import sys
from pathlib import Path
from typing import Any

import pytest

from agentrob.config.robots import RehearsalConfig
from agentrob.rehearsal import client
from agentrob.rehearsal.client import rehearse
from agentrob.rehearsal.preview import Basis, Missing, PreviewRequest
from agentrob.robots.unitree.go2 import Go2
from tests.rehearsal.rehearsed import request, walk
from tests.waiting import until

HANGS = "import sys, pathlib, os, time; pathlib.Path(sys.argv[1]).write_text(str(os.getpid())); time.sleep(1000)"


async def preview_of(asked: PreviewRequest, *command: str):
    given = {"command": command} if command else {}
    return await rehearse(asked, Go2.describe(asked.settings), **given)


def runs(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


async def test_a_preview_comes_from_a_process_of_low_priority() -> None:
    found = await preview_of(request(walk(0.5)))
    assert found.basis is Basis.SIMULATION
    assert found.done == 2


@pytest.mark.parametrize(
    ("code", "missing"),
    [
        (f"import os; os.kill(os.getpid(), {int(signal.SIGKILL)})", Missing.FAILED),
        ("raise SystemExit('no world')", Missing.FAILED),
        ("print('{}')", Missing.FAILED),
    ],
)
async def test_a_process_that_fails_leaves_a_preview_by_geometry(code: str, missing: Missing) -> None:
    found = await preview_of(request(walk(0.5)), sys.executable, "-c", code)
    assert (found.basis, found.missing, found.done) == (Basis.GEOMETRY, missing, 1)


async def test_a_process_that_is_too_slow_is_ended(tmp_path: Path) -> None:
    told = tmp_path / "pid"
    soon = RehearsalConfig(world="room", limit_s=2.0)
    asked = request(walk(0.5), settings={"rehearsal": soon})
    found = await preview_of(asked, sys.executable, "-c", HANGS, str(told))
    assert (found.basis, found.missing) == (Basis.GEOMETRY, Missing.SLOW)
    assert not told.exists() or not runs(int(told.read_text()))


async def test_a_cancelled_preview_ends_its_process(tmp_path: Path) -> None:
    told = tmp_path / "pid"
    making = asyncio.ensure_future(preview_of(request(walk(0.5)), sys.executable, "-c", HANGS, str(told)))
    await until(lambda: told.exists() and told.read_text())
    making.cancel()
    await asyncio.gather(making, return_exceptions=True)
    assert not runs(int(told.read_text()))


async def test_tokens_are_not_passed_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AGENTROB_TOKEN", "a secret")
    told = tmp_path / "environment"
    code = "import os, sys, pathlib; pathlib.Path(sys.argv[1]).write_text(repr(dict(os.environ)))"
    await preview_of(request(walk(0.5)), sys.executable, "-c", code, str(told))
    assert "PATH" in told.read_text()
    assert "a secret" not in told.read_text()


@pytest.mark.parametrize(
    ("changed", "missing"),
    [
        ({"settings": {"rehearsal": RehearsalConfig()}}, Missing.NO_WORLD),
        ({"settings": {"model": "fake"}}, Missing.NO_BODY),
        ({"start": None}, Missing.NO_PLACE),
        ({"mode": "sitting"}, Missing.POSTURE),
    ],
)
async def test_what_cannot_be_simulated_says_why(changed: dict[str, Any], missing: Missing) -> None:
    found = await preview_of(request(walk(0.5), **changed), "false")
    assert (found.basis, found.missing) == (Basis.GEOMETRY, missing)


async def test_without_the_extra_sim_a_preview_is_made_of_geometry(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client, "PACKAGES", ("mujoco", "a_package_that_is_not_installed"))
    assert importlib.util.find_spec("a_package_that_is_not_installed") is None
    found = await preview_of(request(walk(0.5)), "false")
    assert (found.basis, found.missing) == (Basis.GEOMETRY, Missing.NO_SIMULATOR)
