"""Every motion, from wherever it begins, stays inside the bounds and the speeds; what is beyond is refused."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from agentrob_reachy_mini import motions
from agentrob_reachy_mini.daemon import Daemon
from agentrob_reachy_mini.motions import MOTIONS, motion_of
from agentrob_reachy_mini.operations import DECLARED
from agentrob_reachy_mini.pose import (
    BODY_YAW_DEG,
    HEAD_YAW_DEG,
    PEAK,
    BodyPose,
    OutOfReach,
    Speeds,
    checked,
    implausible,
    within,
)  # fmt: skip
from hypothesis import given
from hypothesis import strategies as st

from agentrob.language.messages.plan_text import example_of
from agentrob.model import Direction, Op, Operation, Primitive

SPEEDS = Speeds(90.0, 45.0, 180.0)
#: A pose that the robot can have, also asleep or bent by hand.
POSES = st.builds(
    BodyPose, st.floats(-3.2, 3.2), st.floats(-0.8, 0.8), st.floats(-0.8, 0.8), st.floats(-2.79, 2.79),
    st.floats(-3.1, 3.1), st.floats(-3.1, 3.1), st.floats(-0.05, 0.05),
)  # fmt: skip
GESTURES = [operation for operation in DECLARED if operation.name != Op.TURN]


def test_every_operation_has_a_motion() -> None:
    assert {operation.name for operation in DECLARED} == set(MOTIONS)


@given(pose=POSES, operation=st.sampled_from(GESTURES), head_dps=st.floats(10, 180), antennas_dps=st.floats(10, 360))
def test_every_gesture_keeps_bounds_and_speeds_from_wherever_it_begins(
    pose: BodyPose, operation: Operation, head_dps: float, antennas_dps: float
) -> None:
    speeds = Speeds(head_dps, 45.0, antennas_dps)
    motion = motion_of(example_of(operation), pose, speeds)
    poses = [within(pose), *(frame.pose for frame in motion.frames)]
    for before, frame in zip(poses, motion.frames, strict=False):
        assert checked(frame.pose) == frame.pose
        for axis, most_dps in ((0, head_dps), (1, head_dps), (2, head_dps), (4, antennas_dps), (5, antennas_dps)):
            peak_dps = PEAK * math.degrees(abs(frame.pose[axis] - before[axis])) / frame.seconds
            assert peak_dps <= most_dps * 1.01
        assert frame.pose.body_yaw == poses[0].body_yaw


@given(pose=POSES, degrees=st.floats(1, 150), direction=st.sampled_from([Direction.LEFT, Direction.RIGHT]))
def test_a_turn_takes_the_head_along_or_is_refused(pose: BodyPose, degrees: float, direction: Direction) -> None:
    start, step = within(pose), Primitive(Op.TURN, direction, degrees=degrees)
    sign = 1 if direction is Direction.LEFT else -1
    wanted = start.body_yaw + sign * math.radians(degrees)
    if abs(math.degrees(wanted)) > BODY_YAW_DEG + 0.02:
        with pytest.raises(OutOfReach, match="turn of its body would be"):
            motion_of(step, pose, SPEEDS)
        return
    (frame,) = motion_of(step, pose, SPEEDS).frames
    assert frame.pose.body_yaw == pytest.approx(wanted)
    assert frame.pose.neck_yaw == pytest.approx(start.neck_yaw, abs=1e-9)
    assert abs(math.degrees(frame.pose.neck_yaw)) <= HEAD_YAW_DEG + 0.02
    assert PEAK * degrees / frame.seconds <= 45.0 * 1.01


@pytest.mark.parametrize(
    ("pose", "words"),
    [
        (BodyPose(pitch=30.0), "pitch of its head would be 1719°; it may be from -35° to 35°"),
        (BodyPose(body_yaw=90.0, head_yaw=90.0), "turn of its body would be"),
        (BodyPose(head_yaw=1.2), "turn of its head against its body would be 69°"),
        (BodyPose(roll=math.nan), "roll of its head would be nan°"),
        (BodyPose(left_antenna=45.0), "angle of its left antenna"),
        (BodyPose(head_up_m=10.0), "Its head would be 10 m high"),
    ],
)
def test_what_is_beyond_the_bounds_is_never_sent(pose: BodyPose, words: str) -> None:
    daemon = Daemon("http://127.0.0.1:9")  # nobody listens: it would be another error
    with pytest.raises(OutOfReach) as error:
        daemon.goto(pose, 1.0)
    daemon.close()
    assert words in str(error.value)


def test_degrees_that_are_told_for_radians_are_named() -> None:
    assert implausible(BodyPose(body_yaw=30.0)) == (
        "Its daemon says that the body yaw is 30 rad: are these degrees? They must be radians."
    )
    assert "head pitch" in implausible(BodyPose(pitch=20.0))
    assert "left antenna" in implausible(BodyPose(left_antenna=math.nan))
    assert implausible(BodyPose(2.9, 0.4, 0.1, 2.7, -3.05, 3.05)) == ""


@pytest.mark.parametrize("seconds", [3.0, 6.0, 20.0])
def test_a_dance_takes_the_seconds_that_were_asked(seconds: float) -> None:
    for name in (motions.SWAY, motions.GROOVE):
        motion = motion_of(Primitive(name, arguments=(("seconds", seconds),)), BodyPose(), SPEEDS)
        assert motion.seconds == pytest.approx(seconds)
        assert all(a.pose != b.pose for a, b in pairwise(motion.frames))
