"""The known surroundings of one robot: its owner's description, and a model's last observation (law 7).

It can only make the screen refuse more: a wrong description prevents a motion and never starts one.
"""

from __future__ import annotations

import time

from agentrob.minds.visual_loop.loop import LoopRecord
from agentrob.model import ActionResult, Op

#: What a model named is forgotten after this time, and with the next motion: it was seen from where the robot stood.
SEEN_S = 600.0


class Surroundings:
    """`written` is the description of the configuration, in English."""

    def __init__(self, written: str) -> None:
        self._written = written.strip()
        self._seen: tuple[str, ...] = ()
        self._seen_s = 0.0

    @property
    def scene(self) -> str:
        """Everything known now; empty if nothing is."""
        seen = self._seen if time.monotonic() - self._seen_s < SEEN_S else ()
        return "\n".join(line for line in (self._written, *seen) if line)

    def after(self, results: tuple[ActionResult, ...], looked: LoopRecord | None) -> None:
        """Update after a command: keep what a model saw at its end, and forget what was seen before a motion."""
        if looked is not None and looked.end.saw:
            self._seen, self._seen_s = looked.end.saw, time.monotonic()
        elif any(r.primitive.op in (Op.MOVE, Op.TURN) and (r.measured or r.unmeasured) for r in results):
            self._seen = ()
