"""One participant in a ROS 2 domain: its publishers and subscriptions, and why a topic does not come.

ROS's rules are kept: DDS topics are `rt` and the ROS name, types end in `_`, and default QoS is reliable, volatile and
keep last. Type information of Fast DDS 3 (the default of Kilted and newer) is ignored by a setting of Cyclone DDS,
because the part that describes fixed arrays is not valid: types then match by their names, as in older distributions.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any, Generic, TypeVar
from xml.sax.saxutils import quoteattr

from agentrob.process import dds  # before any IDL type is built

# isort: split
from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication, BuiltinTopicDcpsSubscription
from cyclonedds.core import DDSException, InstanceState, ReadCondition, SampleState, ViewState
from cyclonedds.domain import Domain
from cyclonedds.internal import InvalidSample
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.util import duration

from agentrob.errors import RobotBusy, RobotUnreachable
from agentrob_ros2.options import CommandOptions, TopicOptions

M = TypeVar("M")

#: eProsima Fast DDS, in the notation of Cyclone DDS.
FAST_DDS = "1.15"
#: A write never blocks longer: a stop must not wait for a subscriber that does not acknowledge.
WRITE_MS = 20
_CONFIG = (
    '<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface {interface} priority="default" '
    'multicast="default"/></Interfaces></General><Compatibility><IgnoreTypeInformation>{vendor}'
    "</IgnoreTypeInformation></Compatibility>{discovery}</Domain></CycloneDDS>"
)


def config(interface: str, peers: tuple[str, ...] = ()) -> str:
    """The configuration of Cyclone DDS for an interface, with addresses that are also looked for without multicast."""
    where = f"name={quoteattr(interface)}" if interface else 'autodetermine="true"'
    listed = "".join(f"<Peer Address={quoteattr(peer)}/>" for peer in peers)
    discovery = f"<Discovery><Peers>{listed}</Peers></Discovery>" if peers else ""
    return _CONFIG.format(interface=where, vendor=FAST_DDS, discovery=discovery)


def ros_type(kind: Any) -> str:
    """The type's name as ROS writes it: `sensor_msgs/msg/LaserScan`."""
    return readable(kind.__idl_typename__)


def readable(dds_name: str) -> str:
    return dds_name.replace("dds_::", "").replace("::", "/").removesuffix("_")


def qos_of(options: TopicOptions | CommandOptions, depth: int = 1) -> Qos:
    reliability = (
        Policy.Reliability.Reliable(duration(milliseconds=WRITE_MS))
        if options.reliability == "reliable"
        else Policy.Reliability.BestEffort
    )
    durability = (
        Policy.Durability.TransientLocal if options.durability == "transient_local" else Policy.Durability.Volatile
    )
    return Qos(reliability, durability, Policy.History.KeepLast(depth))


class Subscription(Generic[M]):
    """The newest message of a topic and when it came, in monotonic seconds; `heard` gets each, in a DDS thread."""

    def __init__(
        self,
        node: Node,
        topic: str,
        kind: type[M],
        options: TopicOptions,
        heard: Callable[[float, M], None] | None = None,
        depth: int = 1,
    ) -> None:
        self.topic, self.kind, self.options = topic, kind, options
        self.newest: tuple[float, M] | None = None
        self._heard = heard
        listener = dds.Listener(on_data_available=self._take)
        self._reader = node.reader(topic, kind, qos_of(options, depth), listener)

    def _take(self, reader: Any) -> None:
        now_s = time.monotonic()
        try:
            came = reader.take(100)
        except DDSException:  # the node was closed meanwhile
            return
        for message in came:
            if isinstance(message, InvalidSample):
                continue
            self.newest = now_s, message
            if self._heard is not None:
                self._heard(now_s, message)

    @property
    def came_s(self) -> float | None:
        return None if self.newest is None else self.newest[0]


class Node:
    """A participant of a ROS domain on one interface.

    Raises `RobotUnreachable` if DDS cannot use the interface, `RobotBusy` if this process uses the domain otherwise.
    """

    def __init__(self, domain: int, interface: str, peers: tuple[str, ...] = ()) -> None:
        self.domain, self.interface = domain, interface
        try:
            _join(domain, config(interface, peers))
            self._participant = dds.DomainParticipant(domain)
            self._published = BuiltinDataReader(self._participant, BuiltinTopicDcpsPublication)
            self._subscribed = BuiltinDataReader(self._participant, BuiltinTopicDcpsSubscription)
        except DDSException as e:
            why = f"{e.msg.strip()}; `ip link` names the interfaces"
            raise RobotUnreachable(f"DDS cannot use domain {domain} on interface {interface!r}: {why}") from None

    def close(self) -> None:
        """Leave the domain: all publishers and subscriptions end."""
        dds.delete(self._participant)

    def writer(self, topic: str, kind: Any, qos: Qos, *, prefix: str = "rt") -> Any:
        return DataWriter(self._participant, dds.Topic(self._participant, prefix + topic, kind), qos=qos)

    def reader(self, topic: str, kind: Any, qos: Qos, listener: Any = None, *, prefix: str = "rt") -> Any:
        return dds.DataReader(
            self._participant, dds.Topic(self._participant, prefix + topic, kind), qos=qos, listener=listener
        )

    # ------------------------------------------------------------ who is there
    def published(self) -> frozenset[str]:
        """The ROS topics that others publish."""
        topics = (one.topic_name for one in self._there(self._published))
        return frozenset(name.removeprefix("rt") for name in topics if name.startswith("rt/"))

    # ------------------------------------------------------------ why something does not come
    def silence(self, subscription: Subscription[Any]) -> str:
        """Explain why a topic has no messages: nobody publishes it, its type or QoS differs, or it is silent."""
        topic, wanted = subscription.topic, subscription.kind
        others = self._others(self._published, f"rt{topic}")
        if not others:
            return f"Nobody publishes {topic} ({ros_type(wanted)}) on ROS domain {self.domain} of {self.where}."
        for endpoint in others:
            if endpoint.type_name != wanted.__idl_typename__:
                return f"{topic} is published as {readable(endpoint.type_name)}, and {ros_type(wanted)} was expected."
            if clash := _clash(offered=endpoint.qos, wanted=qos_of(subscription.options)):
                return f"The QoS of {topic} does not match: {clash}."
        if subscription.newest is None:
            return f"{topic} has a publisher, but no message came."
        age_s = time.monotonic() - subscription.newest[0]
        return f"The last message of {topic} is {age_s:.1f} s old."

    def deafness(self, topic: str, kind: Any, options: CommandOptions, writer: Any) -> str:
        """Explain why nobody receives what `writer` publishes; empty if somebody does."""
        if writer.get_matched_subscriptions():
            return ""
        for endpoint in self._others(self._subscribed, f"rt{topic}"):
            if endpoint.type_name != kind.__idl_typename__:
                return f"{topic} is subscribed as {readable(endpoint.type_name)}, and this publishes {ros_type(kind)}."
            if clash := _clash(offered=qos_of(options), wanted=endpoint.qos):
                return f"The QoS of {topic} does not match: {clash}."
        return f"Nobody subscribes to {topic} ({ros_type(kind)}) on ROS domain {self.domain} of {self.where}."

    @property
    def where(self) -> str:
        return f"interface {self.interface}" if self.interface else "the network"

    def _others(self, reader: Any, dds_topic: str) -> list[Any]:
        return [one for one in self._there(reader) if one.topic_name == dds_topic]

    def _there(self, reader: Any) -> list[Any]:
        """The endpoints of others that live."""
        own = self._participant.guid
        alive = ReadCondition(reader, ViewState.Any | SampleState.Any | InstanceState.Alive)
        there = [one for one in reader.read(2000, alive) if getattr(one, "topic_name", "")]
        return [one for one in there if one.participant_key != own]


_joining = threading.Lock()
_domains: dict[int, tuple[str, Domain]] = {}  # cyclonedds wants a domain configured once a process


def _join(domain: int, xml: str) -> None:
    with _joining:
        if domain not in _domains:
            _domains[domain] = xml, Domain(domain, xml)
        elif _domains[domain][0] != xml:
            raise RobotBusy(f"this process uses ROS domain {domain} with another interface or other peers already")


def _clash(offered: Qos, wanted: Qos) -> str:
    """Which policy of a subscription is stricter than that of its publisher; empty if none is."""
    if wanted[Policy.Reliability] is not None and _reliable(wanted) and not _reliable(offered):
        return "it is offered as best_effort and wanted as reliable; set reliability"
    if _kept(wanted) > _kept(offered):
        return "it is offered as volatile and wanted as transient_local; set durability"
    return ""


def _reliable(qos: Qos) -> bool:
    return isinstance(qos[Policy.Reliability], Policy.Reliability.Reliable)


def _kept(qos: Qos) -> int:
    order = (Policy.Durability.Volatile, Policy.Durability.TransientLocal)
    return order.index(qos[Policy.Durability]) if qos[Policy.Durability] in order else len(order)
