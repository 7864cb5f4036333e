"""Laws 11, 13 and 17 with real processes: one driver per robot, the lease, the stop channel, death and restart."""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
import os
import signal
import socket
import stat
import threading
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from uuid import uuid4

import httpx2
import pytest

from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError, LeaseLost, RobotBusy, RobotError, RobotUnreachable
from agentrob.model import EMERGENCY_STOP, ActionResult, Direction, Op, Outcome, Plan, Pose, Primitive
from agentrob.process import host_lock
from agentrob.robots.driver.api import DriverServer
from agentrob.robots.driver.client import DriverClient, run_plan
from agentrob.robots.driver.driver import Driver
from agentrob.robots.driver.process import listening, make_robot
from agentrob.robots.driver.stop import halt_robot, stop_all, stop_driver
from agentrob.robots.fake import FakeRobot
from agentrob.robots.safety.guard import Guard
from agentrob.robots.safety.lock import Halt
from tests.robots.driver_scene import FAR, NEAR, Drivers, Standing, at_rest, moving, seconds_until
from tests.waiting import until


# ------------------------------------------------------------------ normal operation
async def test_a_plan_is_driven_and_told_step_by_step(drivers: Drivers) -> None:
    name, _ = drivers.start(options={"time_scale": 20})
    plan = Plan((NEAR, Primitive(Op.TURN, Direction.LEFT, degrees=90), Primitive(Op.GET_FRONT_IMAGE)))
    heard: list[ActionResult] = []
    socket_path = drivers.folder / f"{name}.sock"
    results = await asyncio.to_thread(run_plan, name, plan, "script", socket=socket_path, on_result=heard.append)
    assert [r.outcome for r in results] == [Outcome.DONE] * 3
    assert tuple(heard) == results
    assert results[2].image is not None
    assert results[2].image.startswith(b"\xff\xd8")


async def test_after_a_step_that_is_not_done_the_rest_is_skipped(drivers: Drivers) -> None:
    name, _ = drivers.start(options={"time_scale": 20})
    plan = Plan((Primitive(Op.MOVE, Direction.FORWARD, distance_m=50), NEAR))
    results = await asyncio.to_thread(run_plan, name, plan, "script", socket=drivers.folder / f"{name}.sock")
    assert [r.outcome for r in results] == [Outcome.REFUSED, Outcome.SKIPPED]
    assert results[0].reason == "limit_step_m"


async def test_the_posture_is_in_the_frame_of_the_home_and_unknown_without_one(drivers: Drivers) -> None:
    name, _ = drivers.start(options={"time_scale": 20})
    async with drivers.client(name) as robot:
        await until(robot.state, lambda state: state.homed)
        async with robot.lease("walker") as lease:
            assert (await robot.step(lease, NEAR, 60)).ok
            assert (await robot.step(lease, Primitive(Op.TURN, Direction.LEFT, degrees=90), 60)).ok
        seen = await robot.posture()
        assert seen.pose is not None
        assert (seen.pose.x_m, seen.pose.y_m) == pytest.approx((0.3, 0), abs=0.1)
        assert math.degrees(seen.pose.yaw_rad) == pytest.approx(90, abs=5)
        assert (seen.height_m, seen.tilt, seen.joints_rad) == (None, None, ()), "the fake robot has no joints"
    name, _ = drivers.start(home_on_start=False)
    async with drivers.client(name) as robot:
        assert (await robot.posture()).pose is None


async def test_capabilities_and_state_say_what_is(drivers: Drivers) -> None:
    name, _ = drivers.start(limits={"speed_mps": 0.3})
    async with drivers.client(name) as robot:
        capabilities = await robot.capabilities()
        assert (capabilities.model, capabilities.simulated, capabilities.limits.speed_mps) == ("fake", True, 0.3)
        assert Op.MOVE in capabilities.ops
        await until(robot.state, lambda state: state.homed)
        state = await robot.state()
        assert state.pose is not None
        assert state.battery_percent == 87
        assert not state.halted
        assert await robot.holder() is None
        async with robot.lease("somebody"):
            assert await robot.holder() == "somebody"


def test_the_socket_is_only_for_its_user(standing: Standing) -> None:
    drivers, name = standing
    assert stat.S_IMODE((drivers.folder / f"{name}.sock").stat().st_mode) == 0o600


@pytest.mark.parametrize(
    ("path", "body"),
    [
        ("/lease", {}),
        ("/lease", {"holder": ""}),
        ("/step", {"lease": "x", "primitive": {"op": "Dance!"}, "deadline_s": 1}),
        ("/step", {"lease": "x", "primitive": {"op": "move"}, "deadline_s": "soon"}),
        ("/step", {"lease": "x", "primitive": None, "deadline_s": 1}),
        ("/release", {"by": 7}),
    ],
)
async def test_what_cannot_be_read_is_refused_with_the_reason(standing: Standing, path: str, body: Any) -> None:
    drivers, name = standing
    async with drivers.client(name) as robot:
        with pytest.raises(RobotError, match=r"must be|Input should be|not a valid name"):
            await robot._call("POST", path, body)


# ------------------------------------------------------------------ law 11: one driver, one holder
async def test_law_11_a_second_driver_is_refused_in_one_line(standing: Standing) -> None:
    drivers, name = standing
    second = drivers.spawn(name)
    out, err = second.communicate(timeout=100)
    assert second.returncode == 1
    assert out == ""
    assert err.count("\n") == 1
    assert "already held" in err
    async with drivers.client(name) as robot:
        assert (await robot.state()).pose is not None


async def test_law_11_only_the_holder_moves_the_robot(standing: Standing) -> None:
    drivers, name = standing
    async with drivers.client(name) as robot, drivers.client(name) as other:
        for lease in ("", "guessed"):
            with pytest.raises(RobotError):
                await other.step(lease, NEAR, 10)
        async with robot.lease("first") as lease:
            with pytest.raises(RobotBusy, match="first"):
                async with other.lease("second"):
                    pass
            with pytest.raises(LeaseLost):
                await other.step("guessed", NEAR, 10)
        with pytest.raises(LeaseLost):
            await robot.step(lease, NEAR, 10)
        async with other.lease("second"):
            pass


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
async def test_law_11_a_holder_that_dies_or_freezes_stops_the_robot(drivers: Drivers, how: signal.Signals) -> None:
    name, _ = drivers.start(options={"faults": {"stop_s": 0.03}})  # rests at once: the time is the lease's
    holder = drivers.spawn_holder(name)
    async with drivers.client(name) as robot:
        await moving(robot)
        os.kill(holder.pid, how)
        assert await seconds_until(robot, at_rest) <= 1.5
        assert await robot.holder() is None
        async with robot.lease("the next"):
            assert at_rest(await robot.state())


async def test_law_11_a_step_whose_caller_is_gone_ends_without_waiting_for_the_lease(tmp_path: Path) -> None:
    settings = RobotConfig(model="fake", simulated=True, home_on_start=True, options={"room": [-99, 99, -9, 9]})
    driver = Driver("left", Guard(FakeRobot(settings), settings, Halt(tmp_path / "left.halt")))
    driver.leases.ttl_s = 3600.0
    with listening(tmp_path / "left.sock") as listener, DriverServer(driver, listener):
        try:
            async with DriverClient("left", tmp_path / "left.sock") as robot:
                caller = DriverClient("left", tmp_path / "left.sock")
                lease = (await caller._call("POST", "/lease", {"holder": "mortal", "since_s": None}))["lease"]
                step = asyncio.create_task(caller.step(lease, FAR, 60))
                await moving(robot)
                step.cancel()  # its connection is closed, like that of a killed process
                await until(robot.state, at_rest)
                assert await robot.holder() is None
                await caller.close()
        finally:
            driver.close()


def test_law_14_a_release_requested_right_after_a_halt_removes_it(tmp_path: Path) -> None:
    """A client on another host knows only `ended_s` of its halt by the driver's clock."""
    settings = RobotConfig(model="fake", simulated=True, home_on_start=True)
    driver = Driver("left", Guard(FakeRobot(settings), settings, Halt(tmp_path / "left.halt")))
    try:
        ended_s = driver.halt("olga").ended_s
        with pytest.raises(RobotError, match="locked after this release was requested"):
            driver.release("olga", math.nextafter(ended_s, -math.inf))
        assert driver.release("olga", math.nextafter(ended_s, math.inf)) is not None
    finally:
        driver.close()


async def test_law_11_a_step_whose_lease_is_given_back_ends(standing: Standing) -> None:
    drivers, name = standing
    async with drivers.client(name) as robot:
        async with robot.lease("hasty") as lease:
            step = asyncio.create_task(robot.step(lease, FAR, 60))
            await moving(robot)
        result = await step
        assert (result.outcome, result.reason) == (Outcome.STOPPED, "lease_lapsed")


async def test_law_11_one_step_at_a_time(standing: Standing) -> None:
    drivers, name = standing
    async with drivers.client(name) as robot, robot.lease("eager") as lease:
        step = asyncio.create_task(robot.step(lease, FAR, 60))
        await moving(robot)
        with pytest.raises(RobotBusy):
            await robot.step(lease, NEAR, 10)
        await robot.stop("eager")
        assert (await step).outcome is Outcome.STOPPED


# ------------------------------------------------------------------ stop
async def test_law_14_a_stop_ends_the_step_and_the_lease_and_is_measured(standing: Standing) -> None:
    drivers, name = standing
    async with drivers.client(name) as robot, drivers.client(name) as passer_by:
        async with robot.lease("walker") as lease:
            step = asyncio.create_task(robot.step(lease, FAR, 60))
            await moving(robot)
            stopped = await passer_by.stop("passer-by")
            result = await step
            assert (result.outcome, result.reason) == (Outcome.STOPPED, "stop")
            assert "Asked 4 m, measured" in result.message
            assert stopped.confirmed
            assert stopped.was_moving
            assert stopped.latency_ms < 200
            assert stopped.coasted_m is not None
            assert 0 < stopped.coasted_m < 0.3
            with pytest.raises(LeaseLost, match="stop"):  # the remaining commands are ended too
                await robot.step(lease, NEAR, 10)
        async with robot.lease("walker") as lease:
            assert (await robot.step(lease, NEAR, 10)).ok


@pytest.mark.parametrize("how", ["stop", "halt", "stop channel"])
async def test_law_14_what_was_accepted_before_a_stop_gets_no_lease(standing: Standing, how: str) -> None:
    drivers, name = standing
    async with drivers.client(name) as robot:
        accepted_s = time.monotonic()
        if how == "stop channel":
            await asyncio.to_thread(stop_driver, host_lock.namespaced(f"driver/fake/{name}"), "shell")
        else:
            await (robot.stop("shell") if how == "stop" else robot.halt("shell"))
        with pytest.raises(LeaseLost, match="by a halt" if how == "halt" else "by a stop"):
            async with robot.lease("agent", accepted_s):
                pass
        async with robot.lease("agent", time.monotonic()):
            assert await robot.holder() == "agent"


async def test_law_14_a_stop_of_what_runs_leaves_what_waits_and_forgets_no_stop_of_before(standing: Standing) -> None:
    drivers, name = standing
    async with drivers.client(name) as robot, drivers.client(name) as passer_by:
        accepted_s = time.monotonic()
        async with robot.lease("first") as lease:
            step = asyncio.create_task(robot.step(lease, FAR, 60))
            await moving(robot)
            assert (await robot.stop("agent: it is ended", running_only=True)).confirmed
            assert (await step).outcome is Outcome.STOPPED
        async with robot.lease("second", accepted_s):
            assert await robot.holder() == "second"
        await passer_by.stop("passer-by")
        await robot.stop("agent: it is ended", running_only=True)
        with pytest.raises(LeaseLost, match="by a stop of passer-by"):
            async with robot.lease("third", accepted_s):
                pass


async def test_law_14_a_stop_ends_also_who_waits_for_the_lease(drivers: Drivers) -> None:
    name, _ = drivers.start(options={"faults": {"stop_s": 1.0}})  # slow to come to rest, so the next one must wait
    async with drivers.client(name) as robot, drivers.client(name) as other:
        async with robot.lease("hasty") as lease:
            step = asyncio.create_task(robot.step(lease, FAR, 60))
            await moving(robot)

        async def take() -> None:
            async with other.lease("patient"):
                pass

        taking = asyncio.create_task(take())
        done, _ = await asyncio.wait({taking}, timeout=0.2)
        assert not done
        await robot.stop("passer-by")
        with pytest.raises(LeaseLost, match="by a stop"):
            await taking
        assert (await step).outcome is Outcome.STOPPED


@pytest.mark.parametrize("since_s", ["now", True, 1e12])
async def test_law_14_a_time_that_would_outrun_every_stop_is_refused(standing: Standing, since_s: Any) -> None:
    drivers, name = standing
    async with drivers.client(name) as robot:
        with pytest.raises(RobotError, match="'since_s' must be"):
            async with robot.lease("agent", since_s):
                pass


async def test_law_13_the_stop_channel_needs_neither_socket_nor_lease(drivers: Drivers) -> None:
    name, _ = drivers.start()
    async with drivers.client(name) as robot, robot.lease("walker") as lease:
        step = asyncio.create_task(robot.step(lease, FAR, 60))
        await moving(robot)
        (drivers.folder / f"{name}.sock").unlink()
        stopped = await asyncio.to_thread(stop_driver, host_lock.namespaced(f"driver/fake/{name}"), "shell")
        assert stopped.confirmed
        assert stopped.was_moving
        assert (await step).reason == "stop"


@pytest.mark.parametrize("body", [b"", b"[]", b'{"by": 7}', b"not json"])
async def test_law_15_a_stop_counts_also_when_it_does_not_say_whose_it_is(standing: Standing, body: bytes) -> None:
    drivers, name = standing
    wire = httpx2.AsyncHTTPTransport(uds=str(drivers.folder / f"{name}.sock"))
    async with drivers.client(name) as robot, robot.lease("walker") as lease:
        step = asyncio.create_task(robot.step(lease, FAR, 60))
        await moving(robot)
        async with httpx2.AsyncClient(transport=wire, base_url="http://driver", timeout=60) as anybody:
            stopped = await anybody.post("/stop", content=body)
        assert stopped.json()["confirmed"]
        assert (await step).reason == "stop"


async def test_law_11_a_renewal_that_was_long_on_its_way_does_not_extend_the_lease(standing: Standing) -> None:
    drivers, name = standing
    wire = httpx2.AsyncHTTPTransport(uds=str(drivers.folder / f"{name}.sock"))
    async with httpx2.AsyncClient(transport=wire, base_url="http://driver", timeout=60) as holder:
        lease = (await holder.post("/lease", json={"holder": "walker"})).json()["lease"]
        taken_s = time.monotonic()
        async with asyncio.timeout(30):
            while (answer := await holder.put(f"/lease/{lease}", json={"sent_s": taken_s})).is_success:  # noqa: ASYNC110
                await asyncio.sleep(0.05)
        assert (answer.status_code, answer.json()["why"]) == (409, "lease_lapsed")
        wrong = await holder.put(f"/lease/{lease}", json={"sent_s": "now"})
        assert (wrong.status_code, "CLOCK_MONOTONIC" in wrong.text) == (422, True)


async def test_law_13_stop_all_finds_every_driver(drivers: Drivers) -> None:
    flock = f"f{uuid4().hex[:6]}"
    names = [drivers.start(f"{flock}{i}")[0] for i in range(2)]
    async with drivers.client(names[1]) as robot, robot.lease("walker") as lease:
        step = asyncio.create_task(robot.step(lease, FAR, 60))
        await moving(robot)
        # The prefix spares the robots of tests that run in parallel.
        stopped = await asyncio.to_thread(stop_all, "shell", f"driver/fake/{flock}")
        assert sorted(stopped) == [host_lock.namespaced(f"driver/fake/{name}") for name in names]
        assert all(not isinstance(v, RobotUnreachable) and v.confirmed for v in stopped.values())
        assert (await step).reason == "stop"


def test_law_15_silent_and_foul_callers_do_not_hold_up_a_stop(standing: Standing) -> None:
    lock = host_lock.namespaced(f"driver/fake/{standing[1]}")
    silent = [host_lock.connect(lock) for _ in range(10)]
    with host_lock.connect(lock) as foul:
        foul.sendall(b"\xff\xfe go \n")
        assert "error" in json.loads(foul.makefile().readline())
    began_s = time.monotonic()
    assert stop_driver(lock, "shell").confirmed
    assert time.monotonic() - began_s < 1.0
    for s in silent:
        s.close()


async def test_law_17_a_halt_on_the_stop_channel_holds_until_released(drivers: Drivers) -> None:
    name, _ = drivers.start()
    settings = RobotConfig(model="fake", simulated=True)
    async with drivers.client(name) as robot:
        async with robot.lease("walker") as lease:
            step = asyncio.create_task(robot.step(lease, FAR, 60))
            await moving(robot)
            halted = await asyncio.to_thread(halt_robot, name, settings, "shell")
            assert halted.confirmed
            assert halted.was_moving
            assert (await step).outcome is Outcome.STOPPED
        assert (await robot.state()).halted
        async with robot.lease("walker") as lease:
            assert (await robot.step(lease, NEAR, 10)).reason == "halted"
            await robot.release("owner")
            with pytest.raises(LeaseLost, match="by a release of owner"):
                await robot.step(lease, NEAR, 10)
        async with robot.lease("walker") as lease:
            assert (await robot.step(lease, NEAR, 10)).ok


async def test_law_14_a_release_moves_nothing_that_was_accepted_before_it(drivers: Drivers) -> None:
    name, _ = drivers.start()
    async with drivers.client(name) as robot:
        await robot.halt("shell")
        accepted_s = time.monotonic()
        lock = await robot.release("owner")
        assert lock is not None
        assert (lock.by, lock.why) == ("shell", EMERGENCY_STOP)
        assert lock.at is not None
        assert abs((datetime.now(UTC) - lock.at).total_seconds()) < 10
        with pytest.raises(LeaseLost) as lost:
            async with robot.lease("walker", accepted_s):
                pass
        assert (lost.value.why, lost.value.by) == ("release", "owner")
        assert await robot.release("owner") is None, "it was not locked any more"
        async with robot.lease("walker") as lease:
            assert (await robot.step(lease, NEAR, 10)).ok
            assert await robot.release("owner") is None
            assert (await robot.step(lease, NEAR, 10)).ok, "a release of what is free ends nothing"


async def test_law_17_a_release_that_was_asked_for_before_the_halt_does_not_end_it(drivers: Drivers) -> None:
    name, process = drivers.start()
    async with drivers.client(name) as robot:
        asked_s = time.monotonic()
        await robot.halt("shell")
        with pytest.raises(RobotError, match="locked after this release was requested"):
            await robot.release("owner", asked_s)
        assert (await robot.state()).halted
        process.kill()
        process.communicate()
        drivers.start(name)
        with pytest.raises(RobotError, match="locked after this release was requested"):
            await robot.release("owner", asked_s)
        lock = (await robot.state()).lock
        assert lock is not None
        assert lock.by == "shell", "also across a restart"
        assert await robot.release("owner", time.monotonic()) == lock


async def homed(robot: DriverClient) -> Pose:
    """Wait until home is set, which happens once the driver has seen the robot stand still for a moment."""
    async with asyncio.timeout(60):
        while True:
            with contextlib.suppress(RobotError):
                return await robot.home("owner")
            await asyncio.sleep(0.05)


async def test_law_9_home_is_not_set_while_it_moves(drivers: Drivers) -> None:
    name, _ = drivers.start(home_on_start=False)
    async with drivers.client(name) as robot:
        async with robot.lease("walker") as lease:
            assert (await robot.step(lease, NEAR, 10)).reason == "not_homed"
        pose = await homed(robot)
        async with robot.lease("walker") as lease:
            step = asyncio.create_task(robot.step(lease, FAR, 60))
            await moving(robot)
            with pytest.raises(RobotError, match="cannot set home"):
                await robot.home("owner")
            await robot.stop("the test")
            await step
        state = await robot.state()
        assert state.homed
        assert state.pose is not None
        assert state.pose.x_m > pose.x_m


def test_no_driver_is_reported_plainly() -> None:
    with pytest.raises(RobotUnreachable, match="no driver"):
        stop_driver("driver/fake/nobody", "shell")


async def test_no_driver_is_reported_to_a_client(tmp_path: Path) -> None:
    async with DriverClient("nobody", tmp_path / "nobody.sock") as robot:
        with pytest.raises(RobotUnreachable, match="nobody"):
            await robot.state()
        with pytest.raises(RobotUnreachable):
            async with robot.lease("me"):
                pass


# ------------------------------------------------------------------ halt, death, restart
async def test_law_17_a_halt_survives_a_killed_driver(drivers: Drivers) -> None:
    name, process = drivers.start()
    async with drivers.client(name) as robot:
        assert (await robot.halt("owner")).confirmed
        process.kill()
        process.communicate()
        drivers.start(name)
        assert (await robot.state()).halted
        async with robot.lease("walker") as lease:
            assert (await robot.step(lease, NEAR, 10)).reason == "halted"
            await robot.release("owner")
            with pytest.raises(LeaseLost, match="by a release of owner"):
                await robot.step(lease, NEAR, 10)
        async with robot.lease("walker") as lease:
            assert (await robot.step(lease, NEAR, 10)).ok


async def test_a_killed_driver_leaves_a_socket_that_the_next_one_replaces(drivers: Drivers) -> None:
    name, process = drivers.start()
    process.kill()
    process.communicate()
    assert (drivers.folder / f"{name}.sock").exists()
    async with drivers.client(name) as robot:
        with pytest.raises(RobotUnreachable):
            await robot.state()
        drivers.start(name)
        async with robot.lease("walker") as lease:
            assert (await robot.step(lease, NEAR, 10)).ok


async def test_a_client_hears_of_a_driver_that_dies_under_its_step(drivers: Drivers) -> None:
    name, process = drivers.start()
    async with drivers.client(name) as robot, robot.lease("walker") as lease:
        step = asyncio.create_task(robot.step(lease, FAR, 60))
        await moving(robot)
        process.kill()
        with pytest.raises(RobotUnreachable):
            await step


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGINT])
async def test_a_driver_that_is_ended_stops_the_robot_and_leaves_nothing(drivers: Drivers, how: signal.Signals) -> None:
    name, process = drivers.start()
    async with drivers.client(name) as robot, robot.lease("walker") as lease:
        step = asyncio.create_task(robot.step(lease, FAR, 60))
        await moving(robot)
        began_s = time.monotonic()
        process.send_signal(how)
        await asyncio.to_thread(process.wait, 5)
        assert time.monotonic() - began_s < 3.0
        assert process.returncode == 0
        (told,) = await asyncio.gather(step, return_exceptions=True)
        assert isinstance(told, RobotUnreachable) or told.outcome is Outcome.STOPPED
    assert not (drivers.folder / f"{name}.sock").exists()
    assert host_lock.namespaced(f"driver/fake/{name}") not in host_lock.held("driver/")
    _, err = process.communicate()
    assert "Traceback" not in err


def test_a_socket_that_another_driver_serves_is_not_taken(drivers: Drivers) -> None:
    name = f"r{uuid4().hex[:8]}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as other:
        other.bind(str(drivers.folder / f"{name}.sock"))
        other.listen(1)
        process = drivers.spawn(name)
        _, err = process.communicate(timeout=100)
    assert process.returncode == 1
    assert "another driver serves" in err


def test_an_unknown_model_or_option_says_what_would_be_valid(drivers: Drivers) -> None:
    results = {}

    def run(key: str, **settings: Any) -> None:
        results[key] = drivers.spawn(f"r{uuid4().hex[:8]}", **settings).communicate(timeout=100)[1]

    threads = [
        threading.Thread(target=run, args=("model",), kwargs={"model": "unicorn"}),
        threading.Thread(target=run, args=("option",), kwargs={"options": {"speed": 3}}),
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert "installed robots: fake, g1, go2" in results["model"]
    assert "valid: faults, obstacles, room, things, time_scale" in results["option"]


def test_a_robot_of_a_stranger_that_cannot_be_loaded_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "torn_robot.py").write_text("import no_such_module")
    facts = tmp_path / "torn_robot-1.0.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: torn-robot\nVersion: 1.0\n")
    (facts / "entry_points.txt").write_text("[agentrob.robots]\ntorn = torn_robot:Torn\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ConfigError, match="robot 'torn' of the package torn-robot cannot be loaded from torn_robot"):
        make_robot(RobotConfig(model="torn"))
    with pytest.raises(ConfigError, match="robot 'nosuch' is not installed; installed robots: fake"):
        make_robot(RobotConfig(model="nosuch"))
