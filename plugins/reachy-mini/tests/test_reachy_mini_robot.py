"""The robot on its simulated daemon: what it does by the daemon's truth, how it stops, and its pictures."""

from __future__ import annotations

import http.server
import itertools
import math
import socket
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest
from agentrob_reachy_mini.pose import BodyPose
from agentrob_reachy_mini.robot import ReachyMiniSim
from agentrob_reachy_mini.simulated_daemon import SimulatedDaemon
from reachy_scene import LIMIT_S, act, ready, turn

from agentrob.config.robots import RobotConfig
from agentrob.model import ActionResult, Direction, Op, Outcome, Primitive, RobotState
from agentrob.robots.contract import go_on
from agentrob.robots.safety.guard import Guard

JPEG = b"\xff\xd8\xff\xe0" + bytes(200) + b"\xff\xd9"


def degrees(pose: BodyPose) -> tuple[int, int, int, int]:
    """Body yaw, neck yaw, pitch and roll, in whole degrees."""
    found = (pose.body_yaw, pose.neck_yaw, pose.pitch, pose.roll)
    return tuple(round(math.degrees(v)) for v in found)  # type: ignore[return-value]


def test_each_look_ends_where_it_was_asked_by_the_truth_of_the_daemon(
    robot: ReachyMiniSim, daemon: SimulatedDaemon
) -> None:
    ready(robot)
    for step, pose in (
        (act("look_up", angle_deg=20.0), (0, 0, -20, 0)),
        (act("look_down", angle_deg=30.0), (0, 0, 30, 0)),
        (act("glance", side="left", angle_deg=50.0), (0, 50, 0, 0)),
        (turn(60, Direction.RIGHT), (-60, 50, 0, 0)),
        (act("tilt_head", side="left", angle_deg=15.0), (-60, 0, 0, -15)),
        (act("center_head"), (-60, 0, 0, 0)),
    ):
        result = robot.step(step, go_on)
        assert result.outcome is Outcome.DONE, result.message
        assert degrees(daemon.present()) == pose


def test_a_result_has_what_was_asked_beside_what_was_measured(guard: Guard, daemon: SimulatedDaemon) -> None:
    ready(guard)
    result = guard.step(turn(30), go_on)
    assert result.outcome is Outcome.DONE
    assert result.message == "Asked 30°, measured 30.0°."
    assert "ranges" not in result.message, "its foot stays: it needs no range readings (law 8)"
    assert result.measured["degrees"] == pytest.approx(30, abs=0.5)
    nod = guard.step(act("nod"), go_on)
    assert nod.message.startswith("Asked 15°, measured 1")
    assert 9 < nod.measured["head_deg"] <= 15.1
    dance = guard.step(act("sway", seconds=3.0), go_on)
    assert dance.measured["seconds"] == pytest.approx(3.0, abs=1.0)


def test_what_it_cannot_do_is_refused(guard: Guard) -> None:
    ready(guard)
    result = guard.step(Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0), go_on)
    assert (result.outcome, result.reason) == (Outcome.REFUSED, "unsupported")


def test_law_17_nothing_moves_after_a_stop_and_it_holds_its_pose(robot: ReachyMiniSim, daemon: SimulatedDaemon) -> None:
    ready(robot)
    turning, results = threading.Event(), list[ActionResult]()

    def notice(state: RobotState) -> str | None:
        if state.yaw_rate_rps is not None and state.yaw_rate_rps > 0.3:
            turning.set()
        return None

    step = threading.Thread(target=lambda: results.append(robot.step(turn(120), notice)))
    step.start()
    assert turning.wait(LIMIT_S)
    asked_s = time.monotonic()
    stopped = robot.stop()
    step.join(LIMIT_S)
    assert stopped.confirmed, stopped.message
    assert stopped.was_moving
    assert (results[0].outcome, results[0].reason) == (Outcome.STOPPED, "stop")
    assert 0 < results[0].measured["degrees"] < 115
    at_s = daemon.stops[0]
    held = daemon.target(at_s)
    assert at_s - asked_s < 0.5
    assert daemon.target(time.monotonic()) == held
    assert len(daemon.commands) == 1
    assert robot.step(act("nod"), go_on).outcome is Outcome.DONE, "the next step moves it"


def test_a_stop_between_two_frames_ends_the_motion(robot: ReachyMiniSim, daemon: SimulatedDaemon) -> None:
    ready(robot)
    third, results = threading.Event(), list[ActionResult]()

    def notice(_: RobotState) -> str | None:
        if len(daemon.commands) == 3:
            third.set()
        return None

    step = threading.Thread(target=lambda: results.append(robot.step(act("sway", seconds=10.0), notice)))
    step.start()
    assert third.wait(LIMIT_S)
    assert robot.stop().confirmed
    step.join(LIMIT_S)
    assert results[0].reason == "stop"
    assert len(daemon.commands) <= 4


def test_every_move_that_is_sent_keeps_the_speeds_of_the_configuration(daemon: SimulatedDaemon, url: str) -> None:
    slow = RobotConfig(
        model="reachy-mini-sim", simulated=True, limits={"turn_dps": 20}, options={"url": url, "head_dps": 20}
    )
    robot = ReachyMiniSim(slow)
    ready(robot)
    assert robot.step(turn(20), go_on).outcome is Outcome.DONE
    assert robot.step(act("nod"), go_on).outcome is Outcome.DONE
    robot.close()
    body = [0.0, *(command.body_yaw or 0.0 for command in daemon.commands)]
    pitch = [0.0, *(command.head_pose.pitch if command.head_pose else 0.0 for command in daemon.commands)]
    for axis in (body, pitch):
        for (a, b), command in zip(itertools.pairwise(axis), daemon.commands, strict=True):
            assert 1.875 * math.degrees(abs(b - a)) / command.duration <= 20.2


# ------------------------------------------------------------------ pictures
class Camera(http.server.BaseHTTPRequestHandler):
    content, status = JPEG, 200

    def do_GET(self) -> None:
        self.send_response(self.status)
        self.send_header("Content-Length", str(len(self.content)))
        self.end_headers()
        self.wfile.write(self.content)

    def log_message(self, *_: Any) -> None:
        """Keep quiet."""


@pytest.fixture
def camera() -> Iterator[http.server.HTTPServer]:
    server = http.server.HTTPServer(("127.0.0.1", 0), type("Handler", (Camera,), {}))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield server
    server.shutdown()
    thread.join()
    server.server_close()


def test_a_photo_comes_from_the_camera_of_the_configuration(
    camera: http.server.HTTPServer, daemon: SimulatedDaemon, url: str
) -> None:
    at = f"http://127.0.0.1:{camera.server_address[1]}/snapshot.jpg"
    robot = ReachyMiniSim(RobotConfig(model="reachy-mini-sim", options={"url": url, "camera": at}))
    try:
        result = robot.step(Primitive(Op.GET_FRONT_IMAGE), go_on)
        assert (result.outcome, result.image) == (Outcome.DONE, JPEG)
        for name, value, words in (
            ("content", b"<html>", "something else than a JPEG"),
            ("status", 401, "answered 401"),
        ):
            setattr(camera.RequestHandlerClass, name, value)
            failed = robot.step(Primitive(Op.GET_FRONT_IMAGE), go_on)
            assert (failed.outcome, failed.reason) == (Outcome.FAILED, "no_picture")
            assert words in failed.message
    finally:
        robot.close()


def test_a_daemon_whose_port_is_another_program_is_told(
    listening: socket.socket, camera: http.server.HTTPServer
) -> None:
    robot = ReachyMiniSim(
        RobotConfig(model="reachy-mini-sim", options={"url": f"http://127.0.0.1:{camera.server_address[1]}"})
    )
    try:
        refused = robot.step(act("nod"), go_on)
        assert (refused.outcome, refused.reason) == (Outcome.REFUSED, "no_answer")
    finally:
        robot.close()
