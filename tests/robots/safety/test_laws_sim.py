"""Laws 8 to 12 under physical force: a Go2 in full physics, real DDS, a real driver process, and the room's ground
truth.

The guard sees only what the robot reports on DDS; the tests check where the robot really was.
"""

from __future__ import annotations

import asyncio
import json
import signal
import subprocess
import time

import pytest

from agentrob.model import Direction, Op, Outcome, Primitive
from agentrob.robots.driver.client import DriverClient
from tests.robots.sim_scene import FENCE, SimScene, apart_m
from tests.robots.sim_steps import FAR, NEAR, REST_LIMIT_S, UNMOVED_M, LeasedStep, refused

pytestmark = pytest.mark.sim


# ------------------------------------------------------------------ law 8
async def test_law_8_a_way_out_of_the_fence_is_not_begun_whatever_the_heading(
    place: SimScene, robot: DriverClient
) -> None:
    await refused(place, robot, Primitive(Op.MOVE, Direction.FORWARD, distance_m=FENCE["x_max_m"]), "fence")
    await refused(place, robot, Primitive(Op.MOVE, Direction.LEFT, distance_m=0.3), "fence")
    async with LeasedStep(place, robot, Primitive(Op.TURN, Direction.LEFT, degrees=30)) as turn:
        assert (await turn.result()).ok
    assert abs(place.truth.now.yaw_deg - 30) < 6
    result = await refused(place, robot, Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0), "fence")
    assert "y -1 to 0.2 m" in result.message


async def test_law_8_a_robot_that_finds_itself_leaving_its_fence_on_the_way_is_stopped(
    place: SimScene, robot: DriverClient
) -> None:
    async with LeasedStep(place, robot) as walk:
        await walk.under_way()
        at_s = place.faults(jump_m=[0.0, 0.24])  # less than a jump, but beyond the fence
        result = await walk.result()
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "fence"), result.message
    assert await place.truth.rest(at_s) < REST_LIMIT_S


async def test_law_8_an_obstacle_that_appears_ends_the_step_before_it_is_touched(
    place: SimScene, robot: DriverClient
) -> None:
    async with LeasedStep(place, robot) as walk:
        now = await walk.under_way()
        near_face_m = now.x_m + 1.2
        at_s = place.faults(box_m=[near_face_m + 0.2, now.y_m])
        result = await walk.result()
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "obstacle"), result.message
    await place.truth.rest(at_s)
    assert all(sample.contacts == () for sample in place.truth.since(at_s))
    assert 0.1 < near_face_m - (place.truth.now.x_m + 0.35) < 0.75, "it stands before the box, not long before"
    await refused(place, robot, NEAR, "obstacle")


async def test_law_8_the_deadline_ends_a_step(place: SimScene, robot: DriverClient) -> None:
    began_s = time.monotonic()
    async with LeasedStep(place, robot, Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0), deadline_s=2.2) as walk:
        await walk.under_way(0.2)
        result = await walk.result()
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "deadline"), result.message
    assert await place.truth.rest(began_s + 2.2) < REST_LIMIT_S
    assert apart_m(place.truth.now, walk.start) == pytest.approx(result.measured["distance_m"], abs=0.08)


async def test_law_8_a_robot_that_walks_on_but_falls_silent_is_stopped(place: SimScene, robot: DriverClient) -> None:
    async with LeasedStep(place, robot) as walk:
        await walk.under_way()
        at_s = place.faults(silent=True)
        result = await walk.result()
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stale_state"), result.message
    assert await place.truth.rest(at_s) < 0.5 + REST_LIMIT_S
    assert apart_m(place.truth.now, walk.start) < 1.5
    await refused(place, robot, NEAR, "stale_state")


async def test_law_8_without_range_readings_that_live_nothing_moves(place: SimScene, robot: DriverClient) -> None:
    for ranges in ("missing", "zero", "constant"):
        begun = place.truth.now
        place.faults(ranges=ranges)
        await place.truth.until(lambda now, begun=begun: now.time_s > begun.time_s + 1.3)  # a second of them was seen
        await refused(place, robot, FAR, "ranges_unknown")


@pytest.mark.parametrize("ranges", ["missing", "constant"])
async def test_law_8_range_readings_that_die_on_the_way_end_the_step(
    place: SimScene, robot: DriverClient, ranges: str
) -> None:
    async with LeasedStep(place, robot) as walk:
        await walk.under_way()
        at_s = place.faults(ranges=ranges)
        result = await walk.result()
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "ranges_unknown"), result.message
    assert await place.truth.rest(at_s) < 1.0 + REST_LIMIT_S
    assert apart_m(place.truth.now, walk.start) < 1.6


# ------------------------------------------------------------------ laws 9 and 10
async def test_law_9_an_odometry_that_jumps_ends_the_step_and_nothing_moves_until_it_is_homed_again(
    place: SimScene, robot: DriverClient
) -> None:
    async with LeasedStep(place, robot) as walk:
        await walk.under_way()
        at_s = place.faults(jump_m=[-1.0, 0.0])
        result = await walk.result()
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "odometry_jump"), result.message
    assert await place.truth.rest(at_s) < REST_LIMIT_S
    await refused(place, robot, NEAR, "not_homed")
    await place.home(robot)
    async with LeasedStep(place, robot, NEAR) as again:
        assert (await again.result()).ok


async def test_law_10_beyond_a_limit_nothing_moves_and_within_it_is_really_kept(
    place: SimScene, robot: DriverClient
) -> None:
    too_far = Primitive(Op.MOVE, Direction.FORWARD, distance_m=5.1)
    too_fast = Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0, speed_mps=0.6)
    too_round = Primitive(Op.TURN, Direction.LEFT, degrees=361)
    for primitive, limit in ((too_far, "step_m"), (too_fast, "speed_mps"), (too_round, "step_deg")):
        await refused(place, robot, primitive, f"limit_{limit}")
    async with LeasedStep(place, robot, Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0)) as walk:
        assert (await walk.result()).ok
        ended = place.truth.now
    assert apart_m(ended, walk.start) == pytest.approx(1.0, abs=0.08)
    assert 1.0 / (ended.time_s - walk.start.time_s) < 0.5
    assert max(place.truth.speeds_mps(walk.start.at_s)) < 0.56, "over half a second; it sways by some centimetres"


async def test_law_10_a_flip_is_refused_where_something_is_near_and_its_result_says_that_it_was_played(
    place: SimScene, robot: DriverClient
) -> None:
    flip, now = Primitive(Op.BACKFLIP), place.truth.now
    place.faults(box_m=[now.x_m + 0.9, now.y_m])
    refusal = await refused(place, robot, flip, "obstacle")
    assert "surroundings" in refusal.message
    place.faults()
    async with robot.lease("walker") as lease:
        result = await robot.step(lease, flip, 30)
    assert (result.outcome, result.animated) == (Outcome.DONE, True), result.message
    assert max(sample.z_m for sample in place.truth.since(now.at_s)) > 0.5
    state = await robot.state()
    assert (state.halted, state.homed, state.upright) == (False, True, True)


# ------------------------------------------------------------------ law 11
async def test_law_11_a_holder_that_falls_silent_for_a_second_stops_the_robot(
    place: SimScene, robot: DriverClient
) -> None:
    start, began_s = place.truth.now, time.monotonic()
    lease = str((await robot._call("POST", "/lease", {"holder": "silent"}))["lease"])  # and never renews it
    result = await robot.step(lease, FAR, 30)
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "lease_lapsed"), result.message
    assert await place.truth.rest(began_s + 1.0) < REST_LIMIT_S
    assert UNMOVED_M < apart_m(place.truth.now, start) < 1.0


async def test_law_11_a_second_driver_of_the_robot_is_refused_and_does_not_disturb_the_first(
    place: SimScene, robot: DriverClient
) -> None:
    second = place.new_driver("another", errors=subprocess.PIPE)
    try:
        async with LeasedStep(place, robot, Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.8)) as walk:
            await walk.under_way(0.2)
            await asyncio.to_thread(second.warm)
            out, err = await asyncio.to_thread(second.process.communicate, "\n", 30)
            assert (await walk.result()).ok
        assert second.process.returncode == 1
        assert (out, err.count("\n")) == ("", 1)
        assert "already held" in err
        assert apart_m(place.truth.now, walk.start) == pytest.approx(0.8, abs=0.08)
    finally:
        second.end()


# ------------------------------------------------------------------ law 12
@pytest.mark.parametrize(("call", "mode"), [("Damp", "damping"), ("StandDown", "lying")])
async def test_law_12_a_mode_that_somebody_else_commands_under_a_step_is_a_halt(
    place: SimScene, robot: DriverClient, call: str, mode: str
) -> None:
    async with LeasedStep(place, robot) as walk:
        await walk.under_way()
        await asyncio.to_thread(place.remote.ask, call)
        result = await walk.result()
    assert result.outcome is Outcome.STOPPED
    assert result.reason in ("halted", "stop")  # whether the step or the observer saw it first
    state = await robot.state()
    assert (state.halted, state.mode) == (True, mode)
    down = await place.truth.until(lambda now: now.z_m < 0.2)
    await refused(place, robot, NEAR, "halted")
    await refused(place, robot, Primitive(Op.STAND), "halted")
    assert place.truth.now.z_m < 0.2, "nobody of us stood it up"
    assert apart_m(place.truth.now, down) < 0.2


async def test_law_12_a_robot_that_somebody_else_walks_is_a_halt_and_stays_in_his_hand(
    place: SimScene, robot: DriverClient
) -> None:
    place.remote.ask("drive 0.4 0.8")  # in a circle
    try:
        while not (await robot.state()).halted:
            await place.truth.until(lambda _: True)
        halted = place.truth.now
        await place.truth.until(lambda now: now.time_s > halted.time_s + 0.8)  # the driver's own stop is over
        moving = place.truth.now
        await place.truth.until(lambda now: apart_m(now, moving) > 0.2)
    finally:
        place.remote.ask("StopMove")
    await place.truth.rest(time.monotonic())
    result = await refused(place, robot, NEAR, "halted")
    assert "did not command" in result.message


async def test_law_12_a_driver_killed_in_mid_walk_and_started_at_once_stops_the_robot_and_goes_on(
    place: SimScene, robot: DriverClient
) -> None:
    place.successor = place.new_driver()
    await asyncio.to_thread(place.successor.warm)
    assert place.driver is not None
    async with LeasedStep(place, robot) as walk:
        await walk.under_way()
        place.driver.process.send_signal(signal.SIGKILL)
        killed_s = time.monotonic()
        place.driver.process.wait()
        place.driver, place.successor = place.successor, None
        ready = json.loads(await asyncio.to_thread(place.driver.ask, ""))
    assert ready["ready"] == "driver"
    await place.truth.rest(killed_s)
    assert await place.truth.distance_after_m(killed_s, 1.5) < 0.05, "it walked on"
    async with place.client() as again:
        assert not (await again.state()).halted
        await place.begin(again)
        async with LeasedStep(place, again, NEAR) as walk:
            result = await walk.result()
    assert result.ok, (result.outcome, result.reason, result.message)


# ------------------------------------------------------------------ another owner's settings: last, they cost a driver
async def test_law_8_unknown_ranges_with_the_owners_consent_mean_really_slow(place: SimScene) -> None:
    place.drive(allow_unknown_ranges=True)
    async with place.client() as robot:
        start = await place.begin(robot)
        place.faults(ranges="missing")
        await place.truth.until(lambda now: now.time_s > start.time_s + 1.5)
        began_s = time.monotonic()
        async with LeasedStep(place, robot, Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.4)) as walk:
            result = await walk.result()
    assert result.ok, result.message
    assert "0.2 m/s" in result.message
    assert 0.1 < max(place.truth.speeds_mps(began_s)) < 0.26
    assert apart_m(place.truth.now, walk.start) == pytest.approx(0.4, abs=0.08)
