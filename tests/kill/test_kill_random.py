"""Law 6 by chance: agent, driver and board die by SIGKILL at random moments, many times over.

`AGENTROB_KILLS` is how many kills (200), `AGENTROB_KILL_SEED` repeats a run.
"""

from __future__ import annotations

import random
import time
from collections import Counter

import pytest
from kill_house import DRIVER_AWAY, DRIVER_DIED, PHOTO, WALK, House, check
from kill_process import wait_for

from agentrob import demo

#: From the post on; a command that is left alone takes 1.5 s.
LATEST_S = 1.7
STATES = {
    "agent": {"done", "interrupted"},
    # It may also be away when the command is asked again whether it holds, which cancels it before it moved.
    "driver": {"done", "cancelled"} | DRIVER_AWAY | DRIVER_DIED,
    "board": {"done", "interrupted", "cancelled"},
}


@pytest.mark.slow
@pytest.mark.timeout(1500)
def test_law_6_killed_at_random(house: House, kills: int, seed: int) -> None:
    chance = random.Random(seed)
    ends: Counter[str] = Counter()
    began_s = time.monotonic()
    for number in range(kills):
        kind, delay_s = chance.choice(house.kinds), chance.uniform(0.0, LATEST_S)
        text = chance.choice((WALK, PHOTO))
        where = f"seed {seed}, kill {number}: {kind} after {delay_s:.3f} s of {text!r}"
        asked = house.ask(text)
        at_s = time.monotonic() + delay_s
        wait_for("the moment", lambda at_s=at_s: time.monotonic() >= at_s, LATEST_S + 1.0)
        house.running[kind].kill()
        house.start(kind)
        state = check(house, asked)
        house.release()
        assert state in STATES[kind] <= demo.FINAL, f"{where}: {house.answers(asked)[0]['raw']}"
        ends[f"{kind} {state}"] += 1
    print(f"seed {seed}: {kills} kills in {time.monotonic() - began_s:.0f} s: {dict(sorted(ends.items()))}")  # noqa: T201
    assert sum(ends.values()) == kills
