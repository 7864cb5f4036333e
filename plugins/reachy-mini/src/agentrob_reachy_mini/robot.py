"""Reachy Mini as a robot of AgentRob: it moves its head, antennas and body by its daemon, and measures what it did."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import replace

from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError, RobotError
from agentrob.model import (
    ActionResult,
    Capabilities,
    Limits,
    Op,
    Outcome,
    Posture,
    Primitive,
    RobotState,
    StopResult,
)
from agentrob.robots.control.step_runner import REST_LIMIT_S
from agentrob.robots.protocol import Watch, limits_of
from agentrob_reachy_mini.camera import picture
from agentrob_reachy_mini.daemon import Daemon, DaemonLost, DaemonRefused
from agentrob_reachy_mini.motions import MOTIONS, Motion, motion_of
from agentrob_reachy_mini.operations import PLAY, declared
from agentrob_reachy_mini.options import ReachyOptions, options_of
from agentrob_reachy_mini.performer import Performer, Run
from agentrob_reachy_mini.pose import OutOfReach, apart_rad
from agentrob_reachy_mini.watcher import GESTURE, IDLE, POLL_S, TURNING, Seen, Watcher

#: Its body turns at most so fast, whatever the limits of the configuration allow.
TURN_DPS = 60.0
#: A turn from straight ahead reaches this far at most.
STEP_DEG = 150.0
CONFIRMING_S = 0.5
#: After a stop it has moved on if it turned by more than this.
CAME_ON_RAD = 0.03
#: Faster than this it moves.
MOVING_RPS = 0.1
#: A recorded move must turn the head by this much to have been seen.
PLAYED_DEG = 2.0


class ReachyMini:
    """See `agentrob.robots.protocol.Robot`. Needs no robot to be there yet.

    Raises `ConfigError` for options that are not valid.
    """

    model = "reachy-mini"

    @classmethod
    def describe(cls, settings: RobotConfig) -> Capabilities:
        """Its capabilities by its options, without connecting."""
        options = options_of(settings)
        try:
            own = declared(options)
        except ValueError as e:
            raise ConfigError(f"options of a Reachy Mini: moves: {e}") from None
        ops = frozenset({Op.GET_FRONT_IMAGE} if options.camera else ())
        return Capabilities(cls.model, ops, _limits(settings), frozenset(), settings.simulated, own)

    def __init__(self, settings: RobotConfig) -> None:
        self.capabilities = self.describe(settings)
        self.options: ReachyOptions = options_of(settings)
        self._speeds = self.options.speeds(self.capabilities.limits.turn_dps)
        self._daemon = Daemon(self.options.url)
        self._watcher = Watcher(self._daemon)
        self._performer = Performer(self._daemon, self._watcher)
        self._steps = 0

    # ------------------------------------------------------------ the robot
    def state(self) -> RobotState:
        return self._watcher.state()

    def silence(self) -> str:
        """See `agentrob.robots.protocol.ExplainsSilence`."""
        return self._watcher.silence()

    def posture(self, *, joints: bool) -> Posture:
        """See `agentrob.robots.protocol.HasPosture`: its foot stays where it stands."""
        state = self.state()
        return Posture(state.age_s, state.pose, 0.0)

    def step(self, primitive: Primitive, watch: Watch) -> ActionResult:
        started_s, watch = time.monotonic(), self._performer.attentive(watch)
        if primitive.op not in self.capabilities.ops:
            return _ended(
                primitive, Outcome.REFUSED, "unsupported", f"A {self.model} cannot {primitive.op}.", started_s
            )
        if primitive.op is Op.GET_FRONT_IMAGE:
            return self._photo(primitive, watch, started_s)
        if (start := self._watcher.newest) is None or self.state().age_s > CONFIRMING_S:
            why = self.silence() or f"No state of {self.options.url} came."
            return _ended(primitive, Outcome.REFUSED, "no_answer", why, started_s)
        if reason := watch(self.state()):
            why = f"Stopped before it began ({_plain(reason)})."
            return _ended(primitive, Outcome.STOPPED, reason, why, started_s)
        try:
            if self._daemon.running():
                return _ended(primitive, Outcome.REFUSED, "busy", "Another program moves it now.", started_s)
            motion = motion_of(primitive, start.pose, self._speeds) if primitive.op in MOTIONS else None
        except (DaemonLost, DaemonRefused) as e:
            return _ended(primitive, Outcome.REFUSED, "no_answer", str(e), started_s)
        except OutOfReach as e:
            return _ended(primitive, Outcome.REFUSED, "limit_reach", str(e), started_s)
        self._steps += 1
        self._watcher.doing = TURNING if primitive.op is Op.TURN else GESTURE
        try:
            if motion is None:
                return self._played(primitive, start, watch, started_s)
            run = self._performer.perform(motion.frames, watch)
        finally:
            self._watcher.doing = IDLE
        return self._measured(primitive, motion, start, run, started_s)

    def stop(self) -> StopResult:
        """End every move of the daemon at once; it then holds its pose. Then wait for rest."""
        asked_s, start, steps = time.monotonic(), self._watcher.newest, self._steps
        was_moving = self._watcher.doing != IDLE or self._watcher.speed_rps() > MOVING_RPS
        ended = self._performer.stop_all()
        latency_ms = round(1000 * (time.monotonic() - asked_s), 3)
        while not (ended and self._rests_since(asked_s)) and time.monotonic() < asked_s + REST_LIMIT_S:
            time.sleep(POLL_S)
            if self._steps != steps:  # a later step, which this stop does not concern
                break
            if self._watcher.doing != IDLE or not ended:  # a move may have been sent while it was told to stop
                ended = self._performer.stop_all()
        newest = self._watcher.newest
        came_on = start is not None and newest is not None and apart_rad(start.pose, newest.pose) > CAME_ON_RAD
        doubt = self._doubt(ended, asked_s)
        return StopResult(latency_ms, not doubt, was_moving or came_on, None if doubt else 0.0, doubt)

    def look(self) -> bytes:
        """See `agentrob.robots.protocol.HasCamera`."""
        if not self.options.camera:
            raise RobotError("this Reachy Mini has no camera: no `camera` in its options")
        return picture(self.options.camera)

    def close(self) -> None:
        if self._watcher.doing != IDLE:
            self._performer.stop_all()
        self._watcher.close()
        self._daemon.close()

    # ------------------------------------------------------------ what was done
    def _photo(self, primitive: Primitive, watch: Watch, started_s: float) -> ActionResult:
        if reason := watch(self.state()):
            return _ended(primitive, Outcome.STOPPED, reason, f"Stopped ({_plain(reason)}).", started_s)
        try:
            image = self.look()
        except RobotError as e:
            return _ended(primitive, Outcome.FAILED, "no_picture", str(e), started_s)
        return replace(_ended(primitive, Outcome.DONE, "", "", started_s), image=image)

    def _measured(self, primitive: Primitive, motion: Motion, start: Seen, run: Run, started_s: float) -> ActionResult:
        got_deg = motion.measured_deg(start.pose, [seen.pose for seen in run.seen])
        measured = {motion.name: round(got_deg, 2) + 0.0}
        if primitive.op is Op.TURN:
            measured["drift_m"] = 0.0
        if primitive.operation.argument("seconds") is not None and run.seen:
            measured["seconds"] = round(run.seen[-1].at_s - run.seen[0].at_s, 2)
        pair = f"Asked {motion.asked_deg:.0f}°, measured {got_deg:.1f}°"
        path = _path(run.seen)
        if run.reason:
            outcome = Outcome.FAILED if run.reason in ("rejected", "no_answer", "timeout") else Outcome.STOPPED
            why = f" {run.message}" if run.message else ""
            message = f"{pair}: stopped ({_plain(run.reason)}).{why}"
            return _ended(primitive, outcome, run.reason, message, started_s, measured, path)
        if not motion.done(got_deg):
            why = "it did not move" if got_deg < 1.0 < motion.asked_deg else "it ended there"
            return _ended(primitive, Outcome.FAILED, "inaccurate", f"{pair}: {why}.", started_s, measured, path)
        return _ended(primitive, Outcome.DONE, "", f"{pair}.", started_s, measured, path)

    def _played(self, primitive: Primitive, start: Seen, watch: Watch, started_s: float) -> ActionResult:
        """Play a recorded move. It keeps the bounds of its library, which its daemon has the last word on."""
        move = self.options.moves[primitive.op.removeprefix(PLAY)]
        run = self._performer.play(move.dataset, move.move, move.seconds, watch)
        moved_deg = math.degrees(max((apart_rad(start.pose, seen.pose) for seen in run.seen), default=0.0))
        measured, path = {"head_deg": round(moved_deg, 2)}, _path(run.seen)
        if run.reason:
            outcome = Outcome.FAILED if run.reason in ("rejected", "no_answer", "timeout") else Outcome.STOPPED
            message = f"It was stopped ({_plain(run.reason)}). {run.message}".strip()
            return _ended(primitive, outcome, run.reason, message, started_s, measured, path)
        if moved_deg < PLAYED_DEG:
            message = f"It did not move: measured {moved_deg:.1f}°."
            return _ended(primitive, Outcome.FAILED, "inaccurate", message, started_s, measured, path)
        return _ended(primitive, Outcome.DONE, "", f"Moved by up to {moved_deg:.0f}°.", started_s, measured, path)

    def _rests_since(self, asked_s: float) -> bool:
        newest = self._watcher.newest
        return newest is not None and newest.at_s > asked_s and self._watcher.at_rest()

    def _doubt(self, ended: bool, asked_s: float) -> str:
        """Why it is not known to be at rest; empty if it is."""
        if (age_s := self._watcher.age_s()) >= CONFIRMING_S:
            age = "no state ever came" if math.isinf(age_s) else f"its state is {age_s:.1f} s old"
            return f"The robot did not confirm: {age}. {self.silence()}".strip()
        if not ended:
            return "The robot did not confirm: its daemon still runs a move."
        if not self._rests_since(asked_s):
            return f"The robot did not confirm: it still moved after {REST_LIMIT_S:g} s."
        return ""


class ReachyMiniSim(ReachyMini):
    """The same robot with the daemon that the package ships (`agentrob_reachy_mini.simulated_daemon`)."""

    model = "reachy-mini-sim"


def _limits(settings: RobotConfig) -> Limits:
    limits = limits_of(settings)
    return replace(
        limits, turn_dps=min(limits.turn_dps, TURN_DPS), step_deg=min(limits.step_deg, STEP_DEG)
    )  # fmt: skip


def _path(seen: Sequence[Seen]) -> tuple[tuple[float, float, float, float], ...]:
    return tuple((round(one.at_s - seen[0].at_s, 3), 0.0, 0.0, round(one.pose.body_yaw, 4)) for one in seen)


def _plain(reason: str) -> str:
    return reason.replace("_", " ")


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
