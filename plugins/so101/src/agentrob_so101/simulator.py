"""The simulation of an SO-101 arm in a process of its own: its world in real time, and the socket of its driver.

agentrob simulator so101 --domain 42
"""

from __future__ import annotations

import base64
import contextlib
import json
import logging
import socket
import threading
import time
from typing import TYPE_CHECKING, Any

from agentrob.config.map import MapConfig, MapThing
from agentrob.config.robots import RobotConfig
from agentrob.errors import SimError
from agentrob.process.child import print_ready
from agentrob.process.host_lock import HostLock
from agentrob_so101.picking import CUBE_M, PICTURE_PX
from agentrob_so101.simulated import LONGEST_LINE, PICTURE_S, address

if TYPE_CHECKING:
    from agentrob_so101.world import World

log = logging.getLogger(__name__)

TICK_S = 0.01
#: After a pause of the process the world skips what it missed beyond this.
SKIP_S = 0.1
#: The renderer is opened within this time; after it, without its first picture.
READY_S = 30.0

#: What stands in the world, in words and on the map.
SCENE = "An arm on a table of 80 cm by 100 cm, which it cannot leave. A red cube of 3 cm lies on the table before it."
NEEDS = "a simulated SO-101 needs the simulator: pip install 'agentrob-so101[sim]'"


class Simulation:
    """The world in a thread, and its socket; until `close`."""

    def __init__(self, interface: str, domain: int) -> None:
        from agentrob.sim.rendering.cameras import Cameras
        from agentrob.sim.rendering.view import View
        from agentrob_so101.world import ARM_GROUP, ROOM_GROUP, World

        self.world: World = World()
        self._lock, self._ended = threading.Lock(), threading.Event()
        view = View(*PICTURE_PX, (ROOM_GROUP, ARM_GROUP), _fixed_camera(self.world.model, "table"))
        self._cameras = Cameras(self.world.model, {"table": view}, self._drawn)
        self._cameras.ready.wait(READY_S)  # opening a renderer would delay the world while a driver already looks
        self._socket = HostLock(address(interface, domain), f"the simulated SO-101 on domain {domain} ({interface})")
        self._threads = [
            threading.Thread(target=run, name=name, daemon=True)
            for name, run in (("so101 world", self._run), ("so101 socket", self._accept))
        ]
        for thread in self._threads:
            thread.start()

    def apply(self, what: dict[str, Any]) -> dict[str, Any]:
        """See `World.apply`."""
        with self._lock:
            return self.world.apply(what)

    def close(self) -> None:
        self._ended.set()
        self._socket.close()
        for thread in self._threads:
            thread.join(2.0)
        self._cameras.close()

    def _drawn(self) -> Any:
        with self._lock:
            return self.world.drawn()

    def _run(self) -> None:
        last_s = time.monotonic()
        while not self._ended.wait(TICK_S):
            now_s = time.monotonic()
            with self._lock:
                self.world.advance(min(now_s - last_s, SKIP_S))
            last_s = now_s

    def _accept(self) -> None:
        while not self._ended.is_set():
            try:
                connection, _ = self._socket.socket.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection: socket.socket) -> None:
        with contextlib.suppress(OSError), connection, connection.makefile("rwb") as lines:
            while line := lines.readline(LONGEST_LINE):
                try:
                    answer = self._answer(json.loads(line))
                except TimeoutError:
                    continue  # silence is its answer
                except (KeyError, TypeError, ValueError, AttributeError) as e:
                    answer = {"error": str(e) or type(e).__name__}
                lines.write(json.dumps(answer).encode() + b"\n")
                lines.flush()

    def _answer(self, request: dict[str, Any]) -> dict[str, Any]:
        if request["do"] == "picture":
            jpeg = self._cameras.jpeg("table", PICTURE_S - 1.0)
            if jpeg is None:
                raise ValueError(f"the picture could not be rendered: {self._cameras.last_error or 'it took too long'}")
            return {"jpeg": base64.b64encode(jpeg).decode()}
        with self._lock:
            if request["do"] == "observe":
                return dict(self.world.observe())
            if request["do"] == "act":
                return dict(self.world.act(request["action"]))
            if request["do"] == "apply":
                return self.world.apply(request["what"])
        raise ValueError(f"{request['do']!r} is not known; valid: act, apply, observe, picture")


def _fixed_camera(model: Any, name: str) -> Any:
    import mujoco

    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
    camera.fixedcamid = model.camera(name).id
    return camera


class So101Simulator:
    """See `agentrob.robots.protocol.Simulator`: for the demo, and for `agentrob drive so101`."""

    def settings(self, settings: RobotConfig) -> RobotConfig:
        """The given settings, with the map and the description of its table."""
        try:
            from agentrob_so101.world import CUBE_AT_M, TABLE_AT_M, TABLE_M
        except ModuleNotFoundError as e:
            raise SimError(f"{NEEDS} (it lacks {e.name})") from None
        things = (
            MapThing(name="table", at_m=TABLE_AT_M, size_m=TABLE_M, colour="#b88756"),
            MapThing(name="red cube", at_m=CUBE_AT_M, size_m=(CUBE_M, CUBE_M), colour="#d41a1a"),
        )
        room = MapConfig(room="so101 table", size_m=(1.6, 1.6), things=things, geometry="none")
        return settings.model_copy(update={"map": room, "scene": SCENE})

    def serve(self, settings: RobotConfig, ended: threading.Event) -> None:
        simulation = Simulation(settings.interface, settings.domain)
        try:
            print_ready(domain=settings.domain, interface=settings.interface)
            ended.wait()
        finally:
            simulation.close()
