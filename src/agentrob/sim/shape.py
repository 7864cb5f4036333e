"""The shape of a robot for viewers in 3D, from the installed models: a real robot needs no running simulation for it.

`python -m agentrob.sim.shape go2` writes the gzipped geometry (`agentrob.sim.rendering.geometry`) to standard output.
"""

from __future__ import annotations

import importlib.util
import os
import sys

from agentrob.errors import SimError


def shape(kind: str) -> bytes:
    """The gzipped geometry of a Go2 or G1 without a room. Raises `SimError` for others, and without the models."""
    if kind not in ("go2", "g1"):
        raise SimError(f"there is no model of a {kind!r}; valid: go2, g1")
    if importlib.util.find_spec("mujoco") is None:
        raise SimError("the shape of a robot needs the package mujoco: install agentrob with its 'sim' extra")
    import mujoco

    from agentrob.sim.bodies.g1 import G1
    from agentrob.sim.bodies.go2 import Go2
    from agentrob.sim.rendering.geometry import geometry
    from agentrob.sim.world.world import FIRST_ROBOT_GROUP

    robot = G1() if kind == "g1" else Go2()
    spec = mujoco.MjSpec()
    robot.add_to(spec, FIRST_ROBOT_GROUP)
    model = spec.compile()
    robot.bind(model, mujoco.MjData(model))
    return geometry(model, robot)


def main(arguments: list[str]) -> int:
    """Write the shape; 1 with one line on standard error if there is none."""
    os.nice(10)
    try:
        sys.stdout.buffer.write(shape(arguments[0] if arguments else ""))
    except SimError as e:
        sys.stderr.write(f"{e}\n")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
