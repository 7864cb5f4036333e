"""Checks whether an offscreen GL backend works here: `python -m agentrob.sim.rendering.gl_probe egl|osmesa`.

It runs in a separate process, because a broken GL library may crash it.
"""

from __future__ import annotations

import importlib
import subprocess
import sys
from typing import Any

#: From best to worst; if none works, pictures are ray-traced.
BACKENDS = ("egl", "osmesa")
LIMIT_S = 20.0


def open_context(backend: str, width: int, height: int) -> Any:
    """A GL context of MuJoCo's for `egl` or `osmesa`, current in the calling thread."""
    context = importlib.import_module(f"mujoco.{backend}").GLContext(width, height)
    context.make_current()
    return context


def works(backend: str) -> bool:
    """Try it in another process."""
    command = [sys.executable, "-m", "agentrob.sim.rendering.gl_probe", backend]
    try:
        done = subprocess.run(command, capture_output=True, timeout=LIMIT_S, check=False)
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0 and b"drawn" in done.stdout


def main() -> None:
    import mujoco

    model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
    context = open_context(sys.argv[1], 16, 16)
    mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
    sys.stdout.write("drawn\n")
    sys.stdout.flush()
    context.free()


if __name__ == "__main__":
    main()
