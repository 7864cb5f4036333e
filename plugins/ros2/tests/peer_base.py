"""A differential base in real ROS 2: an rclpy node around `agentrob_ros2.simulation`; run with the Python of the peers.

    .venv-ros2/bin/python plugins/ros2/tests/peer_base.py [--speed 0.5 --clock] [--scan-qos best_effort] …

It prints `{"ready": true}`, then answers each JSON line on standard input with one of the base's truth (see
`Simulation.apply`); `{"commands": true}` also returns the velocities that it heard, as (monotonic seconds, m/s, rad/s).
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import sys
import threading
import time
from pathlib import Path
from typing import Any

import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy._rclpy_pybind11 import RCLError
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import BatteryState, CompressedImage, Image, LaserScan
from test_msgs.action import Fibonacci

sys.path.insert(0, str(Path(__file__).parents[1] / "src"))
from agentrob_ros2.simulation import BATTERY, ODOM, SCAN, Simulation

TICK_S = 0.01


def stamp(seconds: float) -> Time:
    whole = int(seconds)
    return Time(sec=whole, nanosec=int((seconds - whole) * 1e9))


def qos(reliability: str) -> QoSProfile:
    kind = QoSReliabilityPolicy.BEST_EFFORT if reliability == "best_effort" else QoSReliabilityPolicy.RELIABLE
    return QoSProfile(depth=10, reliability=kind, durability=QoSDurabilityPolicy.VOLATILE)


class Base(Node):
    def __init__(self, args: argparse.Namespace) -> None:
        super().__init__("base", namespace=args.namespace)
        self.simulation = Simulation(start_s=100.0 if args.clock else time.time())
        self.commands: list[tuple[float, float, float]] = []
        self.lock = threading.Lock()
        self.speed, self.last_s = args.speed, time.monotonic()
        kind = TwistStamped if args.stamped else Twist
        self.create_subscription(kind, args.cmd_vel, self.command, qos(args.cmd_vel_qos))
        self.odom = self.create_publisher(Odometry, "odom", qos(args.odom_qos))
        self.scan = self.create_publisher(LaserScan, "scan", qos(args.scan_qos))
        self.battery = self.create_publisher(BatteryState, "battery_state", qos("reliable"))
        self.clock = self.create_publisher(Clock, "/clock", qos("reliable")) if args.clock else None
        self.image = self.create_publisher(Image, "image_raw", qos("best_effort")) if args.image else None
        self.jpeg = (
            self.create_publisher(CompressedImage, "image_raw/compressed", qos("best_effort")) if args.image else None
        )
        self.ticks = 0
        self.create_timer(TICK_S, self.tick)

    def command(self, message: Any) -> None:
        now_s = time.monotonic()
        twist = message.twist if isinstance(message, TwistStamped) else message
        with self.lock:
            self.commands.append((now_s, twist.linear.x, twist.angular.z))
            self.simulation.base.command(twist.linear.x, twist.angular.z)

    def tick(self) -> None:
        now_s = time.monotonic()
        with self.lock:
            samples = self.simulation.tick(self.speed * (now_s - self.last_s))
            at_s = self.simulation.now_s
        self.last_s = now_s
        if self.clock is not None:
            self.clock.publish(Clock(clock=stamp(at_s)))
        if (sample := samples.get(ODOM)) is not None:
            self.publish_odom(sample)
        if (sample := samples.get(SCAN)) is not None:
            self.publish_scan(sample)
        if (sample := samples.get(BATTERY)) is not None:
            message = BatteryState(percentage=float(sample.percentage), present=True)
            message.header.stamp = stamp(sample.stamp_s)
            self.battery.publish(message)
        self.ticks += 1
        if self.image is not None and self.ticks % 10 == 0:
            self.publish_image(at_s)

    def publish_odom(self, sample: Any) -> None:
        message = Odometry(child_frame_id="base_link")
        message.header.frame_id, message.header.stamp = "odom", stamp(sample.stamp_s)
        pose, twist = message.pose.pose, message.twist.twist
        pose.position.x, pose.position.y = sample.x_m, sample.y_m
        o = pose.orientation
        o.x, o.y, o.z, o.w = sample.quaternion
        twist.linear.x, twist.angular.z = sample.forward_mps, sample.turn_rps
        self.odom.publish(message)

    def publish_scan(self, sample: Any) -> None:
        message = LaserScan(
            angle_min=0.0,
            angle_max=float(sample.increment_rad * (len(sample.ranges) - 1)),
            angle_increment=float(sample.increment_rad),
            range_min=float(sample.range_min),
            range_max=float(sample.range_max),
            ranges=sample.ranges,
        )
        message.header.frame_id, message.header.stamp = "laser", stamp(sample.stamp_s)
        self.scan.publish(message)

    def publish_image(self, at_s: float) -> None:
        width, height = 64, 48
        row = bytes(value for x in range(width) for value in (4 * x, 80, 255 - 4 * x))
        message = Image(width=width, height=height, encoding="rgb8", step=3 * width, data=row * height)
        message.header.stamp = stamp(at_s)
        self.image.publish(message)
        picture = CompressedImage(format="jpeg", data=b"\xff\xd8\xff\xe0" + bytes(2000) + b"\xff\xd9")
        picture.header.stamp = stamp(at_s)
        self.jpeg.publish(picture)


class Navigator:
    """Stands for Nav2: an action server that drives to one of `PLACES` over /cmd_vel, as a controller does. PyPI has no
    nav2_msgs, so its goal is that of `Fibonacci`: the number of the place."""

    PLACES = ((1.5, 0.0), (-1.5, 1.0))
    MPS, RPS, HZ, NEAR_M = 0.35, 0.7, 20.0, 0.08

    def __init__(self, base: Base) -> None:
        self.base, self.mode, self.poses = base, "", []
        node = Node("navigator", namespace=base.get_namespace())
        self.publisher = node.create_publisher(Twist, "cmd_vel", 10)
        node.create_subscription(PoseStamped, "/pose_check", self.poses.append, 10)
        self.server = ActionServer(
            node,
            Fibonacci,
            "navigate_to_pose",
            execute_callback=self.drive,
            goal_callback=lambda _: GoalResponse.REJECT if self.mode == "reject" else GoalResponse.ACCEPT,
            cancel_callback=lambda _: CancelResponse.REJECT if self.mode == "deaf" else CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )
        executor = MultiThreadedExecutor(2)  # of its own, so that the base's odometry comes steadily
        executor.add_node(node)
        threading.Thread(target=executor.spin, daemon=True).start()

    def drive(self, goal: Any) -> Fibonacci.Result:
        target_x, target_y = self.PLACES[goal.request.order]
        while True:
            with self.base.lock:
                truth = self.base.simulation.base
                x, y, yaw = target_x - truth.x_m, target_y - truth.y_m, truth.yaw_rad
            off = (math.atan2(y, x) - yaw + math.pi) % (2 * math.pi) - math.pi
            twist = Twist()
            if goal.is_cancel_requested:
                self.publisher.publish(twist)
                goal.canceled()
                return Fibonacci.Result()
            if self.mode == "abort":
                self.publisher.publish(twist)
                goal.abort()
                return Fibonacci.Result()
            if math.hypot(x, y) < self.NEAR_M or self.mode == "lie":
                self.publisher.publish(twist)
                goal.succeed()
                return Fibonacci.Result()
            twist.angular.z = max(-self.RPS, min(self.RPS, 2.0 * off))
            twist.linear.x = (1.0 if self.mode == "fast" else self.MPS) if abs(off) < 0.3 else 0.0
            self.publisher.publish(twist)
            time.sleep(1 / self.HZ)


def answer(base: Base, navigator: Navigator | None) -> None:
    for line in sys.stdin:
        what = json.loads(line)
        if navigator is not None:
            navigator.mode = what.get("navigator", navigator.mode)
        with base.lock:
            facts = base.simulation.apply(what)
            if "commands" in what:
                facts["commands"], base.commands = base.commands, []
        if navigator is not None and "poses" in what:
            facts["poses"] = [
                (p.header.frame_id, p.pose.position.x, p.pose.position.y, p.pose.orientation.z, p.pose.orientation.w)
                for p in navigator.poses
            ]
        print(json.dumps(facts), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--namespace", default="")
    parser.add_argument("--cmd-vel", default="cmd_vel")
    parser.add_argument("--stamped", action="store_true")
    parser.add_argument("--clock", action="store_true")
    parser.add_argument("--speed", type=float, default=1.0)
    parser.add_argument("--image", action="store_true")
    parser.add_argument("--navigator", action="store_true")
    for topic in ("odom", "scan", "cmd-vel"):
        parser.add_argument(f"--{topic}-qos", choices=("reliable", "best_effort"), default="reliable")
    rclpy.init(args=[])
    args = parser.parse_args()
    base = Base(args)
    navigator = Navigator(base) if args.navigator else None
    threading.Thread(target=answer, args=(base, navigator), daemon=True).start()
    print(json.dumps({"ready": True}), flush=True)
    with contextlib.suppress(KeyboardInterrupt, rclpy.executors.ExternalShutdownException, RCLError):
        rclpy.spin(base)


if __name__ == "__main__":
    main()
