"""Every fault in docs/safety/faults.md without a test of a law: a Go2 in full physics, real DDS, and a driver.

The room injects the fault; the test checks the step's result and where the robot really was.
"""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from agentrob.model import Op, Outcome, Primitive
from agentrob.robots.driver.client import DriverClient
from tests.robots.sim_scene import SimScene, apart_m
from tests.robots.sim_steps import METRE, NEAR, REST_LIMIT_S, LeasedStep, assert_movable, do, refused
from tests.waiting import until

pytestmark = pytest.mark.sim

PHOTO, STAND, HELLO = Primitive(Op.GET_FRONT_IMAGE), Primitive(Op.STAND), Primitive(Op.HELLO)


def world_on(domain: int, *options: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "agentrob.sim.server", "--domain", str(domain), *options]
    return subprocess.Popen(command, stdout=subprocess.PIPE, env={**os.environ, "MUJOCO_GL": "off"})


# ------------------------------------------------------------------ commands
async def test_a_frozen_robot_is_reported_as_stalled(place: SimScene, robot: DriverClient) -> None:
    place.faults(drops=1.0)
    async with LeasedStep(place, robot) as walk:
        result = await walk.result()
    assert (result.outcome, result.reason) == (Outcome.FAILED, "stalled"), result.message
    assert abs(result.measured["distance_m"]) < 0.03
    assert apart_m(place.truth.now, walk.start) < 0.03
    place.faults()
    await assert_movable(robot)


@pytest.mark.slow
async def test_a_robot_that_freezes_on_the_way_is_reported_with_how_far_it_came(
    place: SimScene, robot: DriverClient
) -> None:
    async with LeasedStep(place, robot) as walk:
        await walk.under_way()
        place.faults(drops=1.0)
        result = await walk.result()
    assert (result.outcome, result.reason) == (Outcome.FAILED, "stalled"), result.message
    assert result.measured["distance_m"] == pytest.approx(apart_m(place.truth.now, walk.start), abs=0.05)
    assert apart_m(place.truth.now, walk.start) < 1.3


@pytest.mark.slow
async def test_commands_that_are_lost_do_not_spoil_a_step(place: SimScene, robot: DriverClient) -> None:
    place.faults(drops=0.4)
    async with LeasedStep(place, robot, METRE) as walk:
        result = await walk.result()
    assert result.ok, (result.reason, result.message)
    await place.truth.rest(time.monotonic())
    assert apart_m(place.truth.now, walk.start) == pytest.approx(1.0, abs=0.08)


@pytest.mark.slow
async def test_a_cable_that_is_pulled_ends_the_step_and_the_robot_stops_by_itself(
    place: SimScene, robot: DriverClient
) -> None:
    async with LeasedStep(place, robot) as walk:
        await walk.under_way()
        at_s = place.faults(unplugged=True)
        result = await walk.result()
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stale_state"), result.message
    assert result.measured == {}, "it went on, and nobody saw how far"
    assert "where it came to rest is not known" in result.message
    stopped = await robot.stop("tester")
    assert (stopped.confirmed, "did not confirm" in stopped.message) == (False, True)
    assert await place.truth.rest(at_s) < 1.0 + REST_LIMIT_S, "its own hold of a velocity ends after a second"
    await refused(place, robot, NEAR, "stale_state")
    place.faults()  # plugged in again
    await until(robot.state, lambda state: state.age_s < 0.2)
    await place.truth.rest(time.monotonic())
    await robot.home("owner")  # distance covered unseen may count as a jump of the odometry
    await assert_movable(robot)


# ------------------------------------------------------------------ the body
@pytest.mark.slow
async def test_a_robot_that_is_pushed_off_its_course_is_only_done_where_it_should_be(
    place: SimScene, robot: DriverClient
) -> None:
    async with LeasedStep(place, robot, METRE) as walk:
        await walk.under_way(0.3)
        place.faults(push_mps=[0.0, -1.5])
        result = await walk.result()
    await place.truth.rest(time.monotonic())
    aside_m = max(abs(s.y_m - walk.start.y_m) for s in place.truth.seen if s.at_s >= walk.start.at_s)
    assert aside_m > 0.1, "that was no push"
    end = place.truth.now
    reached = abs(end.x_m - walk.start.x_m - 1.0) < 0.08 and abs(end.y_m - walk.start.y_m) < 0.08
    assert result.ok is reached, (result, end, walk.start)
    assert result.measured["distance_m"] == pytest.approx(end.x_m - walk.start.x_m, abs=0.05)


async def test_law_8_a_robot_that_is_tipped_over_stays_down_until_it_is_asked_to_stand_up(
    place: SimScene, robot: DriverClient
) -> None:
    async with LeasedStep(place, robot) as walk:
        await walk.under_way()
        at_s = place.faults(tip=True)
        result = await walk.result()
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "fallen"), result.message
    assert (await robot.state()).upright is False
    await place.truth.rest(at_s)
    for primitive in (NEAR, HELLO):
        said = await refused(place, robot, primitive, "fallen")
        assert "until it is asked to stand up" in said.message
    lying = place.truth.now
    asked = await do(robot, STAND)  # passed on to the robot; the simulated one cannot
    assert (asked.outcome, asked.reason) == (Outcome.FAILED, "robot_error"), asked.message
    assert "posture" in asked.message
    assert apart_m(place.truth.now, lying) < 0.1
    assert not (await robot.state()).halted, "a fall is no foreign hand"


async def test_law_8_below_the_battery_level_no_motion_begins_and_none_is_left_half_way(
    place: SimScene, robot: DriverClient
) -> None:
    async with LeasedStep(place, robot, METRE) as walk:
        await walk.under_way(0.2)
        place.faults(battery_percent=9)
        await until(robot.state, lambda state: state.battery_percent == 9)
        result = await walk.result()
    assert result.ok, (result.reason, result.message)
    assert "The battery is at 9 %" in result.message
    assert apart_m(place.truth.now, walk.start) == pytest.approx(1.0, abs=0.08)
    said = await refused(place, robot, NEAR, "low_battery")
    assert "9 %, and below 15 %" in said.message
    await refused(place, robot, STAND, "low_battery")
    place.faults()
    await until(robot.state, lambda state: state.battery_percent != 9)  # it is read every two seconds


# ------------------------------------------------------------------ senses
async def test_law_9_an_odometry_that_becomes_no_number_ends_the_step(place: SimScene, robot: DriverClient) -> None:
    async with LeasedStep(place, robot) as walk:
        await walk.under_way()
        at_s = place.faults(lost=True)
        result = await walk.result()
    assert (result.outcome, result.reason) == (Outcome.STOPPED, "stale_state"), result.message
    assert "tells no position" in result.message
    assert await place.truth.rest(at_s) < REST_LIMIT_S
    await refused(place, robot, NEAR, "stale_state")


@pytest.mark.slow
async def test_a_clock_of_the_robot_that_leaps_changes_nothing(place: SimScene, robot: DriverClient) -> None:
    async with LeasedStep(place, robot, METRE) as walk:
        await walk.under_way(0.2)
        place.faults(clock_s=86_400)
        await walk.under_way(0.5)
        place.faults(clock_s=-86_400)
        result = await walk.result()
    assert result.ok, (result.reason, result.message)
    assert apart_m(place.truth.now, walk.start) == pytest.approx(1.0, abs=0.08)


async def test_a_camera_that_is_dead_or_black_gives_no_picture_and_says_why(
    place: SimScene, robot: DriverClient
) -> None:
    place.faults(camera="dead")
    dead = await do(robot, PHOTO)
    assert (dead.outcome, dead.reason, dead.image) == (Outcome.FAILED, "robot_error", None)
    place.faults(camera="black")
    black = await do(robot, PHOTO)
    assert (black.outcome, black.reason) == (Outcome.FAILED, "bad_image")
    assert "all black" in black.message
    place.faults()
    assert (await do(robot, PHOTO)).ok


# ------------------------------------------------------------------ settings
async def test_an_interface_that_is_not_there_is_one_clear_line(place: SimScene) -> None:
    driver = place.new_driver("elsewhere", errors=subprocess.PIPE, interface="nosuch0")
    try:
        await asyncio.to_thread(driver.warm)
        _, err = await asyncio.to_thread(driver.process.communicate, "\n", 30)
        assert driver.process.returncode == 1
        assert "interface 'nosuch0'" in err.splitlines()[-1]
    finally:
        driver.end()


async def test_on_another_domain_there_is_no_robot_and_nothing_is_done(place: SimScene) -> None:
    driver = place.new_driver("elsewhere", domain=place.domain - 90)
    try:
        await asyncio.to_thread(driver.warm)
        await asyncio.to_thread(driver.ask, "")
        async with DriverClient("elsewhere", place.folder / "elsewhere.sock") as robot:
            result = await do(robot, NEAR)
            assert (result.outcome, result.reason) == (Outcome.REFUSED, "stale_state"), result.message
            assert "unknown" in result.message
    finally:
        driver.end()


@pytest.mark.slow
async def test_a_robot_that_appears_later_is_driven_without_a_restart_of_its_driver(place: SimScene) -> None:
    domain = place.domain - 90
    driver, world = place.new_driver("late", domain=domain, home_on_start=True, fence={}), None
    try:
        await asyncio.to_thread(driver.warm)
        await asyncio.to_thread(driver.ask, "")
        async with DriverClient("late", place.folder / "late.sock") as robot:
            assert (await do(robot, NEAR)).reason == "stale_state"
            world = await asyncio.to_thread(world_on, domain)
            await until(robot.state, lambda state: state.age_s < 0.2 and state.homed)
            await assert_movable(robot)
    finally:
        driver.end()
        if world is not None:
            world.terminate()
            world.communicate(timeout=100)


@pytest.mark.slow
async def test_in_a_world_slower_than_life_a_robot_walks_and_waves(place: SimScene) -> None:
    """On a busy machine, by the host's clock, the wave takes longer than a driver waits for the robot's response."""
    domain = place.domain - 90
    driver, world = place.new_driver("slow", domain=domain, home_on_start=True, fence={}), None
    try:
        world = await asyncio.to_thread(world_on, domain, "--pace", "0.45")
        await asyncio.to_thread(driver.warm)
        await asyncio.to_thread(driver.ask, "")
        async with DriverClient("slow", place.folder / "slow.sock") as robot:
            await until(robot.state, lambda state: state.age_s < 0.2 and state.homed)
            began_s = time.monotonic()
            waved = await do(robot, HELLO)
            assert waved.ok, (waved.reason, waved.message)
            assert time.monotonic() - began_s > 15.0, "the world was not slow"
            await assert_movable(robot)
    finally:
        driver.end()
        if world is not None:
            world.terminate()
            world.communicate(timeout=100)


@pytest.mark.slow
def test_a_cable_that_is_really_pulled_ends_the_step_and_plugged_in_again_the_robot_is_driven(tmp_path: Path) -> None:
    """Run in network namespaces (`unshare -rn`) with a pair of virtual interfaces (iproute2)."""
    scene = [sys.executable, "-m", "tests.robots.driver.cable_scene", str(tmp_path)]
    run = subprocess.run(["unshare", "-rn", *scene], capture_output=True, text=True, timeout=100, check=False)
    assert run.returncode == 0, run.stderr
    found = json.loads(run.stdout)
    assert (found["pulled"]["outcome"], found["pulled"]["reason"]) == ("stopped", "stale_state"), found
    assert found["ended_s"] < 5.0, "writing to a network that is down must not hold it up"
    assert (found["confirmed"], found["stop_ms"] < 500) == (False, True), found
    assert (found["unplugged"]["outcome"], found["unplugged"]["reason"]) == ("refused", "stale_state")
    assert found["again"]["outcome"] == "done", found
    noted = [json.loads(line) for line in (tmp_path / "ledger").read_text().splitlines()]
    walk = [n for n in noted if n["event"] in ("move_begin", "move_end")][:2]
    assert [n["event"] for n in walk] == ["move_begin", "move_end"], "it stopped by itself"
    assert walk[1]["pose"]["x_m"] - walk[0]["pose"]["x_m"] < 1.6
