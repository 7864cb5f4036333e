"""The scene with a simulated Go2 on DDS: the world may be killed too, and its ledger stays on disk."""

from __future__ import annotations

from pathlib import Path

from agentrob.config.robots import RobotConfig
from agentrob.sim.domains import PrivateDomain
from tests.kill.kill_process import KillableProcess, agentrob
from tests.kill.kill_scene import KillScene


class SimScene(KillScene):
    """`born` is the length of the ledger when the current world was started."""

    def __init__(self, folder: Path) -> None:
        self._own = PrivateDomain()  # as long as this object exists
        self.domain = self._own.number
        self.born = 0
        super().__init__(folder)
        self.running["world"] = self.world

    def close(self) -> None:
        super().close()
        self._own.close()

    def start_world(self) -> KillableProcess:
        words = "sim", "--domain", f"go2={self.domain}", "--ledger", str(self.ledger_path)
        return KillableProcess(agentrob, words, self.folder / "plugins", log=self.folder / "world.log").ready()

    def robot(self) -> RobotConfig:
        return RobotConfig(domain=self.domain, simulated=True, home_on_start=True)

    def start(self, kind: str, **env: str) -> None:
        if kind == "world":
            self.born = len(self.ledger())
            self.world = self.running["world"] = self.start_world()
        else:
            super().start(kind, **env)

    def moves(self, since: int) -> bool:
        """Return the motions in the current world only, because nothing moves in a killed world."""
        changes = [e["event"] for e in self.ledger(max(since, self.born)) if e["event"] in ("move_begin", "move_end")]
        return bool(changes) and changes[-1] == "move_begin"

    def begun(self, since: int) -> int:
        return sum(e["event"] == "move_begin" for e in self.ledger(since))
