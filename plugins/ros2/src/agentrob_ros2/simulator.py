"""The simulated base of the demo: publishes the topics of a ROS 2 base over Cyclone DDS, without a ROS installation.

    agentrob simulator ros2-sim --domain 42

Any ROS 2 node on the same domain and interface sees it, and may drive it.
"""

from __future__ import annotations

import math
import threading
import time
from typing import Any

from agentrob.config.map import MapConfig, MapThing
from agentrob.config.robots import RobotConfig
from agentrob.process.child import print_ready
from agentrob_ros2 import messages
from agentrob_ros2.network import Node, Subscription, qos_of
from agentrob_ros2.options import CommandOptions, TopicOptions
from agentrob_ros2.simulated_base import ROOM, ROOM_M, Pillar
from agentrob_ros2.simulation import BATTERY, ODOM, SCAN, BatterySample, OdomSample, ScanSample, Simulation

TICK_S = 0.01
RELIABLE = TopicOptions(reliability="reliable")
BASE_FRAME, LASER_FRAME = "base_link", "laser"


class Simulator:
    """Publishes a simulation in real time, in a thread, until `close`."""

    def __init__(self, domain: int, interface: str = "lo", seed: int = 7) -> None:
        self.simulation = Simulation(start_s=time.time(), seed=seed)
        self.commands: list[tuple[float, float, float]] = []  # monotonic seconds, m/s, rad/s
        self._lock, self._ended = threading.Lock(), threading.Event()
        self._node = Node(domain, interface)
        offered = CommandOptions()
        self._odom = self._node.writer("/odom", messages.Odometry, qos_of(offered))
        self._tf = self._node.writer("/tf", messages.TFMessage, qos_of(offered))
        static = CommandOptions(durability="transient_local")
        self._static = self._node.writer("/tf_static", messages.TFMessage, qos_of(static))
        self._scan = self._node.writer("/scan", messages.LaserScan, qos_of(offered))
        self._battery = self._node.writer("/battery_state", messages.BatteryState, qos_of(offered))
        self._commands = Subscription(self._node, "/cmd_vel", messages.Twist, RELIABLE, self._command, depth=10)
        mount = messages.Transform(messages.Vector3(0.0, 0.0, 0.2), messages.Quaternion())
        header = messages.Header(messages.Time(), BASE_FRAME)
        self._static.write(messages.TFMessage([messages.TransformStamped(header, LASER_FRAME, mount)]))
        self._thread = threading.Thread(target=self._run, name="ros2 simulator", daemon=True)
        self._thread.start()

    def apply(self, what: dict[str, Any]) -> dict[str, Any]:
        """See `Simulation.apply`; with `commands`, also the velocities that were heard since the last time."""
        with self._lock:
            facts = self.simulation.apply(what)
            if "commands" in what:
                facts["commands"], self.commands = self.commands, []
        return facts

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self._node.close()

    def _command(self, came_s: float, message: messages.Twist) -> None:
        with self._lock:
            self.commands.append((came_s, message.linear.x, message.angular.z))
            del self.commands[:-10_000]
            self.simulation.base.command(message.linear.x, message.angular.z)

    def _run(self) -> None:
        last_s = time.monotonic()
        while not self._ended.wait(TICK_S):
            now_s = time.monotonic()
            with self._lock:
                samples = self.simulation.tick(now_s - last_s)
            last_s = now_s
            if isinstance(odom := samples.get(ODOM), OdomSample):
                self._publish_odom(odom)
            if isinstance(scan := samples.get(SCAN), ScanSample):
                self._publish_scan(scan)
            if isinstance(battery := samples.get(BATTERY), BatterySample):
                header = messages.Header(messages.Time.of(battery.stamp_s))
                self._battery.write(messages.BatteryState(header, percentage=battery.percentage))

    def _publish_odom(self, sample: OdomSample) -> None:
        header = messages.Header(messages.Time.of(sample.stamp_s), "odom")
        turned = messages.Quaternion(*sample.quaternion)
        pose = messages.PoseMessage(messages.Point(sample.x_m, sample.y_m, 0.0), turned)
        twist = messages.Twist(
            messages.Vector3(sample.forward_mps, 0.0, 0.0), messages.Vector3(0.0, 0.0, sample.turn_rps)
        )
        self._odom.write(
            messages.Odometry(
                header, BASE_FRAME, messages.PoseWithCovariance(pose), messages.TwistWithCovariance(twist)
            )
        )
        moved = messages.Transform(messages.Vector3(sample.x_m, sample.y_m, 0.0), turned)
        self._tf.write(messages.TFMessage([messages.TransformStamped(header, BASE_FRAME, moved)]))

    def _publish_scan(self, sample: ScanSample) -> None:
        self._scan.write(
            messages.LaserScan(
                header=messages.Header(messages.Time.of(sample.stamp_s), LASER_FRAME),
                angle_max=sample.increment_rad * (len(sample.ranges) - 1),
                angle_increment=sample.increment_rad,
                range_min=sample.range_min,
                range_max=sample.range_max if math.isfinite(sample.range_max) else 0.0,
                ranges=sample.ranges,
            )
        )


class Ros2Simulator:
    """See `agentrob.robots.protocol.Simulator`: for the demo, and for `agentrob drive ros2-sim`."""

    def settings(self, settings: RobotConfig) -> RobotConfig:
        """The given settings, with the room's map and description."""
        return settings.model_copy(update={"map": room_map(), "scene": SCENE})

    def serve(self, settings: RobotConfig, ended: threading.Event) -> None:
        simulator = Simulator(settings.domain, settings.interface)
        try:
            print_ready(domain=settings.domain, interface=settings.interface)
            ended.wait()
        finally:
            simulator.close()


#: What stands in the room, as `ROOM` has it.
SCENE = (
    "An empty hall of 8 m by 8 m. A table in the front left corner, a plant in the back left corner, "
    "a bin in the front right corner, a shelf in the back right corner."
)


def room_map() -> MapConfig:
    things = []
    for one in ROOM:
        shape: dict[str, Any] = (
            {"radius_m": one.radius_m} if isinstance(one, Pillar) else {"size_m": (one.length_m, one.width_m)}
        )
        things.append(MapThing(name=one.name, at_m=(one.x_m, one.y_m), colour=one.colour, **shape))
    return MapConfig(room="ros 2 hall", size_m=(ROOM_M, ROOM_M), things=tuple(things), geometry="none")
