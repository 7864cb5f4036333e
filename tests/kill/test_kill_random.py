"""Law 6 under random kills: agent, driver and board die by SIGKILL at random moments, one or several in one command,
many times over.

`AGENTROB_KILLS` is the number of kills, `AGENTROB_KILL_SEED` repeats a run.
"""

from __future__ import annotations

import random
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import pytest

from agentrob.model.lifecycle import FINAL_STATES
from tests.kill.kill_process import wait_for
from tests.kill.kill_scene import DRIVER_AWAY, DRIVER_DIED, PHOTO, WALK, KillScene, check

#: Counted from the post; an undisturbed command takes 1.5 s.
LATEST_S = 1.7
STATES = {
    "agent": {"done", "interrupted"},
    # It may also be down when the command is verified, which cancels the command before any motion.
    "driver": {"done", "cancelled"} | DRIVER_AWAY | DRIVER_DIED,
    "board": {"done", "interrupted", "cancelled"},
}


@dataclass(frozen=True)
class RandomKill:
    kind: str
    after_s: float


def draw_kills(chance: random.Random, kinds: Sequence[str], most: int) -> list[RandomKill]:
    """The processes that die during one command, one to all of them, in the order of their deaths."""
    who = chance.sample(kinds, min(most, chance.randint(1, len(kinds))))
    return sorted(
        (RandomKill(kind, chance.uniform(0.0, LATEST_S)) for kind in who), key=lambda planned_kill: planned_kill.after_s
    )


def carry_out_kills(scene: KillScene, planned: Sequence[RandomKill]) -> None:
    """Kill each process at its time and restart it at once, concurrently."""
    began_s = time.monotonic()
    for planned_kill in planned:
        at_s = began_s + planned_kill.after_s
        wait_for("the moment", lambda at_s=at_s: time.monotonic() >= at_s, LATEST_S + 1.0)
        scene.running[planned_kill.kind].kill()
        scene.begin(planned_kill.kind)
    for planned_kill in planned:
        scene.running[planned_kill.kind].ready()


@pytest.mark.slow
@pytest.mark.timeout(1500)
def test_law_6_killed_at_random(scene: KillScene, kills: int, seed: int) -> None:
    chance = random.Random(seed)
    ends: Counter[str] = Counter()
    began_s, killed = time.monotonic(), 0
    while killed < kills:
        planned = draw_kills(chance, scene.kinds, kills - killed)
        text = chance.choice((WALK, PHOTO))
        said = ", ".join(f"{planned_kill.kind} after {planned_kill.after_s:.3f} s" for planned_kill in planned)
        where = f"seed {seed}, kill {killed}: {said} of {text!r}"
        command = scene.ask(text)
        carry_out_kills(scene, planned)
        state = check(scene, command)
        scene.release()
        may = set[str]().union(*(STATES[planned_kill.kind] for planned_kill in planned))
        assert state in may <= FINAL_STATES, f"{where}: {scene.answers(command)[0]['raw']}"
        killed += len(planned)
        ends[f"{' and '.join(sorted(planned_kill.kind for planned_kill in planned))}: {state}"] += 1
    print(f"seed {seed}: {killed} kills in {time.monotonic() - began_s:.0f} s: {dict(sorted(ends.items()))}")  # noqa: T201
    assert killed == kills
