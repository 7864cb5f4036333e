"""Whether a body advances, from its recent poses, of which some may be missing."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from agentrob.model import Pose
from agentrob.robots.unitree.robot import is_advancing


def turning(times_s: Sequence[float], rate_rps: float = 0.7, jump_s: float | None = None) -> bool | None:
    """Poses of a body that turns, at these times; before `jump_s` its odometry was elsewhere."""
    poses = (Pose(0.0 if jump_s is None or at_s >= jump_s else 9.0, 0.0, rate_rps * at_s) for at_s in times_s)
    return is_advancing(tuple(zip(times_s, poses, strict=True)))


def every(step_s: float, begin_s: float, end_s: float) -> list[float]:
    return [begin_s + step_s * i for i in range(round((end_s - begin_s) / step_s) + 1)]


def test_a_body_that_turns_advances_and_one_that_stands_does_not() -> None:
    assert turning(every(0.02, 0.0, 1.0)) is True
    assert turning(every(0.02, 0.0, 1.0), rate_rps=0.0) is False


@pytest.mark.parametrize("gap_s", [0.25, 0.32, 0.45, 0.7])
def test_a_time_without_poses_hides_no_turn(gap_s: float) -> None:
    """On a busy machine no pose may come for a moment: then an older one is compared with the newest."""
    times_s = [0.0, 0.02, *every(0.02, 0.02 + gap_s, 0.3 + gap_s)]
    assert turning(times_s) is True
    assert turning(times_s, rate_rps=0.0) is False


def test_too_few_poses_tell_nothing() -> None:
    assert turning([]) is None
    assert turning(every(0.02, 0.0, 0.2)) is None
    assert turning(every(0.02, 0.0, 1.0), jump_s=0.85) is None, "nor do those from before a jump"
