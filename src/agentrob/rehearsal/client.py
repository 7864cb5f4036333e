"""Make a preview: in a process of its own where the simulator can, else by geometry and limits."""

from __future__ import annotations

import asyncio
import importlib.util
import sys
from collections.abc import Sequence

import structlog
from pydantic import ValidationError

from agentrob.model import Capabilities
from agentrob.model.operations.built_in import BUILT_IN
from agentrob.process.run import run_process
from agentrob.rehearsal.geometry import geometry_preview
from agentrob.rehearsal.preview import Missing, Preview, PreviewRequest, read_preview, write_request

#: The kinds of robots that the simulator has a body of.
BODIES = ("go2", "g1")
#: Modes from which the simulated robot can begin: it stands.
STANDING = frozenset({"idle", "walking", "gesture", "locked", "unknown"})
#: What the extra `sim` installs, as far as a preview needs it.
PACKAGES = ("mujoco", "onnxruntime")
COMMAND = (sys.executable, "-m", "agentrob.rehearsal.child")
_log = structlog.get_logger()


def not_simulated(request: PreviewRequest) -> Missing | None:
    """Why this preview cannot be simulated; None if it can."""
    if request.settings.model not in BODIES:
        return Missing.NO_BODY
    if any(step.op not in BUILT_IN for step in request.plan.steps):
        return Missing.OPERATION
    if not request.settings.rehearsal.world:
        return Missing.NO_WORLD
    if any(importlib.util.find_spec(package) is None for package in PACKAGES):
        return Missing.NO_SIMULATOR
    if request.start is None:
        return Missing.NO_PLACE
    return None if request.mode in STANDING else Missing.POSTURE


async def rehearse(request: PreviewRequest, capabilities: Capabilities, command: Sequence[str] = COMMAND) -> Preview:
    """Return the preview of a plan, made by geometry if the simulation takes longer than the settings allow. Never
    raises because of the process that simulates it; a cancellation ends it."""
    missing = not_simulated(request)
    if missing is None:
        try:
            return await _simulated(request, command)
        except TimeoutError:
            missing = Missing.SLOW
        except (OSError, ValidationError, ChildFailed) as e:
            missing = Missing.FAILED
            _log.warning("preview not simulated", robot=request.robot, error=str(e)[:500])
    return await asyncio.to_thread(geometry_preview, request, capabilities, missing)


class ChildFailed(Exception):
    """The process ended without a preview; the last line that it wrote."""


async def _simulated(request: PreviewRequest, command: Sequence[str]) -> Preview:
    """The preview of a process of low priority. Raises `TimeoutError`, `ChildFailed` and `ValidationError`."""
    # One thread: the other cores are for robots, and for people who wait. No GL: nothing is drawn.
    env = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MUJOCO_GL": "disable"}
    done = await run_process(command, write_request(request), limit_s=request.settings.rehearsal.limit_s, env=env)
    if done.returncode:
        raise ChildFailed(done.last_error_line or f"it ended with {done.returncode} and said nothing")
    return await asyncio.to_thread(read_preview, done.stdout)
