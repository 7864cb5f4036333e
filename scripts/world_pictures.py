"""Make a picture of each shipped world, with both robots at their start, from the room's own camera.

    .venv/bin/python scripts/world_pictures.py [FILE ...]

Writes docs/images/world-*.jpg. With FILE arguments it makes pictures of those worlds instead.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from PIL import Image

from agentrob.sim.bodies.g1 import G1
from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.rendering.cameras import choose_backend, open_renderer
from agentrob.sim.rendering.view import overview
from agentrob.sim.world.scene import load, shipped
from agentrob.sim.world.world import World

FOLDER = Path(__file__).parents[1] / "docs/images"
SIZE_PX, QUALITY = (720, 405), 82
ROBOTS = {"go2": Go2, "g1": G1}


def picture(world_name: str) -> Path:
    scene = load(world_name)
    world = World([ROBOTS[kind]() for kind in scene.start], scene)
    renderer = open_renderer(world.model, choose_backend())
    seen = Image.fromarray(np.ascontiguousarray(renderer.draw(overview(world.model), world.pose)))
    renderer.close()
    path = FOLDER / f"world-{scene.name}.jpg"
    seen.resize(SIZE_PX, Image.Resampling.LANCZOS).save(path, quality=QUALITY, optimize=True)
    return path


def main() -> None:
    for name in sys.argv[1:] or shipped():
        path = picture(name)
        sys.stdout.write(f"{path.relative_to(FOLDER.parents[1])}: {path.stat().st_size / 1000:.0f} kB\n")


if __name__ == "__main__":
    main()
