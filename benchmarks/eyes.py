"""Measure the detector of colours in the simulated room: `python benchmarks/eyes.py [--places N]`.

The Go2 is put at random places up to 3.5 m from each coloured thing that stands on the floor, facing it within 30°.
Printed are how often the thing's colour was seen, how often its shape was recognised, and the error of its angle
against its true place. Places from which something hides the thing count as missed.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import math
import time
from typing import Any

import mujoco
import numpy as np
from PIL import Image

from agentrob.eyes.colours import ColourDetector
from agentrob.eyes.sight import FOV_OF_MODEL_DEG, seen_in
from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.rendering.cameras import choose_backend, open_renderer
from agentrob.sim.rendering.view import front_view
from agentrob.sim.world.world import World

THINGS = (("red_ball", "red", "ball"), ("blue_box", "blue", "box"), ("green_column", "green", "column"))
FARTHEST_M, ASIDE_RAD, ROOM_M = 3.5, 0.5, (3.4, 2.4)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--places", type=int, default=60)
    places = parser.parse_args().places
    world, detector, chance = World([Go2()]), ColourDetector({}), np.random.default_rng(3)
    with contextlib.closing(open_renderer(world.model, choose_backend())) as renderer:
        for name, colour, shape in THINGS:
            asked = seen = shaped = 0
            errors, took_ms = [], []
            while asked < places:
                if (view := put(world, name, chance)) is None:
                    continue
                asked += 1
                jpeg = picture(world, renderer)
                began = time.perf_counter()
                every = seen_in(jpeg, detector, FOV_OF_MODEL_DEG["go2"])
                found = [one for one in every if one.colour == colour]
                took_ms.append((time.perf_counter() - began) * 1e3)
                if found:
                    nearest = min(found, key=lambda one: abs(one.left_deg - view))
                    seen, shaped = seen + 1, shaped + (nearest.thing == shape)
                    errors.append(abs(nearest.left_deg - view))
            print(
                f"{name}: seen from {seen} of {asked} places, as a {shape} from {shaped}; error of the angle "
                f"{np.median(errors):.1f}°, {np.percentile(errors, 95):.1f}° at 95 %; {np.median(took_ms):.0f} ms each"
            )


def put(world: World, name: str, chance: Any) -> float | None:
    """Put the Go2 at a random place and return the true angle to the thing from its camera; None outside the room."""
    model, data = world.model, world.data
    thing = data.geom_xpos[model.geom(name).id].copy()
    away_m, around = chance.uniform(0.8, FARTHEST_M), chance.uniform(-math.pi, math.pi)
    x, y = thing[0] + away_m * math.cos(around), thing[1] + away_m * math.sin(around)
    yaw = math.atan2(thing[1] - y, thing[0] - x) + chance.uniform(-ASIDE_RAD, ASIDE_RAD)
    if abs(x) > ROOM_M[0] or abs(y) > ROOM_M[1]:
        return None
    free = next(i for i in range(model.njnt) if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_FREE)
    at = int(model.jnt_qposadr[free])
    data.qpos[at : at + 2] = x, y
    data.qpos[at + 3 : at + 7] = math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)
    mujoco.mj_forward(model, data)
    camera = model.camera("go2/front").id
    axes, aside = data.cam_xmat[camera].reshape(3, 3), thing - data.cam_xpos[camera]
    return math.degrees(math.atan2(-float(aside @ axes[:, 0]), -float(aside @ axes[:, 2])))


def picture(world: World, renderer: Any) -> bytes:
    pose = np.concatenate([world.data.qpos, world.data.mocap_pos.ravel()])
    out = io.BytesIO()
    Image.fromarray(renderer.draw(front_view(world.model, "go2"), pose)).save(out, "JPEG", quality=85)
    return out.getvalue()


if __name__ == "__main__":
    main()
