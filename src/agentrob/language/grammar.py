"""From the visible text of a post to what one robot is asked to do, in English or Chinese, without any model."""

from __future__ import annotations

from collections.abc import Sequence

from agentrob.language.stop import stop_intent
from agentrob.model import Intent, Op, Understanding


def parse(visible: str, names: Sequence[str], others: Sequence[str], ops: frozenset[Op]) -> Understanding:
    """Read the part of `visible` that is for the robot called `names`."""
    if stop := stop_intent(visible):
        return Understanding(stop)
    return Understanding(Intent.NOTHING)
