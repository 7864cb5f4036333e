"""Examine a base that no driver holds: the domain, its topics with their QoS, and its state. Publishes nothing."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Sequence

from agentrob.config.robots import RobotConfig
from agentrob.errors import RobotBusy, RobotUnreachable
from agentrob.robots.control.clock import HostClock, StampClock
from agentrob.robots.diagnostics import findings
from agentrob.robots.diagnostics.findings import Finding, Status
from agentrob_ros2 import messages
from agentrob_ros2.network import Node, qos_of
from agentrob_ros2.options import Ros2Options, options_of
from agentrob_ros2.sensors import Sensors

#: Seconds to discover the base and to get its first messages, and to look into other domains.
FIND_S, SEARCH_S = 4.0, 2.0
#: Where else a base is looked for; ROS uses 0 unless ROS_DOMAIN_ID is set.
DOMAINS = range(10)


def examine(settings: RobotConfig) -> list[Finding]:
    """Return what a driver would find; the order is that in which to mend it."""
    options = options_of(settings)
    try:
        node = Node(settings.domain, settings.interface, options.peers)
    except (RobotUnreachable, RobotBusy) as e:
        return [Finding("interface", Status.BAD, str(e), "Name one that DDS can use.", "ip link")]
    try:
        return [Finding("interface", Status.OK, node.where), *_of_topics(node, settings, options)]
    finally:
        node.close()


def _of_topics(node: Node, settings: RobotConfig, options: Ros2Options) -> list[Finding]:
    sensors = Sensors(node, options, StampClock() if options.use_sim_time else HostClock())
    command = options.cmd_vel
    topic, kind = options.absolute(command.topic), messages.TwistStamped if command.stamped else messages.Twist
    writer = node.writer(topic, kind, qos_of(command))
    end_s, deaf = time.monotonic() + FIND_S, ""
    while time.monotonic() < end_s:
        deaf = node.deafness(topic, kind, command, writer)
        if not deaf and not sensors.missing():
            break
        time.sleep(0.1)
    there, missing = node.published(), sensors.missing()
    if not there:
        return [_nobody(settings, options)]
    found = [Finding("domain", Status.OK, f"{len(there)} topics are published on ROS domain {settings.domain}")]
    if missing and not there & {options.pose_topic, options.absolute(options.scan.topic)}:
        found = [_other_names(settings, options, there)]
    found += [
        _topic("position", options.pose_topic, missing, "[robots.NAME.options] pose names its topic and QoS."),
        _topic(
            "scan",
            sensors.scan.topic if sensors.scan else "",
            missing,
            "[robots.NAME.options] scan names its topic and QoS.",
        ),
        Finding("commands", Status.BAD, deaf, "[robots.NAME.options] cmd_vel names its topic, QoS and `stamped`.")
        if deaf
        else Finding("commands", Status.OK, f"{topic} has a subscriber"),
    ]
    if options.pose_topic not in missing:
        state = sensors.state()
        found += [*findings.of_state(state), findings.of_battery(state.battery_percent, settings)]
    return [*found, *findings.of_settings(settings)]


def _topic(check: str, topic: str, missing: dict[str, str], advice: str) -> Finding:
    """Describe the fault of a topic in the words of the refusal that a driver would give."""
    if not topic:
        return Finding(check, Status.WARNING, "it has no topic in its options, so nothing is seen ahead", advice)
    if topic in missing:
        return Finding(check, Status.BAD, missing[topic], advice)
    return Finding(check, Status.OK, f"{topic} comes")


def _nobody(settings: RobotConfig, options: Ros2Options) -> Finding:
    """Nobody publishes on this domain: name another one where the base is heard."""
    what = f"nothing is published on ROS domain {settings.domain}"
    again = f"agentrob doctor {settings.model} --interface {settings.interface or 'lo'} --domain"
    if elsewhere := _elsewhere(settings, options):
        advice = f"Set domain = {elsewhere[0]} in its table: that is the robot's ROS_DOMAIN_ID."
        found = f"{what}, but {options.pose_topic} is published on domain {elsewhere[0]}"
        return Finding("domain", Status.BAD, found, advice, f"{again} {elsewhere[0]}")
    advice = (
        "Does the base run? Its ROS_DOMAIN_ID must be domain, and its ROS_LOCALHOST_ONLY must be 0 if it is another "
        "computer. Where multicast is held back, name its address: [robots.NAME.options] peers."
    )
    return Finding("domain", Status.BAD, what, advice, "ros2 topic list  # on the base")


def _elsewhere(settings: RobotConfig, options: Ros2Options) -> Sequence[int]:
    """Other domains on which the position is published."""
    with contextlib.ExitStack() as until_done:
        nodes = []
        for number in DOMAINS:
            if number != settings.domain:
                with contextlib.suppress(RobotUnreachable, RobotBusy):
                    nodes.append(node := Node(number, settings.interface, options.peers))
                    until_done.callback(node.close)
        end_s = time.monotonic() + SEARCH_S
        while time.monotonic() < end_s:
            if found := [node.domain for node in nodes if options.pose_topic in node.published()]:
                return found
            time.sleep(0.1)
    return ()


def _other_names(settings: RobotConfig, options: Ros2Options, there: frozenset[str]) -> Finding:
    """The domain is right, but the topics have other names: most often they are in a namespace."""
    stem = options.pose_topic.rpartition("/")[2]
    alike = sorted(topic for topic in there if topic.rpartition("/")[2] == stem)
    known = ", ".join(alike or sorted(there)[:8])
    space = alike[0].rpartition("/")[0].strip("/") if alike else ""
    advice = (
        f'Set namespace = "{space}" in [robots.NAME.options].' if space else "Set the topics in [robots.NAME.options]."
    )
    found = f"neither position nor scan is published on domain {settings.domain} under these names; there is {known}"
    return Finding("domain", Status.BAD, found, advice)
