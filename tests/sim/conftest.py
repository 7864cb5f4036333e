"""Fixtures of the simulated world: one without a network in simulated time, and one served by a separate process."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import pytest

from agentrob.sim.bodies.go2 import Go2
from agentrob.sim.event_log import EventLog
from agentrob.sim.services.go2_sport import MOVE, STOP_MOVE, Sport
from agentrob.sim.world.legged import PERIOD_S
from agentrob.sim.world.scene import OPEN_FLOOR
from agentrob.sim.world.world import World
from tests.sim.served_world import ServedWorld, start_world


@dataclass
class Bench:
    """A Go2 with its sport service in simulated time."""

    world: World
    body: Go2
    sport: Sport
    answers: list[int] = field(default_factory=list)

    def run(self, seconds: float, until: Callable[[], bool] = lambda: False) -> float:
        """Let simulated time pass; return how much did."""
        ticks = round(seconds / PERIOD_S)
        for tick in range(ticks):
            if until():
                return tick * PERIOD_S
            self.sport.tick()
            self.world.tick()
        return seconds

    def call(self, api_id: int, parameter: Mapping[str, Any] | None = None, limit_s: float = 20.0) -> int:
        """Call and let time pass until it is answered."""
        answers: list[int] = []
        self.sport.call(api_id, parameter or {}, answers.append)
        self.run(limit_s, lambda: bool(answers))
        assert len(answers) == 1
        return answers[0]

    def walk(self, seconds: float, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> None:
        """Send Move at 10 Hz, then StopMove."""
        for _ in range(round(seconds / 0.1)):
            self.call(MOVE, {"x": x, "y": y, "z": z})
            self.run(0.1)
        self.call(STOP_MOVE)

    def reset(self) -> Bench:
        self.world.reset()
        self.sport.reset()
        return self


@pytest.fixture(scope="session")
def open_floor_bench() -> Bench:
    body = Go2()
    world = World([body], OPEN_FLOOR)
    return Bench(world, body, Sport(body, lambda: world.time_s, EventLog()))


@pytest.fixture
def bench(open_floor_bench: Bench) -> Bench:
    """A Go2 at its start on an endless floor."""
    return open_floor_bench.reset()


@pytest.fixture(scope="session")
def furnished_bench() -> Bench:
    body = Go2()
    world = World([body])
    return Bench(world, body, Sport(body, lambda: world.time_s, EventLog()))


@pytest.fixture
def room_bench(furnished_bench: Bench) -> Bench:
    """A Go2 at its start in the furnished room."""
    return furnished_bench.reset()


@pytest.fixture(scope="session")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ServedWorld]:
    """One served world for all tests that do not end it."""
    world = start_world(tmp_path_factory.mktemp("world"))
    yield world
    if world.process.poll() is None:
        world.end()
