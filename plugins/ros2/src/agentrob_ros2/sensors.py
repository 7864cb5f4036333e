"""The state of a base from its topics: position, ranges, attitude, charge, and why one of them is missing."""

from __future__ import annotations

import logging
import math
import threading
import time
from dataclasses import dataclass
from typing import Any

from agentrob.model import Pose, RobotState
from agentrob.robots.control.clock import Clock, StampClock
from agentrob.robots.control.controller import rotate, wrap
from agentrob_ros2 import messages, readings
from agentrob_ros2.network import Node, Subscription
from agentrob_ros2.options import Ros2Options, TopicOptions
from agentrob_ros2.pose_speed import PoseSpeed

log = logging.getLogger(__name__)

#: Older ranges are unknown; so is an older attitude.
SCAN_AGE_S = 0.5
#: A charge is told rarely.
BATTERY_AGE_S = 60.0
#: Where it is on the map is told at least this often by a base that is localised.
LOCALISED_S = 5.0
#: `/tf_static` is kept for those who come later.
STATIC = TopicOptions(reliability="reliable", durability="transient_local")
MOVING_MPS, MOVING_RPS = 0.02, 0.05


@dataclass(frozen=True, slots=True)
class Position:
    """Where it was by the message that came at `came_s`; its velocity is forward and left in m/s, and rad/s."""

    came_s: float
    stamp_s: float
    pose: Pose | None
    velocity: tuple[float, float, float] | None
    upright: bool | None


class Sensors:
    """Subscribes to the topics of the options. Thread-safe: DDS threads replace what `state` reads."""

    def __init__(self, node: Node, options: Ros2Options, clock: Clock) -> None:
        self._node, self._options = node, options
        self._position: Position | None = None
        self._pose_speed = PoseSpeed()
        self._ranges: tuple[float, readings.Ranges] | None = None
        self._tilt: tuple[float, bool | None] | None = None
        self._percent: tuple[float, float | None] | None = None
        self._wrong: dict[str, str] = {}  # by topic
        self._static, self._static_lock = readings.StaticTransforms(), threading.Lock()
        self._mount = readings.mount_of(options.scan)
        self._mounts: dict[str, readings.Mount | None] = {}
        self._sim_time: tuple[float, float] | None = None  # (monotonic, ROS) seconds
        self._scan_stamp_s = math.nan
        self._on_map: tuple[float, Pose] | None = None
        pose, scan, imu, battery = options.pose, options.scan, options.imu, options.battery
        subscribe = self._subscribe
        if pose.source == "odom":
            self.pose: Subscription[Any] = subscribe(options.pose_topic, messages.Odometry, pose, self._odometry)
        else:
            self.pose = subscribe(options.pose_topic, messages.TFMessage, pose, self._transforms, depth=20)
        self.scan: Subscription[Any] | None = None
        self._kept = []
        if scan.topic:
            if self._mount is None:
                self._kept.append(subscribe("/tf_static", messages.TFMessage, STATIC, self._statics, depth=100))
            self.scan = subscribe(options.absolute(scan.topic), messages.LaserScan, scan, self._scanned)
        if options.places and pose.source == "odom":
            self._kept.append(subscribe("/tf", messages.TFMessage, TopicOptions(), self._localised, depth=50))
        if imu.topic:
            self._kept.append(subscribe(options.absolute(imu.topic), messages.Imu, imu, self._attitude))
        if battery.topic:
            self._kept.append(subscribe(options.absolute(battery.topic), messages.BatteryState, battery, self._charge))
        if isinstance(clock, StampClock):
            self._kept.append(
                subscribe("/clock", messages.Clock, TopicOptions(), lambda at, m: self._ticked(clock, at, m), depth=10)
            )

    def _subscribe(self, topic: str, kind: Any, options: TopicOptions, heard: Any, depth: int = 1) -> Subscription[Any]:
        return Subscription(self._node, topic, kind, options, heard, depth)

    # ------------------------------------------------------------ what is known now
    def state(self) -> RobotState:
        position, now_s = self._position, time.monotonic()
        if position is None:
            return RobotState(age_s=math.inf, ranges_m=self._ranges_now(now_s))
        velocity = position.velocity
        fast = velocity is not None and (math.hypot(*velocity[:2]) > MOVING_MPS or abs(velocity[2]) > MOVING_RPS)
        upright = position.upright
        if self._options.imu.topic:
            upright = self._tilt[1] if self._tilt is not None and now_s - self._tilt[0] < SCAN_AGE_S else None
        percent = self._percent
        return RobotState(
            age_s=now_s - position.came_s,
            pose=position.pose,
            velocity_mps=None if velocity is None else velocity[:2],
            yaw_rate_rps=None if velocity is None else velocity[2],
            mode="fallen" if upright is False else "walking" if fast else "idle",
            battery_percent=percent[1] if percent is not None and now_s - percent[0] < BATTERY_AGE_S else None,
            ranges_m=self._ranges_now(now_s),
            upright=upright,
        )

    def _ranges_now(self, now_s: float) -> readings.Ranges:
        ranges = self._ranges
        return ranges[1] if ranges is not None and now_s - ranges[0] < SCAN_AGE_S else readings.UNKNOWN

    def ros_time_s(self) -> float:
        """The time of ROS: that of `/clock` in simulation, else this machine's."""
        return time.time() if self._sim_time is None else self._sim_time[1] + time.monotonic() - self._sim_time[0]

    def silence(self) -> str:
        """Sentences on what is missing or wrong; empty if all comes as it should."""
        return " ".join(self.missing().values())

    def missing(self) -> dict[str, str]:
        """A sentence for each topic of the position and the scan that is missing or wrong."""
        now_s, found = time.monotonic(), dict[str, str]()
        fresh = self._position is not None and now_s - self._position.came_s < SCAN_AGE_S
        if wrong := self._wrong.get(self.pose.topic):
            found[self.pose.topic] = f"{self.pose.topic} cannot be used: {wrong}."
        elif not fresh:
            found[self.pose.topic] = self._missing(self.pose, self._position is not None)
        if self.scan is not None:
            if wrong := self._wrong.get(self.scan.topic):
                found[self.scan.topic] = f"{self.scan.topic} cannot be used: {wrong}."
            elif self._ranges is None or now_s - self._ranges[0] >= SCAN_AGE_S:
                found[self.scan.topic] = self._missing(self.scan, self._ranges is not None)
        return found

    def _missing(self, subscription: Subscription[Any], before: bool) -> str:
        came_s = subscription.came_s
        if came_s is not None and time.monotonic() - came_s < SCAN_AGE_S:
            what = "repeats an old message: its stamp does not advance" if before else self._no_transform()
            return f"{subscription.topic} {what}."
        return self._node.silence(subscription)

    def _no_transform(self) -> str:
        pose = self._options.pose
        if pose.source == "tf":
            return f"has no transform from {pose.odom_frame} to {pose.base_frame}"
        return "comes without a position"

    # ------------------------------------------------------------ what comes, in DDS threads
    def _odometry(self, came_s: float, message: messages.Odometry) -> None:
        stamp_s, at = message.header.stamp.seconds, message.pose.pose
        if self._repeated(stamp_s):
            return
        pose, wrong = readings.pose_of(at.position.x, at.position.y, at.orientation)
        twist = message.twist.twist
        velocity = (twist.linear.x, twist.linear.y, twist.angular.z)
        known = velocity if all(map(math.isfinite, velocity)) else None
        self._take(Position(came_s, stamp_s, pose, known, readings.upright_of(at.orientation)), wrong)

    def _localised(self, came_s: float, message: messages.TFMessage) -> None:
        """Take where the odometry frame is on the map."""
        frame, odom = self._options.navigation.frame, self._options.pose.odom_frame
        for one in message.transforms:
            if (one.header.frame_id.lstrip("/"), one.child_frame_id.lstrip("/")) == (frame, odom):
                at = one.transform
                pose, wrong = readings.pose_of(at.translation.x, at.translation.y, at.rotation)
                self._note(f"the transform from {frame} to {odom}", wrong)
                self._on_map = None if pose is None else (came_s, pose)

    def on_map(self, pose: Pose) -> Pose | None:
        """A pose of the odometry on the map; None if the base is not localised there."""
        if self._on_map is None or time.monotonic() - self._on_map[0] > LOCALISED_S:
            return None
        odom = self._on_map[1]
        x, y = rotate(pose.x_m, pose.y_m, odom.yaw_rad)
        return Pose(odom.x_m + x, odom.y_m + y, wrap(odom.yaw_rad + pose.yaw_rad))

    def _transforms(self, came_s: float, message: messages.TFMessage) -> None:
        options = self._options.pose
        if self._options.places:
            self._localised(came_s, message)
        for one in message.transforms:
            if (one.header.frame_id.lstrip("/"), one.child_frame_id.lstrip("/")) == (
                options.odom_frame,
                options.base_frame,
            ):
                stamp_s, at = one.header.stamp.seconds, one.transform
                if self._repeated(stamp_s):
                    continue
                pose, wrong = readings.pose_of(at.translation.x, at.translation.y, at.rotation)
                upright = readings.upright_of(at.rotation)
                self._take(
                    Position(came_s, stamp_s, pose, self._pose_speed.update(came_s, stamp_s, pose), upright), wrong
                )

    def _repeated(self, stamp_s: float) -> bool:
        """Whether this message is an old one once more. Messages without a stamp count as new."""
        return self._position is not None and stamp_s == self._position.stamp_s and stamp_s != 0.0

    def _take(self, position: Position, wrong: str) -> None:
        self._note(self.pose_topic, wrong)
        self._position = position

    @property
    def pose_topic(self) -> str:
        return self._options.pose_topic

    def _statics(self, came_s: float, message: messages.TFMessage) -> None:
        with self._static_lock:
            for one in message.transforms:
                self._static.add(one.header.frame_id, one.child_frame_id, one.transform)
            self._mounts.clear()

    def _scanned(self, came_s: float, message: messages.LaserScan) -> None:
        stamp_s = message.header.stamp.seconds
        if stamp_s == self._scan_stamp_s and stamp_s != 0.0:
            return
        self._scan_stamp_s = stamp_s
        topic = self._options.absolute(self._options.scan.topic)
        if (mount := self._mounted(message.header.frame_id)) is None:
            base = self._options.pose.base_frame
            self._ranges = came_s, readings.UNKNOWN
            self._note(topic, f"/tf_static has no transform from {base} to {message.header.frame_id}; set scan.mount_m")
            return
        ranges, wrong = readings.ranges_of(message, mount, self._options.body)
        self._ranges = came_s, ranges
        self._note(topic, wrong)

    def _mounted(self, frame: str) -> readings.Mount | None:
        if self._mount is not None:
            return self._mount
        with self._static_lock:
            if frame not in self._mounts:
                self._mounts[frame] = self._static.mount(self._options.pose.base_frame, frame)
            return self._mounts[frame]

    def _attitude(self, came_s: float, message: messages.Imu) -> None:
        unknown = message.orientation_covariance[0] < 0  # as sensor_msgs says
        self._tilt = came_s, None if unknown else readings.upright_of(message.orientation)

    def _charge(self, came_s: float, message: messages.BatteryState) -> None:
        percent, wrong = readings.percent_of(message)
        self._percent = came_s, percent
        self._note(self._options.absolute(self._options.battery.topic), wrong)

    def _ticked(self, clock: StampClock, came_s: float, message: messages.Clock) -> None:
        self._sim_time = came_s, message.clock.seconds
        clock.take(came_s, message.clock.seconds)

    def _note(self, topic: str, wrong: str) -> None:
        """Keep what is wrong with a topic, and log it when it begins."""
        if wrong and self._wrong.get(topic) != wrong:
            log.warning("%s: %s", topic, wrong)
        if wrong:
            self._wrong[topic] = wrong
        else:
            self._wrong.pop(topic, None)
