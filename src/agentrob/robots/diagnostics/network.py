"""Checks the network between this machine and a robot: its interface, and which robots publish on which DDS domains."""

from __future__ import annotations

import contextlib
import fcntl
import socket
import struct
import time
from collections.abc import Collection
from pathlib import Path
from typing import Any, NamedTuple

from agentrob.config.robots import RobotConfig
from agentrob.process import host_lock
from agentrob.robots.diagnostics.findings import Finding, Status

#: The network that Unitree's robots have inside, and the robots' usual address on it.
ROBOTS_NETWORK, ROBOTS_ADDRESS = "192.168.123.", "192.168.123.161"
#: Where else a robot is looked for: real ones are on 0.
DOMAINS = range(10)
_GET_ADDRESS = 0x8915  # SIOCGIFADDR
_STATE_TOPICS = {"rt/sportmodestate": "go2", "rt/odommodestate": "g1"}
_HUMANOID = "unitree_hg"


class DomainContents(NamedTuple):
    """The publishers on a DDS domain. `kind` is go2, g1, or empty without a robot.

    `commanders`: how many programs, besides this process, can tell its motion service something.
    """

    domain: int
    kind: str
    topics: frozenset[str]
    commanders: int


# ------------------------------------------------------------------ the interface
def address(interface: str) -> str:
    """The interface's IPv4 address, or empty."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s, contextlib.suppress(OSError):
        answer = fcntl.ioctl(s.fileno(), _GET_ADDRESS, struct.pack("256s", interface.encode()[:15]))
        return socket.inet_ntoa(answer[20:24])
    return ""


def others(interface: str) -> str:
    """Other interfaces of this machine, the likeliest first."""
    names = [name for _, name in socket.if_nameindex() if name not in (interface, "lo")]
    found = sorted(((address(n), n) for n in names), key=lambda a: not a[0].startswith(ROBOTS_NETWORK))
    return ", ".join(f"{name} ({at or 'no address'})" for at, name in found) or "none"


def interface_finding(settings: RobotConfig) -> Finding:
    """Check whether DDS can reach a robot over this interface."""
    name = settings.interface
    if name not in [other for _, other in socket.if_nameindex()]:
        advice = f"Name one that is there (interface = …, or --interface): {others(name)}; lo for a simulated robot."
        return Finding("interface", Status.BAD, f"{name!r} is not on this machine", advice, "ip link")
    at = address(name)
    if name == "lo":
        if settings.simulated:
            return Finding("interface", Status.OK, f"lo ({at})")
        advice = f"A real robot is behind another one: {others(name)}. For a simulated one set simulated = true."
        return Finding("interface", Status.WARNING, "lo reaches only what runs on this machine", advice)
    if _carrier(name) == "0":
        advice = "Plug the cable in at both ends; is the robot switched on?"
        return Finding("interface", Status.BAD, f"{name} has no link", advice, f"ip link set {name} up")
    if not at:
        advice = "Give it one in the robot's network."
        return Finding("interface", Status.BAD, f"{name} has no address", advice, _give_address(name))
    if not at.startswith(ROBOTS_NETWORK) and not settings.simulated:
        advice = (
            f"Unitree's robots are in {ROBOTS_NETWORK}0/24 by cable ({ROBOTS_ADDRESS}). "
            f"Other interfaces here: {others(name)}."
        )
        return Finding("interface", Status.WARNING, f"{name} ({at})", advice, _give_address(name))
    return Finding("interface", Status.OK, f"{name} ({at})")


def _give_address(name: str) -> str:
    return f"ip addr add {ROBOTS_NETWORK}99/24 dev {name}"


def _carrier(name: str) -> str:
    try:
        return Path(f"/sys/class/net/{name}/carrier").read_text().strip()
    except OSError:  # an interface that is down does not tell
        return "0"


# ------------------------------------------------------------------ who is there
def listen(domain: int, seconds: float, kind: str = "") -> DomainContents:
    """Listen on a domain that this process has joined already; return once a robot of `kind` is heard."""
    from agentrob.process import dds

    return _listen([_DomainReader(domain, dds.DomainParticipant(domain))], seconds, kind)[0]


def search(interface: str, leave_out: int, seconds: float = 1.5) -> list[DomainContents]:
    """Robots on other domains of this interface, also those of simulated worlds on this machine."""
    from agentrob.process import dds  # noqa: I001  first: it patches DDS
    from cyclonedds.core import DDSException
    from cyclonedds.domain import Domain

    worlds = [int(name.rpartition("/")[2]) for name in host_lock.held(f"world/{interface}/")]
    readers = []
    for domain in sorted({*DOMAINS, *worlds} - {leave_out}):
        with contextlib.suppress(DDSException):
            joined = Domain(domain, dds.config(interface))
            readers.append(_DomainReader(domain, dds.DomainParticipant(domain), joined))
    return [heard for heard in _listen(readers, seconds, "") if heard.kind]


class _DomainReader:
    """Reads the names of the topics that others publish, not their data."""

    def __init__(self, domain: int, participant: Any, kept: Any = None) -> None:
        from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication

        self.domain, self._kept = domain, (participant, kept)
        self._reader = BuiltinDataReader(participant, BuiltinTopicDcpsPublication)

    def heard(self, own: Collection[Any]) -> DomainContents:
        there = [p for p in self._reader.read(1000) if getattr(p, "topic_name", "")]
        names = frozenset(p.topic_name for p in there)
        kinds = {_STATE_TOPICS[p.topic_name] for p in there if p.topic_name in _STATE_TOPICS}
        humanoid = any(p.type_name.startswith(_HUMANOID) for p in there)
        kind = "g1" if humanoid or kinds == {"g1"} else "go2" if kinds else ""
        speakers = {p.participant_key for p in there if p.topic_name == "rt/api/sport/request"}
        return DomainContents(self.domain, kind, names, len(speakers - set(own)))


def _listen(readers: list[_DomainReader], seconds: float, kind: str) -> list[DomainContents]:
    end_s, own = time.monotonic() + seconds, _own_participants()
    while True:
        found = [reader.heard(own) for reader in readers]
        if time.monotonic() >= end_s or (kind and any(heard.kind == kind for heard in found)):
            return found
        time.sleep(0.1)


def _own_participants() -> set[Any]:
    from agentrob.process import dds

    return {participant.guid for participant in dds.participants()}
