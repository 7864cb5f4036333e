"""`agentrob doctor`: what it finds, what it advises, and that it moves nothing unless told to."""

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
from agentrob.wiring import doctor

REAL = RobotConfig(model="go2", interface="eth0", owner="olga")


# ------------------------------------------------------------------ what follows from what is known
@pytest.mark.parametrize(
    ("percent", "status"),
    [(87, "ok"), (20, "warning"), (14.9, "bad"), (0, "bad"), (None, "unknown"), (math.nan, "unknown")],
)
def test_a_battery_is_held_against_the_owners_level(percent: float | None, status: str) -> None:
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


def test_what_is_unknown_is_never_called_well() -> None:
    found = findings.of_state(RobotState(0.0))
    assert [f.check for f in found if f.status is Status.BAD] == ["attitude", "odometry"]


@pytest.mark.parametrize(
    ("hertz", "gap_s", "status"),
    [(50, 0.03, "ok"), (15, 0.1, "warning"), (50, 0.3, "warning"), (3, 0.4, "bad"), (50, 0.6, "bad")],
)
def test_states_that_come_too_seldom_are_told(hertz: float, gap_s: float, status: str) -> None:
    assert findings.of_rate(hertz, gap_s).status == status


def test_dead_ranges_keep_a_robot_from_walking_unless_its_owner_consents() -> None:
    known = (2.0, None, 1.0, 3.0)
    assert findings.of_ranges((2.0, 1.0, 1.0, 3.0), REAL).status is Status.OK
    dead = findings.of_ranges(known, REAL)
    assert (dead.status, "to the left" in dead.found, "behind" in dead.found) == (Status.BAD, True, False)
    assert findings.of_ranges(known, REAL.model_copy(update={"allow_unknown_ranges": True})).status is Status.WARNING


def test_a_first_contact_wants_slow_limits_a_small_fence_and_an_owner() -> None:
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


def test_the_address_of_loopback_is_read() -> None:
    assert network.address("lo") == "127.0.0.1"
    assert network.address("nosuch0") == ""


# ------------------------------------------------------------------ which robot, and robots that need no network
def test_a_robot_is_chosen_by_name_or_by_kind_and_its_network_may_be_said() -> None:
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


def test_a_halt_is_told_with_how_it_ends(tmp_path: Path) -> None:
    (tmp_path / "drivers").mkdir()
    (tmp_path / "drivers" / "spot.halt").write_text('{"why": "Halted by olga: smoke"}')
    name = f"{os.getpid()}"
    settings = RobotConfig(model="fake", simulated=True, domain=1 + int(name) % 200)
    found = doctor.examine("spot", settings, Config(data=str(tmp_path)))
    assert [(f.check, f.status) for f in found] == [("driver", Status.OK), ("halt", Status.BAD)]
    assert "smoke" in found[1].found
    assert "agentrob release spot" in found[1].advice


def spawn(*words: str, **env: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "agentrob", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, **env},
    )


class Told(NamedTuple):
    """What a run of the doctor said and how it ended."""

    code: int
    facts: dict[str, Any]

    def of(self, check: str) -> dict[str, Any]:
        return next(f for f in self.facts["findings"] if f["check"] == check)

    @property
    def bad(self) -> set[str]:
        return {f["check"] for f in self.facts["findings"] if f["status"] == "bad"}


def told(process: subprocess.Popen[str]) -> Told:
    out, err = process.communicate(timeout=100)
    assert out, err
    return Told(process.returncode, json.loads(out))


def test_a_robot_that_a_driver_holds_is_asked_through_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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
        monkeypatch.setenv("AGENTROB_RUNTIME", str(tmp_path / "elsewhere"))  # another user's, perhaps
        hidden = doctor.examine("held", settings, config)
        assert [(f.check, f.status) for f in hidden] == [("driver", Status.BAD)]
        assert "stop --all" in hidden[0].advice
    finally:
        driver.kill()
        driver.communicate()


def test_read_only_and_move_contradict_each_other(tmp_path: Path) -> None:
    run = spawn("doctor", "fake", "--read-only", "--move")
    _, err = run.communicate(timeout=100)
    assert (run.returncode, "--read-only and --move exclude each other" in err) == (2, True)


# ------------------------------------------------------------------ with a simulated Go2 and G1
#: Not those of other test files; on the last one is nobody.
DOMAINS, NOBODYS = range(201, 211), 230


class Field(NamedTuple):
    """A world with both robots and no camera but rays."""

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
def field(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Field]:
    for go2, g1 in zip(DOMAINS[::2], DOMAINS[1::2], strict=True):
        world = spawn("sim", "--domain", f"go2={go2}", "--domain", f"g1={g1}", MUJOCO_GL="off")
        assert world.stdout is not None
        if line := world.stdout.readline():
            break
    with httpx2.Client(base_url=json.loads(line)["http"], timeout=100) as room:
        yield Field(room, go2, g1, tmp_path_factory.mktemp("doctor"))
    world.terminate()
    world.communicate(timeout=100)


@pytest.mark.sim
def test_a_go2_that_is_well_is_said_so_and_on_a_wrong_domain_it_is_found(field: Field) -> None:
    before = field.place_m("go2")
    runs = {
        "well": field.doctor("go2", "--domain", str(field.go2), "--read-only"),
        "domain": field.doctor("go2", "--domain", str(NOBODYS)),
    }
    said = {name: told(run) for name, run in runs.items()}
    well = said["well"]
    assert (well.code, well.bad, well.facts["moved"]) == (0, set(), False), well
    assert well.of("service sport")["found"].startswith("answers in ")
    assert "'mcf'" in well.of("motion service")["found"]
    assert well.of("battery")["status"] == "ok"
    assert well.of("camera")["found"].startswith("a picture of ")
    assert (said["domain"].code, said["domain"].bad) == (1, {"domain"})
    assert f"a go2 on domain {field.go2}" in said["domain"].of("domain")["found"]
    assert math.dist(before, field.place_m("go2")) < 0.03


#: Another program that can command the robot: the vendor's own client. Waits until its input ends.
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
def test_another_kind_an_absent_interface_and_others_who_command_the_robot_are_told(field: Field) -> None:
    command = [sys.executable, "-c", ANOTHER, str(field.go2)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as another:
        assert another.stdout is not None
        assert another.stdout.readline().strip() == "there"
        kind = told(field.doctor("go2", "--domain", str(field.g1)))
        assert (kind.code, kind.bad) == (1, {"domain"})
        assert "a g1 is heard" in kind.of("domain")["found"]
        absent = told(field.doctor("go2", "--interface", "nosuch0"))
        assert (absent.code, absent.bad) == (1, {"interface"})
        busy = told(field.doctor("go2", "--domain", str(field.go2)))
        assert (busy.code, busy.of("commanders")["status"]) == (0, "warning")
        assert busy.of("commanders")["found"].startswith("1 other program can command it")
        another.kill()


@pytest.mark.sim
@pytest.mark.slow
def test_a_g1_that_is_well_is_said_so_and_what_it_lacks_is_told(field: Field) -> None:
    found = told(field.doctor("g1", "--domain", str(field.g1)))
    assert (found.code, found.bad) == (0, set()), found
    assert "ready to walk" in found.of("motion state")["found"]
    assert found.of("ranges")["status"] == "warning"
    assert found.of("battery")["status"] == "unknown"


@pytest.mark.sim
@pytest.mark.slow
def test_what_is_wrong_with_a_robot_is_found_and_it_is_not_moved(field: Field) -> None:
    faults = {"battery_percent": 9, "ranges": "zero", "camera": "black", "lost": True, "drops": 1.0}
    assert field.room.post("/faults", json=faults).status_code == 200
    try:
        before = field.place_m("go2")
        found = told(field.doctor("go2", "--domain", str(field.go2), "--move"))
        assert found.code == 1
        assert {"battery", "ranges", "odometry"} <= found.bad
        assert "all black" in found.of("camera")["found"]
        assert (found.facts["moved"], found.of("move")["status"]) == (False, "unknown")
        assert math.dist(before, field.place_m("go2")) < 0.03
    finally:
        field.room.post("/faults", json={})


@pytest.mark.sim
@pytest.mark.slow
@pytest.mark.parametrize("robot", ["go2", "g1"])
def test_only_when_told_to_it_moves_ten_centimetres(field: Field, robot: str) -> None:
    before = field.place_m(robot)
    found = told(field.doctor(robot, "--domain", str(getattr(field, robot)), "--move"))
    assert (found.code, found.facts["moved"]) == (0, True), found
    assert found.of("move")["found"].startswith("Asked 0.1 m")
    assert 0.04 < math.dist(before, field.place_m(robot)) < 0.18
