"""Simulations that packages of robots bring along, found by the entry points `agentrob.simulators`.

The simulated world has bodies for a Go2 and a G1. A robot of another package may come with a simulation of its own,
which `agentrob demo --robot KIND` and `agentrob drive KIND` run in a process of its own: `agentrob simulator KIND`.
"""

from __future__ import annotations

from agentrob.config.robots import RobotConfig
from agentrob.plugins import find, names
from agentrob.process.host_lock import HostLock
from agentrob.process.signals import event_at_termination
from agentrob.robots.protocol import Simulator


def has_simulator(model: str) -> bool:
    """Whether the package of this kind of robot brings a simulation."""
    return model in names("simulators")


def make_simulator(model: str) -> Simulator:
    """The simulation of a kind of robot. Raises `ConfigError` if its package brings none, or cannot be loaded."""
    simulator: Simulator = find("simulators", model)()
    return simulator


def prepared(settings: RobotConfig) -> RobotConfig:
    """The settings of a simulated robot as its simulation wants them; unchanged if there is none.

    Raises `SimError`, which says what must be installed.
    """
    return make_simulator(settings.model).settings(settings) if has_simulator(settings.model) else settings


def serve_simulator(model: str, domain: int, interface: str) -> None:
    """Run the simulation of a robot until SIGTERM or Ctrl-C; prints the ready line.

    Raises `RobotBusy` if something is simulated on this domain already, else as `make_simulator` and `Simulator.serve`.
    """
    ended = event_at_termination()
    settings = RobotConfig(model=model, domain=domain, interface=interface, simulated=True, home_on_start=True)
    simulator = make_simulator(model)
    with HostLock(world_lock(settings), f"the simulation on DDS domain {domain} ({interface})"):
        simulator.serve(simulator.settings(settings), ended)


def world_lock(settings: RobotConfig) -> str:
    """The host lock of whatever is simulated on a domain: it marks the domain as taken."""
    return f"world/{settings.interface}/{settings.domain}"
