"""The guard: wraps a robot and refuses or stops steps that laws 8, 9, 10 and 12 forbid, for every client.

Covered, before a step and 20 times a second while it runs:
- limits of speed, distance and angle of a step: a step beyond is refused with the limit named, never clipped;
- the fence around the owner's home, along the whole predicted path including the distance the body coasts;
- obstacles in the direction of motion by the robot's own four range readings; readings that are missing, zero or never
  change are unknown: then at most 0.2 m/s, and only with the owner's consent, and the result says so; readings that are
  lost on the way end a step that is faster, and every step without that consent;
- state older than 0.5 s, the deadline, a halt, which holds until the owner releases it, also across restarts;
- a fall: the step ends, home is void, and the robot stays down until it is asked to stand up, which needs no home;
  nothing else is done meanwhile, and a step that ends lying is never called done;
- a battery below the owner's level: no step begins; one under way is ended in order, and its result says so;
- a position that is NaN or infinite: treated as missing;
- an odometry that jumps or comes back after a long silence: home is void, no motion until the robot is homed again
  (a simulated robot that homes itself at start does so again once it stands still);
- a mode or motion that we did not command: a halt; damping always is, also during a gesture. A robot that is already
  damped at start is not moved until somebody makes it stand;
- a driver that was killed during a step: the next one stops the robot first, and motion that ends within 2 s
  does not cause a halt;
- where the owner configured a shared room: other robots of the room. No step begins without a zone lease, and one under
  way ends when the lease is lost or another robot stands or comes within reach ahead (`agentrob.robots.zones`);
- a picture that shows nothing: it is reported as failed;
- an operation that the robot declares: its arguments, the free space that it needs, its time, and that it takes the
  body no farther from its place than it declares; a robot that lies about this is ended by its own odometry, and a
  result that differs from what was asked, or was not measured, is not called done.

Not covered:
- people, animals, and anything below, above or between the four range beams: stairs, cables, glass, table edges;
- obstacles that move towards the robot, and all obstacles during gestures and flips, which need free space around;
- drift of the odometry within plausible speed, and jumps of less than 25 cm: fence and measured values depend on it. If
  a robot is pushed or slips and its odometry does not register it, its position is wrong;
- pushes: a robot pushed off its path walks back to it, towards the person who pushed it;
- what a declared operation does besides moving the body over the floor: what its arms reach, blow, throw or heat;
- a robot that reports wrong data, or that does not obey a stop: the stop's result then says `confirmed: false`;
- a robot that cannot be reached: it holds the last velocity for up to a second, then its own firmware decides;
- a fall itself: it is detected once the body is tilted by 60°, and nothing softens it. The space around a robot that is
  asked to get up is not checked;
- a battery that the robot does not report (a G1's) or reports wrongly, and one that fails within a step; motor heat;
- a picture that is old, frozen, or of another place: only whether it shows something is checked;
- the floor: slopes, wet or loose ground, anything that is not level and free;
- the sum of several steps (a command's limits): the agent's mandate counts them;
- robots that do not share a configured room: each has its own guard, and detects others by its range readings only;
- a machine that is frozen or too busy: a driver that does not run stops nothing (its lease and the robot's own hold of
  one second do), nor does it see what the robot does meanwhile;
- other programs that command the robot over DDS directly. Nothing here replaces the robot's hardware stop.
"""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from agentrob.config.robots import RobotConfig
from agentrob.errors import RobotError
from agentrob.model import (
    EMERGENCY_STOP,
    ActionResult,
    Capabilities,
    Hindrance,
    Lock,
    Op,
    Outcome,
    Pose,
    Posture,
    Primitive,
    RobotState,
    StopResult,
)
from agentrob.robots.control.controller import known, wrap
from agentrob.robots.control.odometry import OdometryMonitor
from agentrob.robots.control.picture_check import fail_blank_picture
from agentrob.robots.control.step_runner import JUMPED, LOST, unmeasured
from agentrob.robots.protocol import ExplainsSilence, HasCamera, HasPosture, Robot, Watch
from agentrob.robots.safety.crash_marker import CrashMarker
from agentrob.robots.safety.declared import as_declared, left_its_place, seconds_allowed
from agentrob.robots.safety.fence import Fence, ahead, onward
from agentrob.robots.safety.limits import beyond_limits
from agentrob.robots.safety.lock import Halt
from agentrob.robots.safety.ranges import STOPPING_S, RangeMonitor
from agentrob.robots.safety.takeover import DAMPING, WALKS, TakeoverDetector
from agentrob.robots.zones.member import RoomMember

log = logging.getLogger(__name__)

STATE_AGE_S = 0.5
#: At most this fast where ranges are unknown (law 8).
BLIND_MPS = 0.2
OBSERVE_HZ = 20.0
#: A step waits so long for measured rest before its robot asks for another zone.
REST_S = 2.0
#: A home that is set again within this distance is in the same place.
SAME_PLACE_M = 0.1
#: A first step waits so long for a state that comes steadily, for range readings and for the simulated home.
PREPARE_S = 3.0

#: How much faster than its limit a walk of the robot's own may be measured.
_FASTER_MPS = 0.1

_UNSEEN = "Its range readings are unknown, so nobody knows whether the space around it was free."
_BLIND = f"Its range readings are unknown, so it went at most {BLIND_MPS} m/s."
_HOMES_NOT = "home_on_start homes simulated robots only."
_YOUNGER = f"it must be younger than {STATE_AGE_S} s"

Refusal = tuple[str, str]  # (stable word, sentence)


@dataclass(frozen=True, slots=True)
class SimulatedTime:
    """The clock of a simulation that does not run in real time. `wait` lets it run for so many seconds."""

    now_s: Callable[[], float]
    wait: Callable[[float], object]


class Guard:
    """See `agentrob.robots.protocol.Robot`. Starts a thread that also watches the robot between steps.

    `mark` is written while a step runs. If a previous guard died during a step, call `settle` first. `room` is the room
    that the robot shares with others.

    A rehearsal gives `simulated_time` and the `home` that the robot has; then no thread is started, and its owner calls
    `observe` between steps.
    """

    def __init__(
        self,
        robot: Robot,
        settings: RobotConfig,
        halt: Halt,
        mark: CrashMarker | None = None,
        room: RoomMember | None = None,
        *,
        simulated_time: SimulatedTime | None = None,
        home: Pose | None = None,
    ) -> None:
        self.capabilities: Capabilities = robot.capabilities
        self._robot, self._settings, self._halt = robot, settings, halt
        self._crash_marker = mark or CrashMarker(None)
        self._ranges, self._takeover = RangeMonitor(), TakeoverDetector()
        self._odometry = OdometryMonitor(getattr(robot, "time_scale", 1.0))
        self._room = room
        self._first_home: Pose | None = None
        self._fence = Fence(settings.fence, home) if home is not None else None
        if settings.home_on_start and not settings.simulated:
            log.warning("%s The owner of this one sets its home.", _HOMES_NOT)
        self._stepping = threading.Lock()
        self._looking = threading.Lock()
        self._running: Primitive | None = None
        self._stops = 0
        self._sentence = self._lost_home = ""
        self._travelled = ""  # a sentence, once the running step took the robot farther than declared
        self._getting_up = False  # whether the running step makes a fallen robot stand up
        self._start: Pose | None = None  # where the running step began
        self._blind = False  # whether the running step goes, or went, without the range readings that it needs
        self._broken = ""  # why the running step is not measured: its odometry was lost, or jumped
        self._closed = threading.Event()
        self._now_s = simulated_time.now_s if simulated_time else time.monotonic
        self._wait = simulated_time.wait if simulated_time else self._closed.wait
        self._left = self._crash_marker.interrupted_step()
        if self._left is not None:
            self._takeover.inherit(self._now_s(), *self._left)
        if simulated_time is None:
            threading.Thread(target=self._observe, name="guard-observer", daemon=True).start()

    # ------------------------------------------------------------ the robot
    def state(self) -> RobotState:
        lock = self._halt.lock
        return replace(
            sanitized(self._robot.state()), homed=self._fence is not None, halted=lock is not None, lock=lock
        )

    def step(self, primitive: Primitive, watch: Watch, deadline_s: float | None = None) -> ActionResult:
        """See `Robot.step`; `deadline_s` is how long it may take, at most the limit of a command."""
        stops = self._stops
        attentive: Watch = lambda state: "stop" if self._stops != stops else watch(state)  # noqa: E731
        if not self._stepping.acquire(blocking=False):
            return _refused(primitive, "busy", "Another step is still running.")
        try:
            limit_s = self.capabilities.limits.command_s
            return self._guarded(primitive, attentive, limit_s if deadline_s is None else min(deadline_s, limit_s))
        finally:
            self._running = None
            self._stepping.release()

    def stop(self) -> StopResult:
        """Stop the robot; never waits for a lock of the guard."""
        self._stops += 1
        self._takeover.own_motion(self._now_s())
        return self._robot.stop()

    def look(self) -> bytes:
        """Return a picture of the robot's own camera without affecting a running step. Raises `RobotError`."""
        if not isinstance(self._robot, HasCamera) or Op.GET_FRONT_IMAGE not in self.capabilities.ops:
            raise RobotError("this robot has no camera that can be looked through while it moves")
        return self._robot.look()

    def posture(self, *, joints: bool = True) -> Posture:
        """Return how the robot holds its body, with its pose in the frame of its home. Never blocks."""
        state = sanitized(self._robot.state())
        seen = self._robot.posture(joints=joints) if isinstance(self._robot, HasPosture) else Posture(state.age_s)
        return replace(seen, pose=self._at_home(state.pose))

    def _at_home(self, pose: Pose | None) -> Pose | None:
        """A pose of the odometry in the frame of the robot's home; None without one of them."""
        fence = self._fence
        if fence is None or pose is None:
            return None
        x_m, y_m = fence.at_home(pose.x_m, pose.y_m)
        return Pose(x_m, y_m, wrap(pose.yaw_rad - fence.home.yaw_rad))

    def settle(self) -> None:
        """If the previous guard died during a step, stop the robot and wait until it is at rest (at most 3 s)."""
        if self._left is not None:
            stopped = self._robot.stop()  # not `stop`: what the robot's mode does meanwhile is not taken for ours
            log.warning("the driver before this one died during %s; stopped the robot: %s", self._left.op, stopped)
        self._crash_marker.clear()

    def observe(self) -> None:
        """Take in the robot's state between steps: called 20 times a second where the guard has no thread."""
        self._take_in()

    def close(self) -> None:
        if self._room is not None:
            self._room.close()
        self._closed.set()
        self._robot.close()

    # ------------------------------------------------------------ home and halt
    def home(self, by: str) -> Pose:
        """Set home, the centre of the fence, to the robot's current pose. Raises `RobotError`."""
        state = sanitized(self._robot.state())
        if state.pose is None or not state.age_s < STATE_AGE_S:
            why = _unseen(state) or f"The robot's state is {_age(state)}; {_YOUNGER}."
            raise RobotError(f"cannot set home: {self._explained(why)}")
        if not state.upright:
            raise RobotError("cannot set home: the robot is not known to stand upright")
        if self._running is not None or not self._odometry.still(self._now_s()):
            raise RobotError("cannot set home while the robot moves; let it stand still for a moment")
        self._fence = Fence(self._settings.fence, state.pose)
        self._homed_in_room(state.pose)
        log.info("home set by %s at x %.2f m, y %.2f m", by, state.pose.x_m, state.pose.y_m)
        return state.pose

    def _homed_in_room(self, home: Pose) -> None:
        """The settings say where the first home is in the room; whether a later one is there is not known, unless it is
        the same place by the odometry of a simulated robot, which no restart sets to zero."""
        if self._room is None:
            return
        first, self._first_home = self._first_home, self._first_home or home
        if first is None:
            return
        if math.hypot(home.x_m - first.x_m, home.y_m - first.y_m) > SAME_PLACE_M:
            self._room.lose_frame("its home was set in another place")
        elif self._settings.simulated:
            self._room.regain_frame()

    # ------------------------------------------------------------ the room that it shares
    def enter_room(self, steps: Sequence[Primitive]) -> Hindrance | None:
        """Get the zone that these steps need, if the robot shares a room and does not hold it; they then begin within
        some seconds. Return why not. Blocks for at most about `REST_S` for measured rest."""
        if self._room is None:
            return None
        stops, end_s = self._stops, time.monotonic() + REST_S
        while True:
            self._take_in()
            hindrance = self._room.admit(steps)
            settles = hindrance is not None and hindrance.reason == "room_restless"
            if not settles or self._stops != stops or time.monotonic() >= end_s or self._closed.wait(1 / OBSERVE_HZ):
                return hindrance

    def leave_room(self) -> None:
        """No step follows: give the zone back once the robot is at rest. Never blocks."""
        if self._room is not None:
            self._room.leave()

    def halt(self, by: str, why: str = EMERGENCY_STOP, asked_s: float | None = None) -> StopResult:
        """Stop, and refuse all motion until `release`, also after a restart of the driver.

        `asked_s` is when the halt was requested (monotonic seconds; default now): a release requested later removes it.
        """
        log.warning("%s", self._halt.set(by, why, asked_s))
        kept: list[bool] = []
        writer = threading.Thread(target=lambda: kept.append(self._halt.save()), daemon=True)
        writer.start()  # the disk must not delay the stop
        result = self.stop()
        writer.join(2.0)
        if kept != [True]:
            note = "The halt could not be written to disk: it holds until this driver ends, not beyond."
            result = replace(result, message=f"{result.message} {note}".strip())
        return result

    def release(self, by: str, since_s: float = math.inf) -> Lock | None:
        """Allow motion again, without moving. Return the removed lock, or None if there was none.

        `since_s` is when the release was requested, in monotonic seconds. Raises `RobotError` if the robot was locked
        after that, or if the halt cannot be removed from the disk.
        """
        try:
            lock = self._halt.release(since_s)
        except OSError as e:
            raise RobotError(f"the halt stays: {self._halt.path} cannot be removed ({e.strerror})") from None
        log.warning("released by %s: %s", by, lock)
        return lock

    # ------------------------------------------------------------ before a step
    def _guarded(self, primitive: Primitive, watch: Watch, deadline_s: float) -> ActionResult:
        primitive = self.capabilities.bound(primitive)
        if refusal := self._malformed(primitive):
            return _refused(primitive, *refusal)
        if not primitive.moves:
            return self._sense(primitive, watch)
        if primitive.declared is not None:
            deadline_s = min(deadline_s, seconds_allowed(primitive.declared, primitive))
        until_s = self._now_s() + deadline_s
        self._prepare(primitive)
        self._getting_up = primitive.op is Op.STAND and sanitized(self._robot.state()).upright is False
        if refusal := self._unfit(primitive) or self._misplaced(primitive):
            return _refused(primitive, *refusal)
        careful = self._careful(primitive)
        refusal = self._blocked(careful) or self._late(careful, deadline_s) or self._hindered(careful)
        if refusal:
            return _refused(primitive, *refusal)
        self._sentence, self._travelled, self._broken, self._blind = "", "", "", self._ranges.unknown(careful)
        self._start = sanitized(self._robot.state()).pose
        self._running = primitive
        self._crash_marker.begin(primitive.op, self._robot.state().mode)
        if self._room is not None:
            self._room.begin()
        try:
            result = self._robot.step(careful, lambda state: watch(state) or self._look(careful, until_s))
        finally:
            self._crash_marker.end()
            if self._room is not None:
                self._room.end()
        self._takeover.own_motion(self._now_s())
        result = self._seen_throughout(as_declared(replace(result, primitive=primitive)))
        note = (_BLIND if primitive.walks else _UNSEEN) if self._blind else ""
        message = " ".join(s for s in (result.message, self._sentence, note) if s)
        return self._after(replace(result, message=message))

    def _sense(self, primitive: Primitive, watch: Watch) -> ActionResult:
        """Do a step that only moves a sensor: it needs no home, but the body must stay where it is."""
        self._travelled = self._broken = ""
        self._start = sanitized(self._robot.state()).pose
        result = self._robot.step(
            primitive, lambda state: watch(state) or self._check_travel(primitive, sanitized(state).pose)
        )
        result = as_declared(replace(result, primitive=primitive))
        return self._stayed(fail_blank_picture(result) if primitive.operation.picture else result)

    def _check_travel(self, primitive: Primitive, pose: Pose | None) -> str | None:
        """Return the reason to end a step that took the robot farther than its operation declares."""
        self._travelled = left_its_place(primitive, self._start, pose) or self._travelled
        return "travelled" if self._travelled else None

    def _stayed(self, result: ActionResult) -> ActionResult:
        """Law 18: an operation that left the place where it was declared to stay has failed, whatever it says."""
        self._check_travel(result.primitive, sanitized(self._robot.state()).pose)
        if not self._travelled or self._broken:
            return result
        log.warning("%s", self._travelled)
        message = f"{result.message} {self._travelled}".strip()
        return replace(result, outcome=Outcome.FAILED, reason="travelled", message=message)

    def _seen_throughout(self, result: ActionResult) -> ActionResult:
        """Law 18: report no measured values for a step that was not observed from start to end."""
        if not self._broken and not sanitized(self._robot.state()).age_s < STATE_AGE_S:
            self._broken = LOST
        return unmeasured(result, self._broken) if self._broken and result.measured else result

    def _after(self, result: ActionResult) -> ActionResult:
        """Add the robot's state after the step to the result: a fallen robot has not succeeded.

        A body that falls turns faster than one that walks, so its fall can be noticed as a jump of the odometry first.
        """
        result = self._stayed(result)
        state = sanitized(self._robot.state())
        if state.upright is False and result.reason != "fallen":
            outcome = Outcome.FAILED if result.ok else result.outcome
            reason = "fallen" if result.ok or result.reason == JUMPED else result.reason
            message = f"{result.message} The robot is now down: it fell, or did not get up."
            return replace(result, outcome=outcome, reason=reason, message=message.strip())
        low = _low_battery(state, self._settings)
        return replace(result, message=f"{result.message} {low}".strip()) if low else result

    def _malformed(self, primitive: Primitive) -> Refusal | None:
        if primitive.op not in self.capabilities.ops:
            ops = ", ".join(sorted(self.capabilities.ops))
            return "unsupported", f"This robot cannot {primitive.op}; it can: {ops}."
        return beyond_limits(primitive, self.capabilities)

    def _unfit(self, primitive: Primitive) -> Refusal | None:
        state = self._take_in()
        if (why := self._halt.why) is not None:
            return "halted", f"{why.rstrip('.')}. No motion until the owner releases it."
        needed = primitive.operation.needed_consent
        if needed and not self._settings.simulated and needed not in self._settings.consents:
            option = "allow_flip" if needed == "flip" else f'allow_risky = ["{needed}"]'
            return "consent", f"{primitive.op} needs the owner's consent ({option})."
        if state.age_s >= STATE_AGE_S or state.pose is None:
            return "stale_state", self._explained(_unseen(state) or f"The robot's state is {_age(state)}; {_YOUNGER}.")
        if fallen := _fallen(state, primitive):
            return fallen
        if low := _low_battery(state, self._settings):
            return "low_battery", low
        if state.mode == DAMPING:
            return "posture", "The robot is damped, and not by us; somebody beside it must make it stand up first."
        return None

    def _misplaced(self, primitive: Primitive) -> Refusal | None:
        if self._getting_up:  # a fall voids home, which can only be set while the robot stands
            return None
        if self._fence is None:
            ignored = " " + _HOMES_NOT if self._settings.home_on_start and not self._settings.simulated else ""
            return (
                "not_homed",
                f"The robot has no home, so its fence is unknown; its owner must set home first.{ignored}",
            )
        pose = sanitized(self._robot.state()).pose
        sentence = self._fence.refusal(pose, primitive) if pose else "The robot gives no position."
        return ("fence", sentence) if sentence else None

    def _careful(self, primitive: Primitive) -> Primitive:
        """Return the step with its speed set, reduced if the ranges are unknown."""
        limit_mps = self.capabilities.limits.speed_mps
        speed_mps = primitive.speed_mps or (limit_mps if primitive.op is Op.MOVE else None)
        if self._ranges.unknown(primitive):
            speed_mps = min(speed_mps or math.inf, BLIND_MPS)
        return replace(primitive, speed_mps=speed_mps)

    def _blocked(self, primitive: Primitive) -> Refusal | None:
        if self._ranges.unknown(primitive) and not self._settings.allow_unknown_ranges:
            if not self._ranges.enough:
                return "stale_state", "The robot's state comes too seldom to know what is free around it."
            return "ranges_unknown", self._explained(
                "The range readings that this step needs are missing, zero or never change, so free space is unknown; "
                f"the owner may allow up to {BLIND_MPS} m/s (allow_unknown_ranges)."
            )
        sentence = self._ranges.obstacle(primitive, primitive.speed_mps or 0.0)
        return ("obstacle", sentence) if sentence else None

    def _explained(self, sentence: str) -> str:
        """The sentence, with what the robot says on why it is silent."""
        why = self._robot.silence() if isinstance(self._robot, ExplainsSilence) else ""
        return f"{sentence} {why}".strip()

    def _late(self, primitive: Primitive, deadline_s: float) -> Refusal | None:
        limits = self.capabilities.limits
        needed_s = (primitive.distance_m or 0.0) / (primitive.speed_mps or limits.speed_mps)
        needed_s += (primitive.degrees or 0.0) / limits.turn_dps
        needed_s += primitive.operation.seconds_asked(primitive.arguments)
        if not needed_s < deadline_s:
            return (
                "deadline",
                f"This step needs at least {needed_s:.1f} s, and only {max(deadline_s, 0):.1f} s are left.",
            )
        return None

    def _hindered(self, primitive: Primitive) -> Refusal | None:
        hindrance = self.enter_room([primitive])
        return (hindrance.reason, hindrance.sentence) if hindrance is not None else None

    def _prepare(self, primitive: Primitive) -> None:
        """Wait briefly for data that is still missing because the driver or the robot has just started."""
        end_s = self._now_s() + PREPARE_S
        while self._now_s() < end_s and (state := sanitized(self._robot.state())).age_s < PREPARE_S:
            if state.upright is False:  # it can only stand up, which needs neither
                return
            seen = self._ranges.enough and (not self._ranges.unknown(primitive) or self._ranges.settled)
            if seen and (self._fence is not None or not self._settings.homes_itself):
                return
            self._wait(1 / OBSERVE_HZ)

    # ------------------------------------------------------------ during a step
    def _look(self, primitive: Primitive, until_s: float) -> str | None:
        word, self._sentence = self._violation(primitive, until_s) or (None, self._sentence)
        return word

    def _violation(self, primitive: Primitive, until_s: float) -> Refusal | None:
        state = self._take_in()
        self._crash_marker.refresh(state.mode)
        if self._halt.why is not None:
            return "halted", self._halt.why
        if state.age_s >= STATE_AGE_S or state.pose is None:
            self._broken = self._broken or LOST
            return "stale_state", _unseen(state) or f"The robot's state was {_age(state)}."
        if fallen := _fallen(state, primitive):
            return fallen
        if self._fence is None and not self._getting_up:
            return "odometry_jump", self._lost_home
        if self._now_s() >= until_s:
            return "deadline", "The time for this step was over."
        return self._misled(primitive, state, state.pose, self._fence)

    def _misled(self, primitive: Primitive, state: RobotState, pose: Pose, fence: Fence | None) -> Refusal | None:
        """Return what is wrong with where the step leads: its own declaration, others, the fence, an obstacle."""
        if reason := self._check_travel(primitive, pose):
            return reason, ""  # the sentence is added when the robot rests
        speed_mps = math.hypot(*state.velocity_mps) if state.velocity_mps else (primitive.speed_mps or 0.0)
        goes_its_way = primitive.travel_m > 0 and not primitive.walks
        ahead_m = speed_mps * STOPPING_S if primitive.op is Op.MOVE else 0.0
        limit_mps = self.capabilities.limits.speed_mps
        if goes_its_way and speed_mps > limit_mps + _FASTER_MPS:
            return "limit_speed_mps", f"It went at {speed_mps:.2f} m/s, and {limit_mps:g} m/s are allowed."
        if self._room is not None and (hindrance := self._room.violation(primitive, ahead_m)) is not None:
            return hindrance.reason, hindrance.sentence
        velocity_mps = state.velocity_mps or (0.0, 0.0)
        rest = onward(pose, velocity_mps, STOPPING_S) if goes_its_way else ahead(pose, primitive, ahead_m)
        if fence is not None and not (outside_m := fence.outside_m(*rest)) <= 0:
            return "fence", f"It would have come to rest {outside_m:.2f} m outside its fence."
        if self._ranges.unknown(primitive):
            slow = (primitive.speed_mps or math.inf) <= BLIND_MPS
            if not (slow and self._settings.allow_unknown_ranges):
                return "ranges_unknown", "Its range readings stopped changing or went missing on the way."
            self._blind = True
        sentence = self._ranges.obstacle(primitive, speed_mps)
        return ("obstacle", sentence) if sentence else None

    # ------------------------------------------------------------ always
    def _observe(self) -> None:
        while not self._closed.wait(1 / OBSERVE_HZ):
            try:
                self._take_in()
            except Exception:  # the observer must survive any error of one state
                log.exception("the guard could not read the robot's state")

    def _take_in(self) -> RobotState:
        """Process the newest state and return it. It is read under the lock: states that threads brought along could
        arrive out of order."""
        with self._looking:
            asked_s = self._now_s()
            state, now_s = sanitized(self._robot.state()), self._now_s()
            self._ranges.update(now_s, state)  # an old state too: what was seen before it must not stay
            jumped = self._odometry.update(now_s, state, asked_s)
            self._broken = JUMPED if jumped else self._broken
            why = jumped or ("the robot fell" if state.upright is False else "")
            if why and self._fence is not None:
                self._fence, self._lost_home = None, f"Home is void: {why}."
                log.warning("%s", self._lost_home)
            if why and self._room is not None:
                self._room.lose_frame(why)
            if self._room is not None:
                self._room.observe(state.pose, state.age_s, self._at_home(state.pose))
            running = self._running
            walking = running is not None and running.op in WALKS
            foreign = self._takeover.update(
                now_s, state, walking=walking, gesturing=running is not None and not walking
            )
        if foreign and self._halt.why is None:
            self._halt.set("the guard", foreign + ".")  # at once; the thread below stops and writes it down
            threading.Thread(target=self.halt, args=("the guard", foreign + "."), daemon=True).start()
        fit = running is None and state.pose is not None and state.age_s < STATE_AGE_S and state.upright
        if self._settings.homes_itself and self._fence is None and fit and self._odometry.still(now_s):
            self.home("the simulation")
        return state


def sanitized(state: RobotState) -> RobotState:
    """Return the state with NaN and infinite values replaced by unknown."""
    velocity_mps, age_s = state.velocity_mps, state.age_s
    if velocity_mps is not None and not all(map(math.isfinite, velocity_mps)):
        velocity_mps = None
    age_s = age_s if age_s >= 0 else math.inf
    percent = state.battery_percent if state.battery_percent is not None and state.battery_percent >= 0 else None
    return replace(state, pose=known(state.pose), velocity_mps=velocity_mps, age_s=age_s, battery_percent=percent)


def _fallen(state: RobotState, primitive: Primitive) -> Refusal | None:
    """Refuse everything but standing up while the robot lies or may lie."""
    if state.upright is False and primitive.op is not Op.STAND:
        return "fallen", "The robot has fallen. It stays down until it is asked to stand up, or somebody sets it up."
    if state.upright is None or (state.upright and state.mode == "fallen"):
        return "fallen", "The robot is not known to stand upright."
    return None


def _low_battery(state: RobotState, settings: RobotConfig) -> str:
    """Return why no motion may begin; empty if the charge suffices or is not reported."""
    percent, least = state.battery_percent, settings.least_battery_percent
    if percent is None or percent >= least:
        return ""
    return f"The battery is at {percent:.0f} %, and below {least:g} % no motion begins (least_battery_percent)."


def _age(state: RobotState) -> str:
    return "unknown" if math.isinf(state.age_s) else f"{state.age_s:.1f} s old"


def _unseen(state: RobotState) -> str:
    """Return what is wrong with a recent state; empty if it is only too old."""
    young = state.age_s < STATE_AGE_S and state.pose is None
    return "The robot tells no position: its odometry is missing or not a number." if young else ""


def _refused(primitive: Primitive, word: str, sentence: str) -> ActionResult:
    now_s = time.monotonic()
    return ActionResult(primitive, Outcome.REFUSED, {}, word, sentence, now_s, now_s)
