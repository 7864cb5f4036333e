"""Diagnoses a Unitree robot over its own network. Only reads, never moves anything.

Requests sent to the robot: the version of each service (API id 1), which mode is active, and one picture.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

from agentrob.config.robots import RobotConfig
from agentrob.errors import RobotUnreachable
from agentrob.model import Op, RobotState
from agentrob.robots.control.picture_check import picture_problem
from agentrob.robots.diagnostics import findings, network
from agentrob.robots.diagnostics.findings import Finding, Status
from agentrob.robots.safety.ranges import RangeMonitor
from agentrob.robots.unitree import g1, g1_fsm, go2, sdk
from agentrob.robots.unitree import robot as unitree_robot

#: Seconds to listen to the state, to wait for a robot, for each of its services, and for a picture.
LISTEN_S, FIND_S, ASK_S, IMAGE_S = 1.5, 3.0, 1.0, 3.0
VERSION, CHECK_MODE, GET_IMAGE = 1, 1001, 1001
NOBODY = (
    "Is it switched on, and standing (it takes a minute)? Is the cable in? "
    f"Does it answer: ping {network.ROBOTS_ADDRESS}? A firewall on this machine may hold back UDP."
)


class Service(NamedTuple):
    """A service that the driver uses. `needed`: without it the driver cannot move the robot. `version`: the SDK's."""

    name: str
    what: str
    needed: bool
    version: str


SERVICES = {
    "go2": (
        Service("sport", "moves it", True, "1.0.0.1"),
        Service("videohub", "pictures", False, "1.0.0.1"),
        Service("motion_switcher", "which motion service is active", False, "1.0.0.1"),
    ),
    "g1": (
        Service("sport", "moves it", True, "1.0.0.0"),
        Service("arm", "gestures", False, "1.0.0.14"),
        Service("videohub", "pictures, by our convention", False, "1.0.0.1"),
    ),
}
STATE_TOPICS = {"go2": "rt/sportmodestate", "g1": "rt/odommodestate"}


def examine(settings: RobotConfig) -> list[Finding]:
    """Examine a Go2 or a G1 that no driver holds; findings come in the order in which to fix them.

    One call a process: it joins the robot's DDS domain, as a driver would.
    """
    interface = network.interface_finding(settings)
    if interface.status is Status.BAD:
        return [interface]
    try:
        sdk.connect(settings.domain, settings.interface)
    except RobotUnreachable as e:
        advice = "Name an interface that DDS can use; `ip link` shows those that are up."
        return [replace(interface, status=Status.BAD, found=str(e), advice=advice)]
    heard = network.listen(settings.domain, FIND_S, settings.model)
    if heard.kind != settings.model:
        return [interface, _nobody(settings, heard)]
    found = [interface, Finding("domain", Status.OK, f"a {heard.kind} is heard on domain {settings.domain}")]
    if heard.commanders:
        many = "program" if heard.commanders == 1 else "programs"
        what = f"{heard.commanders} other {many} can command it (its app and its own programs count too)"
        advice = "Programs that command the same robot disturb each other: close the others before you start an agent."
        found.append(Finding("commanders", Status.WARNING, what, advice))
    return [*found, *_services(settings), *_body(settings), *findings.of_settings(settings)]


def _nobody(settings: RobotConfig, heard: network.DomainContents) -> Finding:
    """Finding for a robot that is not on this domain; searches the others."""
    where = f"domain {settings.domain} of {settings.interface}"
    if heard.kind:
        advice = f'Set model = "{heard.kind}", or look at the cable: that is another robot.'
        return Finding("domain", Status.BAD, f"on {where} a {heard.kind} is heard, not a {settings.model}", advice)
    elsewhere = network.search(settings.interface, settings.domain)
    what = f"no {settings.model} is heard on {where}"
    if elsewhere:
        there = ", ".join(f"a {other.kind} on domain {other.domain}" for other in elsewhere)
        again = f"agentrob doctor {settings.model} --interface {settings.interface} --domain {elsewhere[0].domain}"
        advice = "Set domain to that one (real robots are on 0)."
        return Finding("domain", Status.BAD, f"{what}, but {there}", advice, again)
    if settings.simulated:
        start = f"agentrob sim --domain {settings.model}={settings.domain} --interface {settings.interface}"
        return Finding("domain", Status.BAD, what, "Start its world.", start)
    zero = "" if settings.domain == 0 else " Real robots are on domain 0."
    return Finding("domain", Status.BAD, what, NOBODY + zero, f"ping -c 3 {network.ROBOTS_ADDRESS}")


# ------------------------------------------------------------------ services
def _client(service: str, timeout_s: float) -> tuple[Callable[[], Any], float]:
    """For `sdk.clients`: the SDK's client of a service, with the version call only."""

    def make() -> Any:
        from unitree_sdk2py.rpc.client import Client

        class Reader(Client):  # type: ignore[misc]
            def Init(self) -> None:  # noqa: N802  the SDK's name
                pass

        return Reader(service, False)

    return make, timeout_s


def _services(settings: RobotConfig) -> list[Finding]:
    """Check which services answer and their versions, the active mode, and a picture."""
    services = SERVICES[settings.model]
    made = sdk.clients(*(_client(s.name, IMAGE_S if s.name == "videohub" else ASK_S) for s in services))
    clients = dict(zip((s.name for s in services), made, strict=True))
    with ThreadPoolExecutor(len(services)) as pool:
        found = list(pool.map(lambda s: _answers(settings, s, clients[s.name]), services))
    if "motion_switcher" in clients and found[2].status is Status.OK:
        found.append(_active_mode(clients["motion_switcher"]))
    if "arm" in clients and found[0].status is Status.OK:
        found.append(_fsm(clients["sport"]))
    return [*found, _camera(settings, clients["videohub"], found[[s.name for s in services].index("videohub")])]


def _answers(settings: RobotConfig, service: Service, client: Any) -> Finding:
    asked_s = time.monotonic()
    code, version = client._CallBase(VERSION, "{}")
    took_ms = 1000 * (time.monotonic() - asked_s)
    check = f"service {service.name}"
    if code == 0:
        found = f"answers in {took_ms:.1f} ms, version {version} ({service.what})"
        if version == service.version:
            return Finding(check, Status.OK, found)
        advice = f"The SDK here was made for {service.version}: try each operation with a hand on the remote first."
        return Finding(check, Status.WARNING, found, advice)
    found = f"{sdk.explain(code)} ({service.what})"
    if service.needed:
        return Finding(check, Status.BAD, found, _no_motion(settings))
    if service.name == "videohub" and settings.model == "g1" and not settings.simulated:
        return Finding(check, Status.OK, "not there, as on every real G1", "")
    return Finding(check, Status.WARNING, found, "Without it the driver does the rest; is the firmware complete?")


def _no_motion(settings: RobotConfig) -> str:
    if settings.model == "g1":
        return "Its motion service does not run (it was `loco` in older firmware): start it with the remote, or update."
    return "Its motion service does not run: restart the robot, and select the sport mode in its app."


def _active_mode(client: Any) -> Finding:
    code, data = client._CallBase(CHECK_MODE, "{}")
    try:
        name = str(json.loads(data)["name"]) if code == 0 else ""
    except (ValueError, KeyError, TypeError):
        name = ""
    if name:
        return Finding("motion service", Status.OK, f"{name!r} is active")
    advice = "Select the sport mode in the robot's app: a robot that was released to low-level control does not walk."
    return Finding("motion service", Status.BAD if code == 0 else Status.UNKNOWN, "none is active", advice)


def _fsm(client: Any) -> Finding:
    code, data = client._CallBase(g1_fsm.GET_FSM_ID, "{}")
    fsm = g1_fsm.parse(data) if code == 0 else None
    if fsm is None:
        advice = "Without it the driver does not know whether it stands, and moves nothing."
        return Finding("motion state", Status.BAD, "it does not report its state (7001)", advice)
    if fsm in g1_fsm.WALKING or fsm == g1_fsm.LOCKED:
        return Finding("motion state", Status.OK, f"{fsm} ({g1_fsm.MODES.get(fsm, 'ready to walk')})")
    advice = "Make it stand with its remote; the driver unlocks only a standing robot."
    return Finding("motion state", Status.BAD, f"{fsm} ({g1_fsm.MODES.get(fsm, 'unknown to us')})", advice)


def _camera(settings: RobotConfig, client: Any, service: Finding) -> Finding:
    if settings.model == "g1" and Op.GET_FRONT_IMAGE not in g1.G1.describe(settings).ops:
        advice = "If another program serves videohub for it, set options.videohub = true."
        return Finding("camera", Status.OK, "a real G1 serves no pictures on DDS; none are offered", advice)
    if "answers" not in service.found:
        return Finding("camera", Status.WARNING, "no picture: its service does not answer", "Walking works without.")
    asked_s = time.monotonic()
    code, data = client._CallBinaryBase(GET_IMAGE, [], 0, 0)
    if code in sdk.NO_ANSWER:  # the first picture may take longer than any other
        asked_s = time.monotonic()
        code, data = client._CallBinaryBase(GET_IMAGE, [], 0, 0)
    took_ms = 1000 * (time.monotonic() - asked_s)
    if code:
        return Finding("camera", Status.WARNING, f"no picture: {sdk.explain(code)}", "Restart the robot.")
    image = bytes(data or ())
    if sentence := picture_problem(image):
        return Finding("camera", Status.WARNING, sentence, "Look at the lens, and for light.")
    return Finding("camera", Status.OK, f"a picture of {len(image) / 1024:.0f} KiB in {took_ms:.0f} ms")


# ------------------------------------------------------------------ the body
def _body(settings: RobotConfig) -> list[Finding]:
    """Check state, mode, position, ranges and battery."""
    from unitree_sdk2py.idl.unitree_go.msg.dds_ import LowState_, SportModeState_

    battery = sdk.PolledTopic("rt/lowstate", LowState_, every_s=1.0) if settings.model == "go2" else None
    times, states = _listened(STATE_TOPICS[settings.model], SportModeState_, settings.model)
    percent = None if battery is None or battery.newest is None else float(battery.newest.bms_state.soc)
    if battery is not None:
        battery.close()
    charge = findings.of_battery(percent, settings)
    if len(times) < 2:
        return [Finding("state", Status.BAD, f"no message on {STATE_TOPICS[settings.model]}", NOBODY), charge]
    gaps = [later - sooner for sooner, later in pairwise(times)]
    rate = findings.of_rate(len(gaps) / (times[-1] - times[0]), max(gaps))
    body = findings.of_state(states[-1])
    if settings.model == "g1":  # its mode is the state of its motion service, which was asked already
        body = [f for f in body if f.check != "mode"]
    ranges = RangeMonitor()
    for at_s, state in list(zip(times, states, strict=True))[:: 1 + len(times) // 50]:  # at the guard's rate
        ranges.update(at_s, state)
    return [rate, *body, findings.of_ranges(ranges.known(), settings), charge]


def _listened(name: str, kind: Any, model: str) -> tuple[list[float], list[RobotState]]:
    """Listen for a moment; return when states arrived and what they were."""
    from unitree_sdk2py.core.channel import ChannelSubscriber

    came: list[tuple[float, Any]] = []
    subscriber = ChannelSubscriber(name, kind)
    subscriber.Init(lambda message: came.append((time.monotonic(), message)), 0)
    end_s = time.monotonic() + FIND_S
    while not came and time.monotonic() < end_s:
        time.sleep(0.02)
    time.sleep(LISTEN_S)
    subscriber.Close()
    read = go2.read if model == "go2" else unitree_robot.read
    return [at_s for at_s, _ in came], [read(message) for _, message in came]
