"""One step "go to PLACE": Nav2 drives, and the guard's watch, the ranges and the speed limit end it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import NamedTuple

from agentrob.model import ActionResult, Outcome, Pose, Primitive, RobotState
from agentrob.robots.control.controller import RATE_HZ, STOPPED_WINDOW_S, RestDetector, wrap
from agentrob.robots.control.step_runner import REST_LIMIT_S
from agentrob.robots.protocol import Watch
from agentrob.robots.safety.ranges import STOPPING_S
from agentrob_ros2.navigation import ABORTED, CANCELED, SUCCEEDED, Navigation
from agentrob_ros2.options import PlaceOptions, Ros2Options
from agentrob_ros2.readings import larger_m

#: A goal that does not appear in the action's status within this time was not accepted.
ACCEPT_S = 3.0
#: Free space ahead of its outline that must remain after it has come to rest.
FRONT_M = 0.05
#: How much faster than its limit it may be measured.
FASTER = 1.25
MOVING_MPS = 0.05
#: A position is added to the path when it lies this far from the last one, or turned.
PATH_M, PATH_RAD = 0.03, 0.1


class Track(NamedTuple):
    """The measured track of a step: (seconds, x, y, yaw) and the metres driven."""

    path: list[tuple[float, float, float, float]]
    driven: list[float]

    def add(self, t_s: float, pose: Pose) -> None:
        if self.path:
            _, x, y, yaw = self.path[-1]
            step_m = math.hypot(pose.x_m - x, pose.y_m - y)
            if step_m < PATH_M and abs(wrap(pose.yaw_rad - yaw)) < PATH_RAD:
                return
            self.driven.append(step_m)
        self.path.append((round(t_s, 3), round(pose.x_m, 4), round(pose.y_m, 4), round(pose.yaw_rad, 4)))


class Goer:
    """Runs steps of `navigation`. `state` is the robot's, `on_map` tells where one of its poses is on the map, `brake`
    publishes zero velocity."""

    def __init__(
        self,
        navigation: Navigation,
        options: Ros2Options,
        speed_mps: float,
        state: Callable[[], RobotState],
        on_map: Callable[[Pose], Pose | None],
        brake: Callable[[], object],
        ros_time_s: Callable[[], float],
    ) -> None:
        self._navigation, self._options, self._speed_mps = navigation, options, speed_mps
        self._state, self._on_map, self._brake, self._ros_time_s = state, on_map, brake, ros_time_s

    def go(self, primitive: Primitive, name: str, watch: Watch) -> ActionResult:
        place, started_s = self._options.places[name], time.monotonic()
        state = self._state()
        if why := self._navigation.absence():
            return _ended(primitive, Outcome.REFUSED, "no_answer", why, started_s)
        if self._navigation.busy:
            why = f"{self._navigation.action} is driving to another goal, which somebody else sent."
            return _ended(primitive, Outcome.REFUSED, "busy", why, started_s)
        if state.pose is None or (here := self._on_map(state.pose)) is None:
            frame, odom = self._options.navigation.frame, self._options.pose.odom_frame
            why = f"It does not know where it is: /tf has no transform from {frame} to {odom}."
            return _ended(primitive, Outcome.REFUSED, "not_localised", why, started_s)
        if reason := watch(state) or self._unsafe(state):
            why = f"Stopped before it began ({reason.replace('_', ' ')})."
            return _ended(primitive, Outcome.STOPPED, reason, why, started_s)
        goal, track = self._navigation.send(place, here, self._ros_time_s()), Track([], [])
        try:
            reason, status = self._follow(goal, track, watch, started_s)
        finally:
            if self._navigation.status(goal) != SUCCEEDED:
                self._navigation.cancel_all()
                self._brake()
        self._come_to_rest(track, started_s)
        return self._result(primitive, name, place, track, reason, status, started_s)

    def _follow(self, goal: bytes, track: Track, watch: Watch, started_s: float) -> tuple[str, int | None]:
        """Wait for the end of the goal; returns why it was ended here, and its status."""
        until_s = started_s + self._options.navigation.seconds
        while True:
            state, now_s = self._state(), time.monotonic()
            if reason := watch(state) or self._unsafe(state):
                return reason, self._navigation.status(goal)
            if state.pose is not None:
                track.add(now_s - started_s, state.pose)
            status = self._navigation.status(goal)
            if status in (SUCCEEDED, CANCELED, ABORTED):
                return "", status
            if status is None and now_s > started_s + ACCEPT_S:
                return "", None
            if now_s > until_s:
                return "deadline", status
            time.sleep(1 / RATE_HZ)

    def _unsafe(self, state: RobotState) -> str:
        """Why the base must stop, besides what the guard watches: its ranges ahead and its speed while Nav2 drives."""
        forward = state.velocity_mps[0] if state.velocity_mps is not None else 0.0
        if state.velocity_mps is not None and math.hypot(*state.velocity_mps) > FASTER * self._speed_mps + 0.02:
            return "limit_speed_mps"
        if abs(forward) < MOVING_MPS:
            return ""
        reading = state.ranges_m[0 if forward > 0 else 2]
        if reading is None:
            return "ranges_unknown"
        front_m = reading + larger_m(self._options.body) - self._options.body.length_m / 2
        return "obstacle" if front_m < FRONT_M + abs(forward) * STOPPING_S else ""

    def _come_to_rest(self, track: Track, started_s: float) -> None:
        rest, end_s = RestDetector(STOPPED_WINDOW_S), time.monotonic() + REST_LIMIT_S
        while (now_s := time.monotonic()) < end_s and not rest.reached:
            state = self._state()
            if state.pose is not None and state.age_s < 0.2:
                rest.update(now_s, state.pose)
                track.add(now_s - started_s, state.pose)
            if self._navigation.busy:
                self._brake()
            time.sleep(1 / RATE_HZ)

    def _result(
        self,
        primitive: Primitive,
        name: str,
        place: PlaceOptions,
        track: Track,
        reason: str,
        status: int | None,
        started_s: float,
    ) -> ActionResult:
        state = self._state()
        here = self._on_map(state.pose) if state.pose is not None and state.age_s < 0.5 else None
        measured, where = {"driven_m": round(sum(track.driven), 3)}, "where it is on the map is not known"
        if here is not None:
            missed_m = math.hypot(here.x_m - place.x_m, here.y_m - place.y_m)
            measured["missed_m"] = round(missed_m, 3)
            where = f"it is {missed_m:.2f} m from there"
        pair = f"Asked to go to {name.replace('_', ' ')}, {where}"
        near = here is not None and measured["missed_m"] <= self._options.navigation.tolerance_m
        if reason:
            outcome, word, why = Outcome.STOPPED, reason, f"stopped ({reason.replace('_', ' ')})"
        elif status is None:
            outcome, word, why = Outcome.FAILED, "rejected", "its navigation did not accept the goal"
        elif status == ABORTED:
            outcome, word, why = Outcome.FAILED, "navigation_failed", "its navigation gave up"
        elif status == CANCELED:
            outcome, word, why = Outcome.FAILED, "cancelled", "somebody else cancelled the goal"
        elif here is None:
            outcome, word, why = Outcome.UNKNOWN, "not_localised", "its navigation says that it arrived"
        elif not near:
            outcome, word, why = Outcome.INACCURATE, "inaccurate", "its navigation says that it arrived"
        else:
            outcome, word, why = Outcome.DONE, "", ""
        message = f"{pair}: {why}." if why else f"{pair}."
        return _ended(primitive, outcome, word, message, started_s, measured, tuple(track.path))


def _ended(
    primitive: Primitive,
    outcome: Outcome,
    reason: str,
    message: str,
    started_s: float,
    measured: dict[str, float] | None = None,
    path: tuple[tuple[float, float, float, float], ...] = (),
) -> ActionResult:
    return ActionResult(primitive, outcome, measured or {}, reason, message, started_s, time.monotonic(), path)
