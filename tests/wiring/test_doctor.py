"""`agentrob doctor`: its findings and advice, and that it moves nothing without an option."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import httpx2
import pytest

from agentrob.config.load import Config
from agentrob.config.robots import FenceConfig, LimitsConfig, RobotConfig
from agentrob.errors import ConfigError
from agentrob.model import Pose, RobotState
from agentrob.robots.diagnostics import findings, network
from agentrob.robots.diagnostics.findings import Finding, Status
from agentrob.wiring.doctor import robot as doctor

REAL = RobotConfig(model="go2", interface="eth0", owner="olga")


# ------------------------------------------------------------------ diagnoses
@pytest.mark.parametrize(
    ("percent", "status"),
    [(87, "ok"), (20, "warning"), (14.9, "bad"), (0, "bad"), (None, "unknown"), (math.nan, "unknown")],
)
def test_the_battery_is_compared_with_the_owners_level(percent: float | None, status: str) -> None:
    found = findings.of_battery(percent, REAL)
    assert found.status == status
    assert bool(found.advice) is (status != "ok")


@pytest.mark.parametrize(
    ("mode", "status", "said"),
    [
        ("idle", "ok", ""),
        ("damping", "bad", "remote"),
        ("fallen", "bad", "stand up"),
        ("walking", "bad", "Another program or remote moves it"),
        ("lying", "warning", "stand"),
        ("unknown", "warning", "10 cm"),
    ],
)
def test_each_mode_has_its_advice(mode: str, status: str, said: str) -> None:
    found = findings.of_state(RobotState(0.0, Pose(0, 0, 0), mode=mode, upright=True, error_code=7))[0]
    assert (found.check, found.status, found.found) == ("mode", status, f"{mode} (code 7)")
    assert said in found.advice


def test_an_unknown_value_is_never_reported_as_good() -> None:
    found = findings.of_state(RobotState(0.0))
    assert [f.check for f in found if f.status is Status.BAD] == ["attitude", "odometry"]


@pytest.mark.parametrize(
    ("hertz", "gap_s", "status"),
    [(50, 0.03, "ok"), (15, 0.1, "warning"), (50, 0.3, "warning"), (3, 0.4, "bad"), (50, 0.6, "bad")],
)
def test_a_low_rate_of_states_is_reported(hertz: float, gap_s: float, status: str) -> None:
    assert findings.of_rate(hertz, gap_s).status == status


def test_missing_ranges_prevent_walking_unless_the_owner_consents() -> None:
    known = (2.0, None, 1.0, 3.0)
    assert findings.of_ranges((2.0, 1.0, 1.0, 3.0), REAL).status is Status.OK
    dead = findings.of_ranges(known, REAL)
    assert (dead.status, "to the left" in dead.found, "behind" in dead.found) == (Status.BAD, True, False)
    assert findings.of_ranges(known, REAL.model_copy(update={"allow_unknown_ranges": True})).status is Status.WARNING


def test_a_new_real_robot_should_have_low_limits_a_small_fence_and_an_owner() -> None:
    first = RobotConfig(
        model="go2",
        owner="olga",
        limits=LimitsConfig(speed_mps=0.2),
        fence=FenceConfig(x_min_m=-1, x_max_m=2, y_min_m=-1, y_max_m=1),
    )
    assert findings.of_settings(first) == []
    assert [f.check for f in findings.of_settings(RobotConfig(model="go2"))] == ["limits", "owner"]
    assert findings.of_settings(RobotConfig(model="go2", simulated=True)) == []


# ------------------------------------------------------------------ the interface
@pytest.mark.parametrize(
    ("interface", "simulated", "at", "link", "status", "said"),
    [
        ("nosuch0", False, "", "1", "bad", "is not on this machine"),
        ("lo", False, "127.0.0.1", "1", "warning", "only what runs on this machine"),
        ("lo", True, "127.0.0.1", "1", "ok", "127.0.0.1"),
        ("eth0", False, "192.168.123.99", "1", "ok", "192.168.123.99"),
        ("eth0", False, "10.0.0.2", "1", "warning", "10.0.0.2"),
        ("eth0", False, "", "1", "bad", "no address"),
        ("eth0", False, "192.168.123.99", "0", "bad", "no link"),
    ],
)
def test_an_interface_that_cannot_reach_a_robot_is_told(
    monkeypatch: pytest.MonkeyPatch, interface: str, simulated: bool, at: str, link: str, status: str, said: str
) -> None:
    monkeypatch.setattr(network.socket, "if_nameindex", lambda: [(1, "lo"), (2, "eth0"), (3, "eth1")])
    monkeypatch.setattr(network, "address", lambda name: at if name == interface else "192.168.123.50")
    monkeypatch.setattr(network, "_carrier", lambda _: link)
    settings = RobotConfig(interface=interface, simulated=simulated)
    found = network.interface_finding(settings)
    assert (found.status, said in found.found) == (status, True), found
    assert bool(found.advice) is (status != "ok")


def test_the_other_interfaces_are_named_the_robots_network_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(network.socket, "if_nameindex", lambda: [(1, "lo"), (2, "a0"), (3, "b0"), (4, "c0")])
    monkeypatch.setattr(network, "address", lambda n: {"b0": "10.0.0.1", "c0": "192.168.123.7"}.get(n, ""))
    assert network.others("a0") == "c0 (192.168.123.7), b0 (10.0.0.1)"


def test_the_address_of_loopback_is_found() -> None:
    assert network.address("lo") == "127.0.0.1"
    assert network.address("nosuch0") == ""


# ------------------------------------------------------------------ the choice of a robot, and robots without a network
def test_a_robot_is_chosen_by_name_or_kind_and_its_network_by_option() -> None:
    config = Config(robots={"rex": RobotConfig(model="go2", domain=3, simulated=True)})
    assert doctor.chosen(None, config, None, None) == ("rex", config.robots["rex"])
    assert doctor.chosen("rex", config, "eth1", 4)[1].domain == 4
    name, real = doctor.chosen("g1", config, "eth1", None)
    assert (name, real.model, real.interface, real.domain, real.simulated) == ("g1", "g1", "eth1", 0, False)
    assert doctor.chosen("g1", config, None, 7)[1].simulated
    with pytest.raises(ConfigError, match="installed robots: fake, g1, go2"):
        doctor.chosen("unicorn", config, None, None)
    with pytest.raises(ConfigError, match="0 to 230"):
        doctor.chosen("go2", config, None, 999)


def test_a_halt_is_reported_with_how_to_end_it(tmp_path: Path) -> None:
    (tmp_path / "drivers").mkdir()
    (tmp_path / "drivers" / "spot.halt").write_text('{"why": "Halted by olga: smoke"}')
    name = f"{os.getpid()}"
    settings = RobotConfig(model="fake", simulated=True, domain=1 + int(name) % 200)
    found = doctor.examine("spot", settings, Config(data=str(tmp_path)))
    assert [(f.check, f.status) for f in found] == [("driver", Status.OK), ("halt", Status.BAD)]
    assert "smoke" in found[1].found
    assert found[1].command == "agentrob release spot"


def spawn(*words: str, **env: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "agentrob", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, **env},
    )


class DoctorRun(NamedTuple):
    """The output and exit code of a run of the doctor."""

    code: int
    facts: dict[str, Any]

    def of(self, check: str) -> dict[str, Any]:
        return next(f for f in self.facts["findings"] if f["check"] == check)

    @property
    def bad(self) -> set[str]:
        return {f["check"] for f in self.facts["findings"] if f["status"] == "bad"}


def doctor_run(process: subprocess.Popen[str]) -> DoctorRun:
    out, err = process.communicate(timeout=100)
    assert out, err
    return DoctorRun(process.returncode, json.loads(out))


def test_a_robot_with_a_driver_is_examined_through_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AGENTROB_RUNTIME", str(tmp_path))
    settings = RobotConfig(model="fake", simulated=True, home_on_start=True, domain=1 + os.getpid() % 200)
    config = Config(data=str(tmp_path), robots={"held": settings})
    config.write(tmp_path / "agentrob.toml")
    driver = spawn("driver", "held", "--config", str(tmp_path / "agentrob.toml"))
    try:
        assert driver.stdout is not None
        assert json.loads(driver.stdout.readline())["ready"]
        found = {f.check: f for f in doctor.examine("held", settings, config)}
        assert "this is what it says" in found["driver"].found
        assert found["battery"] == Finding("battery", Status.OK, "87 %")
        assert found["mode"].found.startswith("idle")
        monkeypatch.setenv("AGENTROB_RUNTIME", str(tmp_path / "elsewhere"))  # it may belong to another user
        hidden = doctor.examine("held", settings, config)
        assert [(f.check, f.status) for f in hidden] == [("driver", Status.BAD)]
        assert hidden[0].command == "agentrob stop --all"
    finally:
        driver.kill()
        driver.communicate()


def test_read_only_and_move_exclude_each_other(tmp_path: Path) -> None:
    run = spawn("doctor", "fake", "--read-only", "--move")
    _, err = run.communicate(timeout=100)
    assert (run.returncode, "--read-only and --move exclude each other" in err) == (2, True)


# ------------------------------------------------------------------ with a simulated Go2 and G1
#: Domains that no other test file uses; the last one stays empty.
DOMAINS, EMPTY_DOMAIN = range(201, 211), 230


class SimulatedRobots(NamedTuple):
    """A world with both robots, whose cameras use ray casting only."""

    room: httpx2.Client
    go2: int
    g1: int
    folder: Path

    def doctor(self, *words: str) -> subprocess.Popen[str]:
        env = {"AGENTROB_RUNTIME": str(self.folder), "AGENTROB_DATA": str(self.folder)}
        return spawn("doctor", *words, "--json", **env)

    def place_m(self, robot: str) -> tuple[float, float]:
        at = self.room.get("/truth").json()["robots"][robot]
        return at["x_m"], at["y_m"]


@pytest.fixture(scope="module")
def robots(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SimulatedRobots]:
    for go2, g1 in zip(DOMAINS[::2], DOMAINS[1::2], strict=True):
        world = spawn("sim", "--domain", f"go2={go2}", "--domain", f"g1={g1}", MUJOCO_GL="off")
        assert world.stdout is not None
        if line := world.stdout.readline():
            break
    with httpx2.Client(base_url=json.loads(line)["http"], timeout=100) as room:
        yield SimulatedRobots(room, go2, g1, tmp_path_factory.mktemp("doctor"))
    world.terminate()
    world.communicate(timeout=100)


@pytest.mark.sim
def test_a_healthy_go2_is_reported_and_found_on_another_domain(robots: SimulatedRobots) -> None:
    before = robots.place_m("go2")
    runs = {
        "well": robots.doctor("go2", "--domain", str(robots.go2), "--read-only"),
        "domain": robots.doctor("go2", "--domain", str(EMPTY_DOMAIN)),
    }
    said = {name: doctor_run(run) for name, run in runs.items()}
    well = said["well"]
    assert (well.code, well.bad, well.facts["moved"]) == (0, set(), False), well
    assert well.of("service sport")["found"].startswith("answers in ")
    assert "'mcf'" in well.of("motion service")["found"]
    assert well.of("battery")["status"] == "ok"
    assert well.of("camera")["found"].startswith("a picture of ")
    assert (said["domain"].code, said["domain"].bad) == (1, {"domain"})
    assert f"a go2 on domain {robots.go2}" in said["domain"].of("domain")["found"]
    assert math.dist(before, robots.place_m("go2")) < 0.03


#: Another program that can command the robot: the vendor's own client. It waits until its standard input ends.
ANOTHER = """
import os, sys
from agentrob.robots.unitree import sdk
sdk.connect(int(sys.argv[1]), "lo")
from unitree_sdk2py.go2.sport.sport_client import SportClient
sdk.clients((SportClient, 1.0))
print("there", flush=True)
sys.stdin.read()
os._exit(0)
"""


@pytest.mark.sim
@pytest.mark.slow
def test_another_kind_a_missing_interface_and_other_commanders_are_reported(robots: SimulatedRobots) -> None:
    command = [sys.executable, "-c", ANOTHER, str(robots.go2)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as another:
        assert another.stdout is not None
        assert another.stdout.readline().strip() == "there"
        kind = doctor_run(robots.doctor("go2", "--domain", str(robots.g1)))
        assert (kind.code, kind.bad) == (1, {"domain"})
        assert "a g1 is heard" in kind.of("domain")["found"]
        absent = doctor_run(robots.doctor("go2", "--interface", "nosuch0"))
        assert (absent.code, absent.bad) == (1, {"interface"})
        busy = doctor_run(robots.doctor("go2", "--domain", str(robots.go2)))
        assert (busy.code, busy.of("commanders")["status"]) == (0, "warning")
        assert busy.of("commanders")["found"].startswith("1 other program can command it")
        another.kill()


@pytest.mark.sim
@pytest.mark.slow
def test_a_healthy_g1_is_reported_with_its_missing_features(robots: SimulatedRobots) -> None:
    found = doctor_run(robots.doctor("g1", "--domain", str(robots.g1)))
    assert (found.code, found.bad) == (0, set()), found
    assert "ready to walk" in found.of("motion state")["found"]
    assert found.of("ranges")["status"] == "warning"
    assert found.of("battery")["status"] == "unknown"


@pytest.mark.sim
@pytest.mark.slow
def test_faults_of_a_robot_are_found_without_moving_it(robots: SimulatedRobots) -> None:
    faults = {"battery_percent": 9, "ranges": "zero", "camera": "black", "lost": True, "drops": 1.0}
    assert robots.room.post("/faults", json=faults).status_code == 200
    try:
        before = robots.place_m("go2")
        found = doctor_run(robots.doctor("go2", "--domain", str(robots.go2), "--move"))
        assert found.code == 1
        assert {"battery", "ranges", "odometry"} <= found.bad
        assert "all black" in found.of("camera")["found"]
        assert (found.facts["moved"], found.of("move")["status"]) == (False, "unknown")
        assert math.dist(before, robots.place_m("go2")) < 0.03
    finally:
        robots.room.post("/faults", json={})


@pytest.mark.sim
@pytest.mark.slow
@pytest.mark.parametrize("robot", ["go2", "g1"])
def test_with_move_it_moves_ten_centimetres(robots: SimulatedRobots, robot: str) -> None:
    before = robots.place_m(robot)
    found = doctor_run(robots.doctor(robot, "--domain", str(getattr(robots, robot)), "--move"))
    assert (found.code, found.facts["moved"]) == (0, True), found
    assert found.of("move")["found"].startswith("Asked 0.1 m")
    assert 0.04 < math.dist(before, robots.place_m(robot)) < 0.18
